"""python-can's message → our frame."""

import can

from brake_monitor.frame import Frame, FrameKind


def frame_of(message: can.Message, bus: str) -> Frame:
    """Return what was received, as of the configured bus of that name."""
    kind = FrameKind.DATA
    if message.is_error_frame:
        kind = FrameKind.ERROR
    elif message.is_remote_frame:
        kind = FrameKind.REMOTE
    return Frame(message.timestamp, bus, message.arbitration_id, message.is_extended_id, bytes(message.data), kind)
