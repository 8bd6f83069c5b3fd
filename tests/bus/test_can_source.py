import subprocess
import sys
import time
from contextlib import nullcontext

import can
import pytest

from brake_monitor.bus import can_source, python_can_bus
from brake_monitor.bus.can_link import CanLink
from brake_monitor.bus.can_source import ActiveControllerError, BusError, LiveBus, open_bus
from brake_monitor.errors import InputError
from brake_monitor.frame import CanFilter, Frame, FrameKind
from brake_monitor.settings.config import CanBus

PATIENCE_S = 300.0


def live(name: str, filters: list[CanFilter] | None = None) -> tuple[LiveBus, can.BusABC]:
    sender = can.Bus(interface="virtual", channel=name)
    return open_bus(CanBus("virtual", name, (), "front"), filters or []), sender


def test_a_live_bus_gives_frames_and_none_when_nothing_comes() -> None:
    bus, sender = live("receive")
    with bus, sender:
        assert bus.recv(0.0) is None
        sender.send(can.Message(arbitration_id=0x18FF5030, is_extended_id=True, data=b"\x01", timestamp=12.5))
        frame = bus.recv(5.0)
        assert frame is not None
        assert frame[1:] == Frame(0.0, "front", 0x18FF5030, True, b"\x01")[1:]


