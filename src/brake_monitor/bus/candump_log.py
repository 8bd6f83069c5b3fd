"""candump's log format (`candump -l`): one frame per line.

(1436509052.249713) can0 1A0#0011223344556677      11-bit id, three digits
(1436509052.449847) can0 18FF5030#01               29-bit id, eight digits
(1436509052.650004) can0 1A0##1001122              CAN FD, with its flags
(1436509052.750100) can0 1A0#R                     remote frame
(1436509052.850200) can0 20000080#0000000000000000 error frame

The number of digits alone tells an extended identifier from its standard twin. Some recorders write eight for all.

A power cut tears the line that is being written. What the same file is given next stands behind the tear, on the same
line; and where a file system had made room that it did not fill any more there are NUL bytes, here written ␀:

(1436509052.949) can0 1A0#00(1436509873.449) can0 1A0#01
(1436509052.949) can0 1A0#00␀␀␀␀␀␀␀␀␀␀␀␀␀␀␀␀␀␀449) can0 1A0#01
"""

import re
from collections.abc import Iterable

from brake_monitor.frame import CLASSIC_LENGTH, LARGEST_EXTENDED_ID, Frame, FrameKind, can_id_digits

_LINE = re.compile(
    r"\((?P<time>\d{1,11}(?:\.\d+)?)\)\s+(?P<channel>[^\s\0]+)\s+(?P<id>[0-9A-Fa-f]{8}|[0-7][0-9A-Fa-f]{2})"
    r"#(?:(?P<remote>[Rr])[0-9A-Fa-f]?|#[0-9A-Fa-f](?P<fd>(?:[0-9A-Fa-f]{2}){0,64})|(?P<data>(?:[0-9A-Fa-f]{2}){0,8}))"
    r"(?:_[9A-Fa-f])?(?:\s+[RT])?\s*",
    re.ASCII,
)
_EIGHT_FOR_ELEVEN_BITS = re.compile(rb"\S+\s+\S+\s+0{5}[0-7][0-9A-Fa-f]{2}#")
_NO_EVIDENCE = re.compile(rb"\S+\s+\S+\s+2[0-9A-Fa-f]{7}#|[^#]*$")  # error frame; empty, or cut off before its id's end
_ERROR_FLAG = 0x20000000
_TORN = re.compile(r"(?P<begun>[^\0]+)(?P<whole>\([^\0]*)|(?P<before>[^\0]*)\0+(?P<behind>[^\0]*)")
_ANY_LINE = "(0.0) x 00000000##000"  # an end of it completes whatever is the beginning of a line, a beginning any end


def writes_eight_digits_for_all(lines: Iterable[bytes]) -> bool:
    """Return whether every identifier has eight digits and yet none is greater than 7FF.

    Then the recorder pads: a bus whose extended identifiers are all that small is not to be met. One identifier of
    three digits, or of more than eleven bits, and eight digits mean what candump means by them. The lines are read
    up to the first that decides, hence to the end only where the recorder pads.
    """
    pads = False
    for line in lines:
        if _EIGHT_FOR_ELEVEN_BITS.match(line):
            pads = True
        elif not _NO_EVIDENCE.match(line) and behind_tear(line.decode("ascii", errors="replace")) is None:
            return False
    return pads


def parse_line(line: str, is_padded: bool = False) -> Frame:
    """Return the frame of one line, with the channel as its bus; ValueError when the line is not one frame.

    `is_padded` when eight digits do not tell an extended identifier.
    """
    match = _LINE.fullmatch(line)
    if match is None:
        raise ValueError("not a line of candump's log format, which candump -l writes")
    time, channel, digits, remote, fd_data, data = match.groups()
    can_id = int(digits, 16)
    kind = FrameKind.REMOTE if remote else FrameKind.DATA
    if can_id > LARGEST_EXTENDED_ID:
        if not can_id & _ERROR_FLAG or can_id & ~(LARGEST_EXTENDED_ID | _ERROR_FLAG):
            raise ValueError(f"identifier {digits} has more than 29 bits")
        kind, can_id = FrameKind.ERROR, can_id & LARGEST_EXTENDED_ID
    extended = len(digits) > 3 and not is_padded
    return Frame(float(time), channel, can_id, extended, bytes.fromhex(data or fd_data or ""), kind)


def behind_tear(line: str) -> str | None:
    """What stands whole behind the tear of a line, "" where nothing does; None when the line is not torn.

    A line that ends early, in order, is not: nothing tells that it was a power cut that cut it.
    """
    torn = _TORN.fullmatch(line)
    if torn is None:
        return None
    begun, rest = torn["begun"] or torn["before"] or "", torn["whole"] or torn["behind"] or ""
    if not any(_is_line(begun + _ANY_LINE[k:]) for k in range(len(_ANY_LINE) + 1)):
        return None
    if _is_line(rest):
        return rest
    ends_a_line = torn["whole"] is None and any(_is_line(_ANY_LINE[:k] + rest) for k in range(len(_ANY_LINE) + 1))
    return "" if ends_a_line else None


def _is_line(text: str) -> bool:
    try:
        parse_line(text)
    except ValueError:
        return False
    return True


def line_of(frame: Frame) -> str:
    """The line that `parse_line` reads as this frame, its time to the microsecond; ends with a newline."""
    can_id = frame.can_id | _ERROR_FLAG if frame.kind is FrameKind.ERROR else frame.can_id
    digits = can_id_digits(can_id, extended=frame.extended or frame.kind is FrameKind.ERROR)
    if frame.kind is FrameKind.REMOTE:
        content = "R"
    else:
        content = ("#0" if len(frame.data) > CLASSIC_LENGTH else "") + frame.data.hex().upper()
    return f"({frame.time_s:.6f}) {frame.bus} {digits}#{content}\n"
