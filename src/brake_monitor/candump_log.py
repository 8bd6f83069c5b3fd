"""candump's log format (`candump -l`): one frame per line.

(1436509052.249713) can0 1A0#0011223344556677      11-bit id, three digits
(1436509052.449847) can0 18FF5030#01               29-bit id, eight digits
(1436509052.650004) can0 1A0##1001122              CAN FD, with its flags
(1436509052.750100) can0 1A0#R                     remote frame
(1436509052.850200) can0 20000080#0000000000000000 error frame
"""

import re

from brake_monitor.frame import Frame, FrameKind

_LINE = re.compile(
    r"\((?P<time>\d+(?:\.\d+)?)\)\s+(?P<channel>\S+)\s+(?P<id>[0-9A-Fa-f]{8}|[0-7][0-9A-Fa-f]{2})"
    r"#(?:(?P<remote>[Rr])[0-9A-Fa-f]?|#[0-9A-Fa-f](?P<fd>(?:[0-9A-Fa-f]{2}){0,64})|(?P<data>(?:[0-9A-Fa-f]{2}){0,8}))"
    r"(?:_[9A-Fa-f])?(?:\s+[RT])?\s*",
    re.ASCII,
)
_ERROR_FLAG = 0x20000000
_LARGEST_ID = 0x1FFFFFFF


def parse_line(line: str) -> Frame:
    """Return the frame of one line, with the channel as its bus; ValueError when the line is not one frame."""
    match = _LINE.fullmatch(line)
    if match is None:
        raise ValueError("not a line of candump's log format")
    time, channel, digits, remote, fd_data, data = match.groups()
    can_id = int(digits, 16)
    kind = FrameKind.REMOTE if remote else FrameKind.DATA
    if can_id > _LARGEST_ID:
        if not can_id & _ERROR_FLAG or can_id & ~(_LARGEST_ID | _ERROR_FLAG):
            raise ValueError(f"identifier {digits} has more than 29 bits")
        kind, can_id = FrameKind.ERROR, can_id & _LARGEST_ID
    return Frame(float(time), channel, can_id, len(digits) > 3, bytes.fromhex(data or fd_data or ""), kind)
