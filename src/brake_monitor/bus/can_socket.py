"""A SocketCAN bus to listen to: a raw socket that is set up and then only ever read."""

import errno
import os
import socket
import struct
from collections.abc import Sequence

from brake_monitor.frame import CanFilter, Frame, FrameKind

_RECEIVE_BUFFER_BYTES = 4 << 20  # the kernel's default holds 278 frames, a tenth of a second of a busy bus
_MOST_FILTERS = 512  # the kernel's CAN_RAW_FILTER_MAX

_FILTER = struct.Struct("=II")  # can_filter: id, mask
_HEAD = struct.Struct("=IB3x")  # can_frame and canfd_frame: id with flags, bytes of data; 8 or 64 bytes follow
_LONGEST = _HEAD.size + 64
_TIMESPEC = struct.Struct("@ll")
_TIMEVAL = struct.Struct("@ll")
_DROPS = struct.Struct("=I")
_ANCILLARY_BYTES = socket.CMSG_SPACE(_TIMESPEC.size) + socket.CMSG_SPACE(_DROPS.size)

# Not Python's: on processors of 32 bits its flags are negative, and its time-out may be the one with 64 bits of time.
_EXTENDED, _REMOTE, _ERROR = 1 << 31, 1 << 30, 1 << 29
_SO_RCVTIMEO = 20

_SO_RCVBUFFORCE = 33  # beyond the system's limit, for those who may (CAP_NET_ADMIN)
_SO_TIMESTAMPNS = 35
_SO_RXQ_OVFL = 40
_CAN_RAW_ERR_FILTER = 2


def reason_of(error: Exception) -> str:
    """Say in one line why a bus failed."""
    if getattr(error, "errno", None) == errno.EAFNOSUPPORT:  # in the system's words an address would be at fault
        return "this machine's kernel has no SocketCAN"
    return getattr(error, "strerror", None) or " ".join(str(error).split()) or type(error).__name__


class CanSocket:
    """The frames of one interface that pass the filters (all, when there are none), as of the bus of that name.

    Of the socket it keeps only what receives and closes: there is nothing here that a frame could be sent with.
    OSError when the interface fails; it must then be opened again.
    """

    keeps_time = True

    def __init__(self, channel: str, filters: Sequence[CanFilter], bus: str) -> None:
        self.dropped = 0  # frames that the kernel had no room for, as of the last one received
        self._bus = bus
        self._timeout_s: float | None = None
        opened = socket.socket(socket.AF_CAN, socket.SOCK_RAW | socket.SOCK_CLOEXEC, socket.CAN_RAW)
        try:
            _set_up(opened, filters)
            opened.bind((channel,))
        except OSError:
            opened.close()
            raise
        self._recvmsg, self._setsockopt, self._shutdown = opened.recvmsg, opened.setsockopt, opened.close

    def recv(self, timeout_s: float) -> Frame | None:
        """The next frame, with the time at which the kernel got it; None when none came in time."""
        if timeout_s > 0.0 and timeout_s != self._timeout_s:  # the kernel's: Python's costs a call for each frame
            self._setsockopt(socket.SOL_SOCKET, _SO_RCVTIMEO, _timeval(timeout_s))
            self._timeout_s = timeout_s
        try:
            flags = 0 if timeout_s > 0.0 else socket.MSG_DONTWAIT
            content, ancillary, _, _ = self._recvmsg(_LONGEST, _ANCILLARY_BYTES, flags)
        except (BlockingIOError, TimeoutError):
            return None
        time_s = 0.0
        for _, kind, value in ancillary:
            if kind == _SO_TIMESTAMPNS:
                seconds, nanoseconds = _TIMESPEC.unpack(value)
                time_s = seconds + nanoseconds * 1e-9
            elif kind == _SO_RXQ_OVFL:
                (self.dropped,) = _DROPS.unpack(value)
        return _frame(content, time_s, self._bus)

    def close(self) -> None:
        """Give the interface back; a second call does nothing."""
        self._shutdown()


def _frame(content: bytes, time_s: float, bus: str) -> Frame:
    if len(content) < _HEAD.size:
        raise OSError(errno.EBADMSG, os.strerror(errno.EBADMSG))
    flagged_id, length = _HEAD.unpack_from(content)
    extended = bool(flagged_id & _EXTENDED)
    kind = FrameKind.DATA
    if flagged_id & _ERROR:
        kind = FrameKind.ERROR
    elif flagged_id & _REMOTE:
        kind = FrameKind.REMOTE
    can_id = flagged_id & (socket.CAN_EFF_MASK if extended else socket.CAN_SFF_MASK)
    return Frame(time_s, bus, can_id, extended, content[_HEAD.size : _HEAD.size + length], kind)


def _timeval(span_s: float) -> bytes:
    """Pack a struct timeval; never 0, which to the kernel means for ever."""
    return _TIMEVAL.pack(*divmod(max(round(span_s * 1e6), 1), 1_000_000))


def _set_up(opened: socket.socket, filters: Sequence[CanFilter]) -> None:
    opened.setsockopt(socket.SOL_SOCKET, _SO_TIMESTAMPNS, 1)
    opened.setsockopt(socket.SOL_SOCKET, _SO_RXQ_OVFL, 1)
    # Classic frames come all the same, whatever the interface's MTU.
    opened.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FD_FRAMES, 1)
    opened.setsockopt(socket.SOL_CAN_RAW, _CAN_RAW_ERR_FILTER, socket.CAN_ERR_MASK)
    if 0 < len(filters) <= _MOST_FILTERS:  # what is not mapped is not decoded: with more it costs time, nothing else
        packed = b"".join(_FILTER.pack(*_id_and_mask(can_filter)) for can_filter in filters)
        opened.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FILTER, packed)
    try:
        opened.setsockopt(socket.SOL_SOCKET, _SO_RCVBUFFORCE, _RECEIVE_BUFFER_BYTES)
    except OSError:  # not permitted: as much as the system's limit allows
        opened.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _RECEIVE_BUFFER_BYTES)


def _id_and_mask(can_filter: CanFilter) -> tuple[int, int]:
    """A standard id and its extended twin are different messages: the flag that tells them apart always counts."""
    flag = _EXTENDED if can_filter["extended"] else 0
    return can_filter["can_id"] | flag, can_filter["can_mask"] | _EXTENDED
