"""A live bus that is only listened to."""

import errno
from collections.abc import Sequence
from contextlib import suppress
from typing import Protocol, Self

from brake_monitor.bus.can_link import read_link
from brake_monitor.bus.can_socket import CanSocket, reason_of
from brake_monitor.errors import InputError, WorkError
from brake_monitor.frame import CanFilter, Frame
from brake_monitor.host.python_can import load_without_asammdf
from brake_monitor.settings.config import CanBus


class BusError(WorkError):
    """The bus failed while it was listened to (interface down or gone); opening it again may help."""


class NoInterfaceError(InputError, BusError):
    """The interface is not there: at the start a wrong configuration, later a bus that went away."""


class ActiveControllerError(InputError, BusError):
    """The controller is able to send, so it is not listened to: it must be set to listen-only or allowed first."""


def open_bus(bus: CanBus, filters: Sequence[CanFilter]) -> "LiveBus":
    """Open a bus to listen to, letting through only what passes the filters (all, when there are none).

    InputError when there is no such kind of interface, or a controller that is able to send; NoInterfaceError when
    there is no such channel.
    """
    place = f'bus "{bus.name}": cannot open {bus.interface}:{bus.channel}'
    try:
        if bus.interface == "socketcan":
            _check_link(bus, place)
            return LiveBus(bus, CanSocket(bus.channel, filters, bus.name))
        load_without_asammdf()
        from brake_monitor.bus.python_can_bus import PythonCanBus  # noqa: PLC0415 - SocketCAN does without

        return LiveBus(bus, PythonCanBus(bus, filters))
    except ValueError as error:
        raise InputError(f"{place}: {reason_of(error)}") from None
    except OSError as error:
        raise NoInterfaceError(f"{place}: {reason_of(error)}") from None


def _check_link(bus: CanBus, place: str) -> None:
    """Refuse what is not a CAN interface, or is down, and a controller that could send unless that is allowed."""
    try:
        link = read_link(bus.channel)
    except OSError as error:
        if error.errno == errno.ENODEV:
            raise NoInterfaceError(f'{place}: there is no network interface "{bus.channel}"') from None
        raise BusError(f"{place}: cannot tell whether it only listens: {error.strerror or error}") from None
    if not link.is_can:
        raise InputError(f'{place}: "{bus.channel}" is no CAN interface')
    if not (bus.allow_active or link.cannot_disturb):
        raise ActiveControllerError(
            f"{place}: the controller is not in listen-only mode: set it up with "
            f"`ip link set {bus.channel} type can listen-only on`; allow_active = true listens all the same"
        )
    if not link.is_up:
        raise BusError(f'{place}: "{bus.channel}" is down: `ip link set {bus.channel} up`')


class _Ear(Protocol):
    """What frames come from; it raises OSError or ValueError when it fails."""

    dropped: int
    keeps_time: bool

    def recv(self, timeout_s: float) -> Frame | None: ...

    def close(self) -> None: ...


class LiveBus:
    """A bus that is listened to and nothing else; nothing in it, nor in what may import it, calls what sends."""

    def __init__(self, bus: CanBus, ear: _Ear) -> None:
        self._ear = ear
        self.keeps_time = ear.keeps_time  # frames are stamped before they are fetched, and may as well wait until then
        self._failed = f'bus "{bus.name}" ({bus.interface}:{bus.channel}) failed while listening'

    @property
    def dropped(self) -> int:
        """Frames that the kernel had no room for since the bus was opened."""
        return self._ear.dropped

    def recv(self, timeout_s: float) -> Frame | None:
        """Return the next frame with the time at which it was captured, or None when none came in time.

        BusError when the bus failed.
        """
        try:
            return self._ear.recv(timeout_s)
        except (OSError, ValueError) as error:  # ValueError: it is closed
            raise BusError(f"{self._failed}: {reason_of(error)}") from None

    def close(self) -> None:
        """Give the bus back; a bus that already failed may be closed too."""
        with suppress(OSError):
            self._ear.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()
