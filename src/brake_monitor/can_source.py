"""A live bus that is only listened to."""

import errno
import socket
from collections.abc import Sequence
from contextlib import suppress
from typing import Any, Self

import can

from brake_monitor.can_filter import CanFilter
from brake_monitor.can_link import read_link
from brake_monitor.can_message import frame_of
from brake_monitor.config import CanBus
from brake_monitor.errors import InputError, WorkError
from brake_monitor.frame import Frame
from brake_monitor.nearest import nearest

_RECEIVE_BUFFER_BYTES = 4 << 20  # the kernel's default holds 278 frames, a tenth of a second of a busy bus
_WITHOUT_A_CONTROLLER = {"virtual", "udp_multicast"}  # kinds of python-can that reach no vehicle
_SO_RCVBUFFORCE = 33  # Linux; beyond the system's limit, for those who may (CAP_NET_ADMIN)


class BusError(WorkError):
    """The bus failed while it was listened to (interface down or gone); opening it anew may help."""


class NoInterfaceError(InputError, BusError):
    """There is no interface of that name: at the start a wrong configuration, later a bus that went away."""


class ActiveControllerError(InputError, BusError):
    """The controller is able to send, so it is not listened to: it must be set to listen-only or allowed first."""


def open_bus(bus: CanBus, filters: Sequence[CanFilter]) -> "LiveBus":
    """Open a bus to listen to, letting through only what passes the filters (all, when there are none).

    InputError when there is no such kind of interface or no such channel, or a controller that is able to send.
    """
    place = f'bus "{bus.name}": cannot open {bus.interface}:{bus.channel}'
    if bus.interface not in can.VALID_INTERFACES:
        hint = nearest(bus.interface, sorted(can.VALID_INTERFACES))
        raise InputError(f"{place}: no such interface, {hint}")
    options: dict[str, Any] = {"receive_own_messages": False, "ignore_config": True}
    if bus.interface == "socketcan":
        _check_link(bus, place)
        options["fd"] = True  # a socket that takes FD frames takes classic ones too, whatever the interface's MTU
    elif not (bus.allow_active or bus.interface in _WITHOUT_A_CONTROLLER):
        raise InputError(f"{place}: nobody can tell whether it only listens; allow_active = true listens all the same")
    try:
        opened = can.Bus(channel=bus.channel, interface=bus.interface, can_filters=[*filters] or None, **options)
    except (can.CanError, OSError, ImportError, TypeError, ValueError) as error:
        what = getattr(error, "strerror", None) or " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"{place}: {what}") from None
    _enlarge_receive_buffer(opened)
    return LiveBus(bus, opened)


def _check_link(bus: CanBus, place: str) -> None:
    """Refuse what is no CAN interface, and a controller that could send unless that is allowed."""
    try:
        link = read_link(bus.channel)
    except OSError as error:
        if error.errno in (None, errno.ENODEV, errno.ENXIO):  # None: if_nametoindex found no such name
            raise NoInterfaceError(f'{place}: there is no network interface "{bus.channel}"') from None
        raise BusError(f"{place}: cannot tell whether it only listens: {error.strerror or error}") from None
    if not link.is_can:
        raise InputError(f'{place}: "{bus.channel}" is no CAN interface')
    if not (bus.allow_active or link.cannot_disturb):
        raise ActiveControllerError(
            f"{place}: the controller is not in listen-only mode: set it up with "
            f"`ip link set {bus.channel} type can listen-only on`; allow_active = true listens all the same"
        )


class LiveBus:
    """A bus that is listened to and nothing else: of python-can's bus it keeps only what receives and closes.

    python-can has no bus that cannot send; the one that is behind these two bound methods is never named again, and
    nothing in this class, nor in what may import it, calls a method that sends.
    """

    def __init__(self, bus: CanBus, opened: can.BusABC) -> None:
        self.name = bus.name
        self._place = f"{bus.interface}:{bus.channel}"
        self._recv = opened.recv
        self._shutdown = opened.shutdown

    def recv(self, timeout_s: float) -> Frame | None:
        """Return the next frame with the time at which the kernel got it, or None when none came in time.

        BusError when the bus failed.
        """
        try:
            message = self._recv(timeout_s)
        except (can.CanError, OSError, ValueError) as error:  # ValueError: the socket is closed
            raise BusError(f'bus "{self.name}" ({self._place}) failed while listening: {error}') from None
        return None if message is None else frame_of(message, self.name)

    def close(self) -> None:
        """Give the bus back; a bus that already failed may be closed too."""
        with suppress(can.CanError, OSError):
            self._shutdown()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()


def _enlarge_receive_buffer(opened: can.BusABC) -> None:
    """Make room for the frames of a few seconds, where the bus is a socket of the kernel."""
    opened_socket = getattr(opened, "socket", None)
    if not isinstance(opened_socket, socket.socket):
        return
    try:
        opened_socket.setsockopt(socket.SOL_SOCKET, _SO_RCVBUFFORCE, _RECEIVE_BUFFER_BYTES)
    except OSError:  # not permitted: as much as the system's limit allows
        opened_socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _RECEIVE_BUFFER_BYTES)
