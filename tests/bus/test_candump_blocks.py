"""Blocks against the parser that takes one line at a time: every frame and every refusal must be the same."""

from collections.abc import Iterator
from io import BytesIO

import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from brake_monitor.bus import candump_blocks
from brake_monitor.bus.candump_blocks import CandumpBlocks
from brake_monitor.bus.candump_log import parse_line
from brake_monitor.errors import InputError
from brake_monitor.frame import Frame, FrameKind

BUSES = {"can0": "front", "can1": "rear", "c.1": "rear"}  # any other channel is on no bus


def one_line(raw: bytes, number: int, is_padded: bool) -> Frame | None:
    text = raw.decode("ascii", errors="replace")
    if text.isspace():
        return None
    try:
        frame = parse_line(text, is_padded)
    except ValueError as error:
        is_whole = raw.endswith(b"\n")
        raise InputError(f"{number}: {error}, {is_whole}, {text.split()}") from None
    return frame._replace(bus=BUSES.get(frame.bus, ""))


def until_error(frames: Iterator[Frame]) -> tuple[list[Frame], str]:
    """The frames that come, and what is said in the end."""
    found: list[Frame] = []
    try:
        found.extend(frames)
    except InputError as error:
        return found, str(error)
    return found, ""


def singly(content: bytes, is_padded: bool) -> tuple[list[Frame], str]:
    parsed = (one_line(raw, number, is_padded) for number, raw in enumerate(BytesIO(content), start=1))
    return until_error(frame for frame in parsed if frame is not None)


def by_blocks(content: bytes, is_padded: bool) -> tuple[list[Frame], str]:
    reader = CandumpBlocks(
        is_padded, lambda channel: BUSES.get(channel, ""), lambda raw, number: one_line(raw, number, is_padded)
    )
    return until_error(frame for block in reader.read(BytesIO(content)) for frame in block)


hexadecimal = st.text("0123456789abcdefABCDEF", min_size=0, max_size=20)
times = st.one_of(
    st.integers(0, 2**53 + 10**6).map(lambda us: f"{us // 10**6}.{us % 10**6:06}"),
    st.integers(0, 10**17).map(lambda us: f"{us // 10**6:010}.{us % 10**6:06}"),
    st.from_regex(r"[0-9a]{1,12}\.?[0-9A]{0,8}", fullmatch=True),
)
channels = st.one_of(st.sampled_from(["can0", "can1", "c.1"]), st.text("can01.#)( \té\x0b\0", min_size=1, max_size=40))
ordinary_ids = st.one_of(
    st.integers(0, 0x7FF).map(lambda n: f"{n:03X}"), st.integers(0, 0x1FFFFFFF).map(lambda n: f"{n:08x}")
)
ids = st.one_of(ordinary_ids, st.integers(0, 0x2FFFFFFF).map(lambda n: f"{n:08X}"), hexadecimal)
bytes_of_data = st.binary(max_size=8).map(bytes.hex)
contents = st.one_of(
    bytes_of_data, hexadecimal, st.sampled_from(["R", "r8", "#1", "#1" + "ab" * 12, "#0" + "ab" * 65, "0011_9", "0x"])
)
tails = st.sampled_from(["", "", "", " R", " T", " X", "  R", " ", " R ", "\t", "R", " (1.0"])
newlines = st.sampled_from(["\n", "\n", "\r\n", "\r\r\n", " \n"])
ordinary = st.builds(
    "({}) {} {}#{}{}".format, times, st.sampled_from(["can0", "can1"]), ordinary_ids, bytes_of_data, tails
)
fields = st.builds("({}) {} {}#{}{}".format, times, channels, ids, contents, tails)
damaged = st.builds(
    lambda line, place, character: line[: place % len(line)] + character + line[place % len(line) + 1 :],
    ordinary, st.integers(0, 99), st.text(min_size=0, max_size=2),
)  # fmt: skip
lines = st.builds("{}{}".format, st.one_of(ordinary, ordinary, ordinary, fields, damaged, st.just("")), newlines)
right = st.builds(
    "({}) {} {}#{}{}{}".format,
    st.integers(0, 2**53 + 10**6).map(lambda us: f"{us // 10**6}.{us % 10**6:06}"),
    st.sampled_from(["can0", "can1", "c.1", "x"]),
    ordinary_ids,
    st.one_of(bytes_of_data, st.sampled_from(["R", "#1" + "ab" * 12])),
    st.sampled_from(["", " R", " T"]),
    newlines,
)


def test_an_ordinary_line_with_any_one_character_wrong_is_read_as_by_itself() -> None:
    line = "(1436509052.249713) can0 1A0#0011 R"
    for place, right in enumerate(line):
        for wrong in (*" \txa1().#\n", "", 2 * right):
            content = f"{line[:place]}{wrong}{line[place + 1 :]}\n".encode()
            assert by_blocks(content, is_padded=False) == singly(content, is_padded=False), content


