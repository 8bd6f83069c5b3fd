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
                receive_own_messages=False,
                ignore_config=True,
            )
        except CANNOT_OPEN as error:
            raise ValueError(reason_of(error)) from None
        except can.CanError as error:
            raise OSError(reason_of(error)) from None
        self._recv, self._shutdown, self._name = opened.recv, opened.shutdown, bus.name
        self._filters = filters
        self._has_controller = bus.interface not in _WITHOUT_A_CONTROLLER  # else stamps may be a simulation's
        self._told = False

    def recv(self, timeout_s: float) -> Frame | None:
        """Return the next frame that passes, or None when none came in time."""
        until_s = time.monotonic() + timeout_s
        try:
            message = self._recv(timeout_s)
            while not (message is None or self._passes(message)):
                left_s = until_s - time.monotonic()
                message = self._recv(left_s) if left_s > 0.0 else None
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

    def _passes(self, message: can.Message) -> bool:
        """Whether it passes the filters; python-can's own, which most of its drivers leave to it, stop error frames."""
        if message.is_error_frame or not self._filters:
            return True
        alike = [one for one in self._filters if one["extended"] == message.is_extended_id]
        return any((message.arbitration_id ^ one["can_id"]) & one["can_mask"] == 0 for one in alike)

    def close(self) -> None:
        """Give the bus back."""
        try:
            self._shutdown()
        except can.CanError as error:
            raise OSError(reason_of(error)) from None