def test_a_driver_that_counts_from_its_own_start_is_noticed(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(python_can_bus, "_WITHOUT_A_CONTROLLER", set())
    with open_bus(CanBus("virtual", "own clock", (), "front", allow_active=True), []) as bus:
        by_its_start = iter([can.Message(timestamp=12.5), can.Message(timestamp=12.6)])
        monkeypatch.setattr(bus._ear, "_recv", lambda _: next(by_its_start))
        before_s = time.time()
        frames = [bus.recv(0.0), bus.recv(0.0)]
        assert all(frame is not None and before_s <= frame.time_s <= time.time() for frame in frames)
    (line,) = caplog.messages
    assert line == "bus front: its driver has a clock of its own; frames are stamped as they arrive"


SET_BACK = """
import threading, time
true_time, offset_s = time.time, [0.0]
time.time = lambda: true_time() + offset_s[0]
from brake_monitor.bus.can_source import open_bus
from brake_monitor.settings.config import CanBus
bus = open_bus(CanBus(interface="virtual", channel="set-back", dbc=(), name="a"), [])
threading.Timer(0.1, lambda: offset_s.insert(0, -3600.0)).start()
print(bus.recv(0.3))
"""


def test_a_clock_that_is_set_back_makes_no_wait_longer() -> None:
    """In a silence; python-can would wait for an hour more."""
    ended = subprocess.run(
        [sys.executable, "-c", SET_BACK], capture_output=True, text=True, check=True, timeout=PATIENCE_S
    )
    assert ended.stdout == "None\n"


def test_filters_are_applied() -> None:
    bus, sender = live("filtered", [CanFilter(can_id=0x100, can_mask=0x7FF, extended=False)])
    with bus, sender:
        for can_id in (0x101, 0x100):
            sender.send(can.Message(arbitration_id=can_id, is_extended_id=False))
        frame = bus.recv(5.0)
        assert frame is not None
        assert frame.can_id == 0x100


def test_error_frames_pass_all_filters() -> None:
    bus, sender = live("faulty", [CanFilter(can_id=0x100, can_mask=0x7FF, extended=False)])
    with bus, sender:
        sender.send(can.Message(arbitration_id=0x101, is_extended_id=False))
        sender.send(can.Message(is_error_frame=True, arbitration_id=0x4, is_extended_id=False))
        frame = bus.recv(5.0)
        assert frame is not None
        assert frame.kind is FrameKind.ERROR


def test_what_does_not_pass_the_filters_makes_no_wait_longer() -> None:
    bus, sender = live("foreign", [CanFilter(can_id=0x100, can_mask=0x7FF, extended=False)])
    with bus, sender:
        sender.send_periodic(can.Message(arbitration_id=0x101, is_extended_id=False), 0.01)
        assert bus.recv(0.2) is None


def test_a_live_bus_cannot_send() -> None:
    bus, sender = live("mute")
    with bus, sender:
        reachable = {name for name in dir(bus) if not name.startswith("__")}
        assert not any("send" in name for name in reachable)
        assert not any(isinstance(getattr(bus, name), can.BusABC) for name in reachable)


@pytest.mark.parametrize(
    ("interface", "channel", "what"),
    [
        ("socketcann", "can0", 'no such interface, did you mean "socketcan"?'),
        ("socketcan", "nothere0", 'there is no network interface "nothere0"'),
    ],
)
def test_unknown_interface_or_channel_is_named(
    interface: str, channel: str, what: str, caplog: pytest.LogCaptureFixture
) -> None:
    with pytest.raises(InputError) as caught:
        open_bus(CanBus(interface, channel, (), "front"), [])
    assert str(caught.value) == f'bus "front": cannot open {interface}:{channel}: {what}'
    assert caught.value.exit_code == 2
    assert caplog.records == []  # python-can had nothing to say beside it


@pytest.mark.parametrize(
    ("link", "allow_active", "refusal"),
    [
        (CanLink(is_can=True, kind="can", listen_only=False, is_up=True), False, ActiveControllerError),
        (CanLink(is_can=True, kind="", listen_only=False, is_up=True), False, ActiveControllerError),
        (CanLink(is_can=False, kind="", listen_only=False, is_up=True), True, InputError),
        (CanLink(is_can=True, kind="can", listen_only=True, is_up=False), False, BusError),
        (CanLink(is_can=True, kind="can", listen_only=True, is_up=True), False, None),
        (CanLink(is_can=True, kind="can", listen_only=False, is_up=True), True, None),
        (CanLink(is_can=True, kind="vcan", listen_only=False, is_up=True), False, None),
    ],
)
def test_a_controller_that_is_able_to_send_is_not_opened_unless_that_is_allowed(
    link: CanLink, allow_active: bool, refusal: type[Exception] | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By what the kernel would say of it; a real controller is asked in tests/vcan."""
    opened: list[str] = []
    monkeypatch.setattr(can_source, "read_link", lambda _: link)
    monkeypatch.setattr(can_source, "CanSocket", lambda channel, *_: opened.append(channel))
    monkeypatch.setattr(can_source, "LiveBus", lambda *_: None)
    with pytest.raises(refusal) if refusal else nullcontext():
        open_bus(CanBus("socketcan", "can0", (), "front", allow_active=allow_active), [])
    assert opened == ([] if refusal else ["can0"])


def test_an_interface_that_cannot_be_asked_whether_it_only_listens_has_to_be_allowed() -> None:
    with pytest.raises(InputError, match="nobody can tell whether it only listens; allow_active = true"):
        open_bus(CanBus("serial", "/dev/null", (), "front"), [])
    with pytest.raises(InputError) as caught:
        open_bus(CanBus("serial", "/nothere", (), "front", allow_active=True), [])
    assert "listens" not in str(caught.value)


def test_an_interface_that_went_away_is_a_bus_that_failed() -> None:
    """Whoever opens a bus anew need not know whether its interface is down or gone."""
    with pytest.raises(BusError):
        open_bus(CanBus("socketcan", "nothere0", (), "front"), [])


def test_an_adapter_that_is_not_plugged_in_is_a_bus_that_failed(monkeypatch: pytest.MonkeyPatch) -> None:
    """At the start it is a wrong configuration, exit code 2; to a daemon that waits for it, a failure."""

    def refuse(**_: object) -> None:
        raise can.CanInitializationError("no adapter is plugged in")

    monkeypatch.setattr(can, "Bus", refuse)
    with pytest.raises(BusError, match="cannot open pcan:PCAN_USBBUS1: no adapter is plugged in") as caught:
        open_bus(CanBus("pcan", "PCAN_USBBUS1", (), "front", allow_active=True), [])
    assert caught.value.exit_code == 2


def test_a_bus_that_fails_while_listening_is_a_typed_error() -> None:
    bus, sender = live("failing")
    bus.close()
    with pytest.raises(BusError, match=r'bus "front" \(virtual:failing\) failed while listening'):
        bus.recv(0.0)
    bus.close()
    sender.shutdown()