@pytest.mark.parametrize("chunk_bytes", [1, 100, 1 << 17])
@hypothesis_settings(max_examples=150, deadline=None)
@given(text=st.lists(lines, max_size=12).map("".join), is_cut=st.booleans(), is_padded=st.booleans())
def test_any_text_is_read_as_line_by_line(chunk_bytes: int, text: str, is_cut: bool, is_padded: bool) -> None:
    content = text.encode()[: -1 if is_cut else None]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(candump_blocks, "CHUNK_BYTES", chunk_bytes)
        assert by_blocks(content, is_padded) == singly(content, is_padded)


@hypothesis_settings(max_examples=150, deadline=None)
@given(text=st.lists(right, min_size=1, max_size=50).map("".join), is_padded=st.booleans())
def test_what_is_right_is_read_to_the_end(text: str, is_padded: bool) -> None:
    frames, error = by_blocks(text.encode(), is_padded)
    assert (frames, error) == singly(text.encode(), is_padded)
    assert error == ""
    assert len(frames) == text.count("\n")
    assert {type(value) for frame in frames for value in frame} <= {float, str, int, bool, bytes, FrameKind}


@hypothesis_settings(max_examples=150, deadline=None)
@given(st.lists(st.integers(0, 10**16 - 1), min_size=20, max_size=100))
def test_times_are_the_very_doubles_that_their_text_means(times_us: list[int]) -> None:
    texts = [f"{us // 10**6}.{us % 10**6:06}" for us in times_us]
    frames, _ = by_blocks("".join(f"({text}) can0 1A0#00\n" for text in texts).encode(), is_padded=False)
    assert [frame.time_s for frame in frames] == [float(text) for text in texts]


def refuse(raw: bytes, number: int) -> Frame:
    raise AssertionError(number, raw)


def test_ordinary_lines_are_not_read_singly() -> None:
    """Else all would be right and nothing gained."""
    lines = (
        "(1436509052.249713) can0 1A0#0011223344556677", "(0.000001) can0 18FF5030#",
        "(17.250000) slcan1.2 000001a0#0f", "(1436509052.249713) can0 7FF#00 R",
        "(1436509052.249713) can0 1FFFFFFF#00112233 T\r",
    )  # fmt: skip
    content = "".join(f"{line}\n" for line in lines).encode()
    frames = [frame for block in CandumpBlocks(False, str.upper, refuse).read(BytesIO(content)) for frame in block]
    assert frames == [
        Frame(1436509052.249713, "CAN0", 0x1A0, False, bytes.fromhex("0011223344556677")),
        Frame(1e-6, "CAN0", 0x18FF5030, True, b""),
        Frame(17.25, "SLCAN1.2", 0x1A0, True, b"\x0f"),
        Frame(1436509052.249713, "CAN0", 0x7FF, False, b"\x00"),
        Frame(1436509052.249713, "CAN0", 0x1FFFFFFF, True, b"\x00\x11\x22\x33"),
    ]


def test_of_two_channels_all_lines_are_ordinary_however_many_there_are() -> None:
    """Only channels are found one by one, and no more than some dozens of them."""
    content = "".join(f"({k}.000000) can{k % 2} 1A0#00\n" for k in range(200)).encode()
    frames = [frame for block in CandumpBlocks(False, str.upper, refuse).read(BytesIO(content)) for frame in block]
    assert frames == [Frame(float(k), f"CAN{k % 2}", 0x1A0, False, b"\x00") for k in range(200)]


alike = st.builds(
    "({}) {} {}#{}{}\n".format,
    st.integers(10**15, 10**16 - 1).map(lambda us: f"{us // 10**6}.{us % 10**6:06}"),
    st.sampled_from(["can0", "can1", "vcan"]),
    ordinary_ids,
    bytes_of_data,
    st.sampled_from(["", " R", " T"]),
)


@hypothesis_settings(max_examples=500, deadline=None)
@given(
    text=st.lists(alike, min_size=1, max_size=6).map("".join),
    place=st.integers(0, 10**4),
    replaced=st.integers(0, 2),
    by=st.text("01aAgn().# RT\n", max_size=2),
    is_padded=st.booleans(),
)
def test_lines_alike_of_which_one_is_damaged_are_read_as_line_by_line(
    text: str, place: int, replaced: int, by: str, is_padded: bool
) -> None:
    place %= len(text)
    content = (text[:place] + by + text[place + replaced :]).encode()
    assert by_blocks(content, is_padded) == singly(content, is_padded)


class Breaking(BytesIO):
    """A file that gives half of what it has and then fails."""

    def read1(self, size: int | None = -1) -> bytes:
        if self.tell():
            raise EOFError("cut")
        return super().read1(len(self.getvalue()) // 2)


def test_what_could_be_read_comes_before_the_error_of_reading() -> None:
    line = b"(1.000000) can0 1A0#00\n"
    found = []
    with pytest.raises(EOFError, match="cut"):
        found.extend(CandumpBlocks(False, str, lambda _raw, _number: None).read(Breaking(line * 5)))
    assert sum(len(block) for block in found) == 2
