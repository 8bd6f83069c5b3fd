"""A live bus that is only listened to."""

import errno
import logging
import time
from collections.abc import Sequence
from contextlib import suppress
from typing import Protocol, Self

import can

from brake_monitor.bus.can_link import read_link
from brake_monitor.bus.can_message import frame_of
from brake_monitor.bus.can_socket import CanSocket
from brake_monitor.errors import InputError, WorkError
from brake_monitor.frame import CanFilter, Frame
from brake_monitor.nearest import nearest
from brake_monitor.settings.config import CanBus

CLOCK_TRUSTED_S = 10.0  # a driver whose stamps differ by more from our clock counts from its own start, or the like

# What python-can's drivers raise besides CanError and OSError where they cannot open a bus; NameError: Kvaser's.
CANNOT_OPEN = (ImportError, TypeError, ValueError, NameError, can.CanInterfaceNotImplementedError)

_WITHOUT_A_CONTROLLER = {"virtual", "udp_multicast"}  # kinds of python-can that reach no vehicle

# python-can measures its waiting by the wall clock: set back meanwhile, it would wait for as long again.
can.bus.time = time.monotonic  # type: ignore[attr-defined]

log = logging.getLogger(__name__)


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
    if bus.interface not in can.VALID_INTERFACES:
        hint = nearest(bus.interface, sorted(can.VALID_INTERFACES))
        raise InputError(f"{place}: no such interface, {hint}")
    try:
        if bus.interface == "socketcan":
            _check_link(bus, place)
            return LiveBus(bus, CanSocket(bus.channel, filters, bus.name))
        if not (bus.allow_active or bus.interface in _WITHOUT_A_CONTROLLER):
            raise InputError(
                f"{place}: nobody can tell whether it only listens; allow_active = true listens all the same"
            )
        return LiveBus(bus, _PythonCan(bus, filters))
    except CANNOT_OPEN as error:
        raise InputError(f"{place}: {reason_of(error)}") from None
    except (can.CanError, OSError) as error:
        raise NoInterfaceError(f"{place}: {reason_of(error)}") from None


def reason_of(error: Exception) -> str:
    """Say in one line why a bus failed."""
    return getattr(error, "strerror", None) or " ".join(str(error).split()) or type(error).__name__


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
    """What frames come from; it raises can.CanError, OSError or ValueError when it fails."""

    dropped: int
    keeps_time: bool

    def recv(self, timeout_s: float) -> Frame | None: ...

    def close(self) -> None: ...


class LiveBus:
    """A bus that is listened to and nothing else; nothing in it, nor in what may import it, calls what sends."""

    def __init__(self, bus: CanBus, ear: _Ear) -> None:
        self._ear = ear
        self._failed = f'bus "{bus.name}" ({bus.interface}:{bus.channel}) failed while listening'

    @property
    def dropped(self) -> int:
        """Frames that the kernel had no room for since the bus was opened."""
        return self._ear.dropped

    @property
    def keeps_time(self) -> bool:
        """Whether frames are stamped before they are fetched, and may as well wait until then."""
        return self._ear.keeps_time

    def recv(self, timeout_s: float) -> Frame | None:
        """Return the next frame with the time at which it was captured, or None when none came in time.

        BusError when the bus failed.
        """
        try:
            return self._ear.recv(timeout_s)
        except (can.CanError, OSError, ValueError) as error:  # ValueError: it is closed
            raise BusError(f"{self._failed}: {reason_of(error)}") from None

    def close(self) -> None:
        """Give the bus back; a bus that already failed may be closed too."""
        with suppress(can.CanError, OSError):
            self._ear.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()


class _PythonCan:
    """Any other interface that python-can knows. Its bus can send; nobody can through these two bound methods."""

    dropped = 0  # it does not tell
    keeps_time = False  # nor this; some stamp what they hand out

    def __init__(self, bus: CanBus, filters: Sequence[CanFilter]) -> None:
        opened = can.Bus(
            channel=bus.channel,
            interface=bus.interface,
            can_filters=[*filters] or None,
            receive_own_messages=False,
            ignore_config=True,
        )
        self._recv, self.close, self._name = opened.recv, opened.shutdown, bus.name
        self._has_controller = bus.interface not in _WITHOUT_A_CONTROLLER  # else stamps may be a simulation's
        self._told = False

    def recv(self, timeout_s: float) -> Frame | None:
        message = self._recv(timeout_s)
        if message is None:
            return None
        arrived_s = time.time()
        if self._has_controller and abs(message.timestamp - arrived_s) > CLOCK_TRUSTED_S:
            if not self._told:
                log.warning("bus %s: its driver has a clock of its own; frames are stamped as they arrive", self._name)
            self._told = True
            message.timestamp = arrived_s
        return frame_of(message, self._name)
