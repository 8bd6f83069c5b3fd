"""The daemon's ear at a real CAN controller: it listens only where nothing can be sent, and sends nothing anywhere."""

import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from brake_monitor.bus.can_link import CanLink, read_link
from brake_monitor.bus.can_source import ActiveControllerError, open_bus
from brake_monitor.errors import InputError
from brake_monitor.settings.config import CanBus
from program import BRAKE_MONITOR, Daemon, run, until, write_config
from serial_controller import Adapter, serial_controller

pytestmark = pytest.mark.vcan

ENOUGH_S = 60.0


@pytest.fixture
def controller() -> Iterator[Adapter]:
    with serial_controller() as made:
        yield made


def bus(channel: str, *, allow_active: bool = False) -> CanBus:
    return CanBus("socketcan", channel, (), "front", allow_active)


def test_the_kernel_tells_what_kind_of_bus_it_is(controller: Adapter) -> None:
    assert read_link("vcan0") == CanLink(True, "vcan", False, True)
    for listen_only in (True, False, True):
        controller.set_up(listen_only=listen_only)
        assert read_link(controller.name) == CanLink(True, "can", listen_only, True)


def test_a_controller_in_listen_only_mode_is_listened_to(controller: Adapter) -> None:
    controller.set_up(listen_only=True)
    with open_bus(bus(controller.name), []) as opened:
        controller.put(0x123, b"\xab\xcd")
        frame = opened.recv(ENOUGH_S)
        assert frame is not None
        assert (frame.can_id, frame.data) == (0x123, b"\xab\xcd")
    assert controller.frames_sent() == []


def test_a_controller_that_could_send_is_refused_and_told_how_to_set(controller: Adapter) -> None:
    controller.set_up(listen_only=False)
    with pytest.raises(
        ActiveControllerError, match=rf"ip link set {controller.name} type can listen-only on"
    ) as caught:
        open_bus(bus(controller.name), [])
    assert caught.value.exit_code == 2


def test_a_controller_that_could_send_is_listened_to_when_that_is_allowed(controller: Adapter) -> None:
    controller.set_up(listen_only=False)
    with open_bus(bus(controller.name, allow_active=True), []) as opened:
        controller.put(0x321, b"\x01")
        assert opened.recv(ENOUGH_S) is not None
    assert controller.frames_sent() == []


def test_the_adapter_would_hear_a_frame(controller: Adapter) -> None:
    """Without this the tests that nothing was sent could not fail."""
    controller.set_up(listen_only=False)
    with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as other:
        other.bind((controller.name,))
        other.send(b"\x23\x01\x00\x00\x01\x00\x00\x00\x55\x00\x00\x00\x00\x00\x00\x00")
    until(lambda: controller.frames_heard() == [b"t123155"])


def test_what_is_no_can_interface_is_refused() -> None:
    with pytest.raises(InputError, match='"lo" is no CAN interface'):
        open_bus(bus("lo"), [])


def test_the_daemon_refuses_a_controller_that_could_send_in_one_sentence(controller: Adapter, tmp_path: Path) -> None:
    controller.set_up(listen_only=False)
    ended = run(BRAKE_MONITOR, "run", "-c", write_config(tmp_path / "wagon.toml", controller.name, rate_hz=5.0))
    assert ended.returncode == 2
    assert ended.stderr.splitlines()[-1].startswith("brake-monitor: ")
    assert "listen-only" in ended.stderr
    assert controller.frames_sent() == []


def test_a_controller_that_was_made_able_to_send_meanwhile_is_left_alone_until_it_is_set_right(
    controller: Adapter, tmp_path: Path
) -> None:
    controller.set_up(listen_only=True)
    with Daemon(write_config(tmp_path / "wagon.toml", controller.name, rate_hz=5.0)) as daemon:
        controller.set_up(listen_only=False)
        daemon.wait_for(f"{controller.name}.* failed while listening")
        daemon.wait_for("not in listen-only mode")
        controller.set_up(listen_only=True)
        daemon.wait_for(f"{controller.name} is back")
        assert daemon.end()[0] == 0
    assert controller.frames_sent() == []
