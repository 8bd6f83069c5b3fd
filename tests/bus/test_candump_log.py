import pytest
from hypothesis import given
from hypothesis import strategies as st

from brake_monitor.bus.candump_log import line_of, parse_line
from brake_monitor.frame import Frame, FrameKind


@pytest.mark.parametrize(
    ("line", "frame"),
    [
        ("(1.5) can0 1A0#0011", Frame(1.5, "can0", 0x1A0, False, b"\x00\x11")),
        ("(1.5) can0 1A0#\n", Frame(1.5, "can0", 0x1A0, False, b"")),
        ("(1.5) can0 000001A0#FF R\r\n", Frame(1.5, "can0", 0x1A0, True, b"\xff")),
        ("(1.5) can0 18FF5030#01 T", Frame(1.5, "can0", 0x18FF5030, True, b"\x01")),
        ("(1.5) can0 1A0##1" + "ab" * 64, Frame(1.5, "can0", 0x1A0, False, b"\xab" * 64)),
        ("(1.5) can0 1A0#R", Frame(1.5, "can0", 0x1A0, False, b"", FrameKind.REMOTE)),
        ("(1.5) can0 1A0#R8", Frame(1.5, "can0", 0x1A0, False, b"", FrameKind.REMOTE)),
        ("(1.5) can0 1A0#0011223344556677_E", Frame(1.5, "can0", 0x1A0, False, bytes.fromhex("0011223344556677"))),
        ("(1.5) can0 20000004#0000", Frame(1.5, "can0", 4, True, b"\x00\x00", FrameKind.ERROR)),
    ],
)
def test_lines_that_candump_writes(line: str, frame: Frame) -> None:
    assert parse_line(line) == frame


@pytest.mark.parametrize(
    "line",
    [
        "", "(1.5) can0", "(1.5) can0 1A0", "(1.5) can0 1A0#0", "(1.5) can0 1A#00", "(1.5) can0 8A0#00",
        "1.5 can0 1A0#00", "(nan) can0 1A0#00", "(1.5) can0 1A0#001122334455667788", "(1.5) can0 1A0##1" + "ab" * 65,
        "(1.5) can0 1A0#XY", "(1.5) can0 40000000#00", "(1.5) can0 E0000080#00", "(1.5) can0 1A0#00 (1.6) can0 1A0#00",
        "(1.5) ca\0n0 1A0#00",
    ],
)  # fmt: skip
def test_lines_that_it_does_not(line: str) -> None:
    with pytest.raises(ValueError, match=r"candump|29 bits"):
        parse_line(line)


@given(st.integers(0, 0x1FFFFFFF), st.booleans(), st.binary(max_size=64))
def test_what_is_written_is_read(can_id: int, extended: bool, data: bytes) -> None:
    can_id = can_id if extended else can_id & 0x7FF
    fd = "#1" if len(data) > 8 else ""
    line = f"(12.25) vcan0 {can_id:0{8 if extended else 3}X}#{fd}{data.hex().upper()}"
    frame = Frame(12.25, "vcan0", can_id, extended, data)
    assert parse_line(line) == frame
    assert parse_line(line_of(frame)) == frame
    remote = frame._replace(data=b"", kind=FrameKind.REMOTE)
    assert parse_line(line_of(remote)) == remote
    error = frame._replace(data=data[:8], extended=True, kind=FrameKind.ERROR)
    assert parse_line(line_of(error)) == error
