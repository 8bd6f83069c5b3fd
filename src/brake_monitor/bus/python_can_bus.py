"""Any bus that python-can opens but those of SocketCAN, for which nothing of it is needed."""

import logging
import time
from collections.abc import Sequence

import can

from brake_monitor.bus.can_message import frame_of
from brake_monitor.bus.can_socket import reason_of
from brake_monitor.frame import CanFilter, Frame
from brake_monitor.nearest import nearest
from brake_monitor.settings.config import CanBus

CLOCK_TRUSTED_S = 10.0  # a driver whose stamps differ by more from our clock counts from its own start, or the like

# What python-can's drivers raise besides CanError and OSError where they cannot open a bus; NameError: Kvaser's.
CANNOT_OPEN = (ImportError, TypeError, ValueError, NameError, can.CanInterfaceNotImplementedError)

_WITHOUT_A_CONTROLLER = {"virtual", "udp_multicast"}  # kinds that reach no vehicle

# python-can measures its waiting by the wall clock: set back meanwhile, it would wait for as long again.
can.bus.time = time.monotonic  # type: ignore[attr-defined]

log = logging.getLogger(__name__)


def could_disturb(bus: CanBus) -> bool:
    """Whether nobody can tell that it only listens, and it is not allowed to do more."""
    return not (bus.allow_active or bus.interface in _WITHOUT_A_CONTROLLER)


class PythonCanBus:
    """What python-can has opened can send; nobody can through these two bound methods.

    Where it cannot be opened as it is configured: ValueError. Else, and later, OSError when it fails.
    """

    dropped = 0  # it does not tell
    keeps_time = False  # nor this; some stamp what they hand out

    def __init__(self, bus: CanBus, filters: Sequence[CanFilter]) -> None:
        if bus.interface not in can.VALID_INTERFACES:
            raise ValueError(f"no such interface, {nearest(bus.interface, sorted(can.VALID_INTERFACES))}")
        if could_disturb(bus):
            raise ValueError("nobody can tell whether it only listens; allow_active = true listens all the same")
        try:
            opened = can.Bus(
                channel=bus.channel,
                interface=bus.interface,
                can_filters=[*filters] or None,
                receive_own_messages=False,
                ignore_config=True,
            )
        except CANNOT_OPEN as error:
            raise ValueError(reason_of(error)) from None
        except can.CanError as error:
            raise OSError(reason_of(error)) from None
        self._recv, self._shutdown, self._name = opened.recv, opened.shutdown, bus.name
        self._has_controller = bus.interface not in _WITHOUT_A_CONTROLLER  # else stamps may be a simulation's
        self._told = False

    def recv(self, timeout_s: float) -> Frame | None:
        """Return the next frame, or None when none came in time."""
        try:
            message = self._recv(timeout_s)
        except can.CanError as error:
            raise OSError(reason_of(error)) from None
        if message is None:
            return None
        arrived_s = time.time()
        if self._has_controller and abs(message.timestamp - arrived_s) > CLOCK_TRUSTED_S:
            if not self._told:
                log.warning("bus %s: its driver has a clock of its own; frames are stamped as they arrive", self._name)
            self._told = True
            message.timestamp = arrived_s
        return frame_of(message, self._name)

    def close(self) -> None:
        """Give the bus back."""
        try:
            self._shutdown()
        except can.CanError as error:
            raise OSError(reason_of(error)) from None
