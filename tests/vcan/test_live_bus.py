"""The daemon's ear on a real SocketCAN bus: every kind of frame, filters, bursts, and a bus that fails."""

import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import can
import pytest

from brake_monitor.bus.can_source import BusError, LiveBus, open_bus
from brake_monitor.errors import InputError
from brake_monitor.frame import CanFilter, Frame, FrameKind
from brake_monitor.settings.config import CanBus

pytestmark = pytest.mark.vcan

BUS = CanBus(interface="socketcan", channel="vcan0", dbc=(), name="front")
ENOUGH_S = 60.0  # longer than any frame takes on the busiest machine


@pytest.fixture
def bus() -> Iterator[LiveBus]:
    with open_bus(BUS, []) as opened:
        yield opened


@pytest.fixture
def interface() -> Iterator[str]:
    """An interface of the test's own, to be taken down or away."""
    name = "vcantest0"
    ip("add", name, "type", "vcan")
    ip("set", name, "up")
    yield name
    subprocess.run(["ip", "link", "del", name], stderr=subprocess.DEVNULL, check=False)


def ip(*arguments: str) -> None:
    subprocess.run(["ip", "link", *arguments], check=True)


def received(bus: LiveBus) -> Frame:
    frame = bus.recv(ENOUGH_S)
    assert frame is not None, "no frame came"
    return frame


@pytest.mark.parametrize(
    "message",
    [
        can.Message(arbitration_id=0x200, is_extended_id=False, data=bytes(range(8))),
        can.Message(arbitration_id=0x200, is_extended_id=True, data=b"\xff"),
        can.Message(arbitration_id=0x1FFFFFFF, is_extended_id=True, data=b""),
        can.Message(arbitration_id=0x7FF, is_extended_id=False, is_fd=True, data=bytes(range(64))),
        can.Message(arbitration_id=0x18FEF100, is_extended_id=True, is_fd=True, bitrate_switch=True, data=bytes(12)),
    ],
    ids=["standard", "extended twin of a standard id", "highest id, no data", "FD of 64 bytes", "extended FD"],
)
def test_a_data_frame_arrives_as_it_was_sent(message: can.Message, bus: LiveBus, sender: can.BusABC) -> None:
    before_s = time.time()
    sender.send(message)
    frame = received(bus)
    identity = (frame.can_id, frame.extended, frame.data)
    assert identity == (message.arbitration_id, message.is_extended_id, bytes(message.data))
    assert (frame.bus, frame.kind) == ("front", FrameKind.DATA)
    assert before_s <= frame.time_s <= time.time()


def test_remote_and_error_frames_are_told_from_data(bus: LiveBus, sender: can.BusABC) -> None:
    sender.send(can.Message(arbitration_id=0x123, is_extended_id=False, is_remote_frame=True, dlc=8))
    # An error frame's id says what went wrong (here: no acknowledgement); it is no message 0x20.
    sender.send(can.Message(arbitration_id=0x20, is_extended_id=False, is_error_frame=True, data=bytes(8)))
    assert [received(bus).kind, received(bus).kind] == [FrameKind.REMOTE, FrameKind.ERROR]


def test_the_kernel_drops_what_the_filters_do_not_name(sender: can.BusABC) -> None:
    filters = [
        {"can_id": 0x200, "can_mask": 0x7FF, "extended": False},
        {"can_id": 0x18FEF100, "can_mask": 0x03FFFF00, "extended": True},  # a PGN: any priority, any source
    ]
    wanted = [(0x200, False), (0x18FEF100, True), (0x0CFEF1AB, True)]
    unwanted = [(0x201, False), (0x200, True), (0x18FEF200, True), (0x100, False)]
    with open_bus(BUS, filters) as bus:
        everything = Path("/proc/net/can/rcvlist_all").read_text()
        for can_id, extended in [*unwanted, *wanted]:
            sender.send(can.Message(arbitration_id=can_id, is_extended_id=extended, data=b"\x01"))
        frames = [received(bus) for _ in wanted]
        assert bus.recv(0.0) is None
    assert [(frame.can_id, frame.extended) for frame in frames] == wanted
    # The fixture's own socket takes everything and is listed once; a second entry would be the daemon's.
    assert everything.count("vcan0") == 1


def test_a_burst_while_the_daemon_is_busy_loses_no_frame(bus: LiveBus, sender: can.BusABC) -> None:
    count = 2000  # a busy 500 kbit/s bus for half a second; the kernel's default buffer would keep 278
    for number in range(count):
        sender.send(can.Message(arbitration_id=0x300, is_extended_id=False, data=number.to_bytes(8, "big")))
    frames = [received(bus) for _ in range(count)]
    assert [int.from_bytes(frame.data, "big") for frame in frames] == list(range(count))
    times_s = [frame.time_s for frame in frames]
    assert times_s == sorted(times_s)


def test_a_silent_bus_is_no_failure(bus: LiveBus) -> None:
    assert bus.recv(0.01) is None


@pytest.mark.parametrize("failure", [("set", "vcantest0", "down"), ("del", "vcantest0")], ids=["down", "gone"])
def test_an_interface_that_fails_is_told_and_can_be_opened_again(failure: tuple[str, ...], interface: str) -> None:
    settings = CanBus(interface="socketcan", channel=interface, dbc=(), name="rear")
    with open_bus(settings, []) as bus:
        ip(*failure)
        with pytest.raises(BusError, match=r'"rear".*vcantest0'):
            bus.recv(ENOUGH_S)
    if failure[0] == "del":
        ip("add", interface, "type", "vcan")
    ip("set", interface, "up")
    with open_bus(settings, []) as bus:
        subprocess.run(["cansend", interface, "123#01"], check=True)
        assert received(bus).data == b"\x01"


def test_an_interface_that_is_down_at_the_start_is_told() -> None:
    ip("add", "vcantest1", "type", "vcan")
    try:
        with (
            pytest.raises(BusError, match="vcantest1"),
            open_bus(CanBus(interface="socketcan", channel="vcantest1", dbc=(), name="rear"), []) as bus,
        ):
            bus.recv(ENOUGH_S)
    finally:
        ip("del", "vcantest1")


def test_an_interface_that_does_not_exist_is_refused_by_name(caplog: pytest.LogCaptureFixture) -> None:
    with pytest.raises(InputError, match="vcan99"):
        open_bus(CanBus(interface="socketcan", channel="vcan99", dbc=(), name="rear"), [])
    assert caplog.records == []


def test_a_bus_that_was_closed_says_so(bus: LiveBus) -> None:
    bus.close()
    with pytest.raises(BusError, match="front"):
        bus.recv(ENOUGH_S)


def test_what_the_kernel_had_no_room_for_is_counted(bus: LiveBus, sender: can.BusABC) -> None:
    flood, number = 40_000, 0  # some 14,000 fit
    for number in range(flood):
        sender.send(can.Message(arbitration_id=0x300, is_extended_id=False, data=number.to_bytes(8, "big")))
    kept = 0
    while bus.recv(0.0) is not None:
        kept += 1
    sender.send(can.Message(arbitration_id=0x301, is_extended_id=False))  # the next frame brings the count along
    while received(bus).can_id != 0x301:  # what the kernel still had on the way
        kept += 1
    assert kept < flood
    assert kept + bus.dropped == flood


def test_more_messages_than_the_kernel_takes_filters_for(sender: can.BusABC) -> None:
    filters = [CanFilter(can_id=number, can_mask=0x7FF, extended=False) for number in range(600)]
    with open_bus(BUS, filters) as bus:
        sender.send(can.Message(arbitration_id=599, is_extended_id=False))
        assert received(bus).can_id == 599
