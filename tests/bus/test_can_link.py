"""What rtnetlink says of an interface, from messages put together here as linux/can/netlink.h has them."""

import errno
import resource
import socket
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from brake_monitor.bus.can_link import CanLink, parse_link, read_link

CAN, ETHERNET = 280, 1  # ARPHRD_*
IFNAME, LINKINFO, KIND, DATA, CTRLMODE, BITTIMING, RESTART_MS = 3, 18, 1, 2, 5, 1, 6
LOOPBACK, LISTEN_ONLY, FD = 0x01, 0x02, 0x20


def attribute(kind: int, content: bytes) -> bytes:
    length = 4 + len(content)
    return struct.pack("=HH", length, kind) + content + bytes(-length % 4)


def link(*attributes: bytes, device: int = CAN, flags: int = 0x81) -> bytes:
    body = struct.pack("=BxHiII", 0, device, 4, flags, 0) + attribute(IFNAME, b"can0\0") + b"".join(attributes)
    return struct.pack("=IHHII", 16 + len(body), 16, 0, 1, 0) + body


def controller(flags: int, kind: bytes = b"can\0") -> bytes:
    data = (
        attribute(BITTIMING, bytes(32))
        + attribute(CTRLMODE, struct.pack("=II", 0, flags))
        + attribute(RESTART_MS, bytes(4))
    )
    return attribute(LINKINFO, attribute(KIND, kind) + attribute(DATA | 0x8000, data))  # nested, as the kernel marks it


@pytest.mark.parametrize(
    ("flags", "listen_only"),
    [(0, False), (LOOPBACK, False), (LISTEN_ONLY, True), (LISTEN_ONLY | FD, True), (FD | LOOPBACK, False)],
)
def test_a_controllers_mode_decides_whether_it_can_disturb(flags: int, listen_only: bool) -> None:
    found = parse_link(link(controller(flags)))
    assert found == CanLink(True, "can", listen_only, True)
    assert found.cannot_disturb is listen_only


@pytest.mark.parametrize("kind", ["vcan", "vxcan"])
def test_a_virtual_bus_has_no_controller_and_no_mode(kind: str) -> None:
    found = parse_link(link(attribute(LINKINFO, attribute(KIND, kind.encode() + b"\0"))))
    assert found == CanLink(True, kind, False, True)
    assert found.cannot_disturb


@pytest.mark.parametrize(
    "attributes",
    [(), (attribute(LINKINFO, attribute(KIND, b"can\0")),), (controller(LISTEN_ONLY, kind=b"other\0"),)],
    ids=["a driver that says nothing", "a controller without a mode", "an unknown kind"],
)
def test_what_does_not_say_that_it_only_listens_is_taken_for_able_to_send(attributes: tuple[bytes, ...]) -> None:
    assert not parse_link(link(*attributes)).cannot_disturb


def test_an_interface_is_up_or_down() -> None:
    assert [parse_link(link(flags=flags)).is_up for flags in (0x81, 0x80)] == [True, False]


def test_another_network_is_no_can_bus() -> None:
    assert not parse_link(link(device=ETHERNET)).is_can


def test_the_kernels_refusal_is_an_error_of_its_number() -> None:
    refusal = struct.pack("=IHHIIi", 36, 2, 0, 1, 0, -errno.ENODEV) + bytes(16)
    with pytest.raises(OSError, match="No such device") as caught:
        parse_link(refusal)
    assert caught.value.errno == errno.ENODEV


@given(st.binary(max_size=200), st.integers(0, 300), st.binary(max_size=20))
def test_no_answer_makes_it_fail_otherwise(random: bytes, place: int, spoilt: bytes) -> None:
    whole = link(controller(0))
    for answer in (random, whole[:place], whole[:place] + spoilt + whole[place + len(spoilt) :]):
        try:
            found = parse_link(answer)
        except OSError:
            continue
        assert isinstance(found, CanLink)


def test_the_loopback_interface_of_this_machine_is_no_can_bus() -> None:
    names = [name for _, name in socket.if_nameindex()]
    assert "lo" in names
    assert read_link("lo") == CanLink(False, "", False, True)


@pytest.mark.parametrize("name", ["nobody0", "x" * 15, "x" * 16, "x" * 5000, ""])
def test_there_is_no_interface_of_another_name(name: str) -> None:
    with pytest.raises(OSError, match="No such device") as caught:
        read_link(name)
    assert caught.value.errno == errno.ENODEV


def test_who_can_open_nothing_is_not_told_that_there_is_no_interface() -> None:
    limits = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (0, limits[1]))
    try:
        with pytest.raises(OSError, match="Too many open files"):
            read_link("lo")
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, limits)
