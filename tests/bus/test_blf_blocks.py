"""Blocks against python-can's reader: every frame must be the same, whatever is in the file."""

import re
import struct
import zlib
from collections.abc import Iterator
from io import BytesIO
from itertools import pairwise

import can
import pytest
from can.io import blf
from hypothesis import assume, given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from brake_monitor.bus.blf_blocks import BlfBlocks
from brake_monitor.bus.can_message import frame_of
from brake_monitor.frame import Frame, FrameKind
from brake_monitor.frame_block import FrameBlock

Seen = tuple[list[Frame], str]


def bus_of(channel: int) -> str:
    return ("front", "rear", "front")[channel] if 0 <= channel < 3 else ""


def frame(message: can.Message) -> Frame:
    assert isinstance(message.channel, int)
    return frame_of(message, bus_of(message.channel))


def until_error(frames: Iterator[Frame]) -> Seen:
    found: list[Frame] = []
    try:
        found.extend(frames)
    except Exception as error:  # noqa: BLE001 - whatever python-can raises
        return found, repr(error)
    return found, ""


def as_python_can_reads(content: bytes) -> Seen:
    return until_error(frame(message) for message in can.BLFReader(BytesIO(content)))


def items(content: bytes) -> Iterator[Frame | FrameBlock]:
    return BlfBlocks(BytesIO(content), bus_of, frame).read()


def by_blocks(content: bytes) -> Seen:
    return until_error(each for item in items(content) for each in (item if isinstance(item, FrameBlock) else (item,)))


# --- files as they are written ---

messages = st.builds(
    can.Message,
    timestamp=st.integers(0, 2**60).map(lambda ns: 1.7e9 + ns % 10**14 / 1e9),
    arbitration_id=st.integers(0, 0x7FF),
    is_extended_id=st.booleans(),
    is_remote_frame=st.sampled_from([False, False, False, True]),
    data=st.one_of(st.binary(max_size=8), st.just(b"LOBJLOBJ"), st.just(b"12LOBJ")),
    channel=st.integers(0, 4),
)
fd_messages = st.builds(
    can.Message,
    timestamp=st.floats(1.7e9, 1.8e9),
    arbitration_id=st.integers(0, 0x1FFFFFFF),
    is_fd=st.just(True),
    data=st.sampled_from([0, 1, 8, 12, 16, 20, 24, 32, 48, 64]).map(bytes),
    channel=st.integers(0, 4),
)
error_frames = st.builds(can.Message, timestamp=st.floats(1.7e9, 1.8e9), is_error_frame=st.just(True))


@hypothesis_settings(max_examples=150, deadline=None)
@given(
    written=st.lists(st.one_of(messages, messages, messages, fd_messages, error_frames), min_size=1, max_size=40),
    container=st.sampled_from([100, 333, 1000, 1 << 17]),
    compression=st.sampled_from([0, 1]),
)
def test_what_python_can_writes(written: list[can.Message], container: int, compression: int) -> None:
    file = BytesIO()
    file.close = lambda: None  # type: ignore[method-assign]
    with can.BLFWriter(file, compression_level=compression) as writer:
        writer.max_container_size = container
        for message in written:
            writer(message)
    expected = as_python_can_reads(file.getvalue())
    assert by_blocks(file.getvalue()) == expected
    if container == 1 << 17:  # python-can loses a frame now and then where the next container begins
        assert len(expected[0]) == len(written)


# --- objects as no writer writes them ---

classic_bodies = st.tuples(
    st.integers(0, 5), st.sampled_from([0, 0, 0x80, 1]), st.integers(0, 15), st.integers(0, 2**32 - 1),
    st.one_of(st.binary(min_size=8, max_size=8), st.just(b"LOBJ1234"), st.just(b"1LOBJ234")),
).map(lambda fields: struct.pack("<HBBL8s", *fields))  # fmt: skip
whole_classic = st.builds(
    lambda version, kind, unit, time, body: (
        struct.pack("<4sHHLL", b"LOBJ", 32, version, {1: 32, 2: 40}[version] + 16, kind)
        + struct.pack("<LHHQ", unit, 0, 0, time) + bytes({1: 0, 2: 8}[version]) + body
    ),
    st.sampled_from([1, 1, 2]), st.sampled_from([1, 86]), st.sampled_from([0, 1, 2, 3]), st.integers(0, 2**53 - 1),
    classic_bodies,
)  # fmt: skip
any_object = st.builds(
    lambda version, kind, unit, time, body, more: (
        struct.pack("<4sHHLL", b"LOBJ", 32, version, max(16, 32 + len(body) + more), kind)
        + struct.pack("<LHHQ", unit, 0, 0, time) + body + bytes(-len(body) % 4)
    ),
    st.sampled_from([1, 1, 1, 2, 3]), st.sampled_from([1, 86, 73, 96, 100, 101, 7]), st.sampled_from([1, 2]),
    st.integers(0, 2**64 - 1), st.one_of(classic_bodies, st.binary(max_size=130)), st.sampled_from([0, 0, 0, 4, -8, 1]),
)  # fmt: skip


LEAST_OBJECT = struct.calcsize("<4sHHLL")


def has_too_short_an_object(content: bytes) -> bool:
    """Whether one is shorter than its header: it is refused by us, and python-can may read it for ever."""
    headers = (at for at in range(len(content) - 12) if content[at : at + 4] == b"LOBJ")
    return any(struct.unpack_from("<L", content, at + 8)[0] < LEAST_OBJECT for at in headers)


def has_an_old_error_frame(content: bytes) -> bool:
    """Of which we tell, and python-can does not."""
    return re.search(rb"LOBJ.{8}\x02\0\0\0", content, re.DOTALL) is not None


def file_of(content: bytes, cuts: list[int], method: int) -> bytes:
    """A file of containers that the content is cut into."""
    places = [0, *sorted(cut % (len(content) + 1) for cut in cuts), len(content)]
    header = blf.FILE_HEADER_STRUCT.pack(b"LOGG", 144, *([0] * 8), 0, 0, 0, 0, *(2024, 1, 3, 10, 11, 12, 13, 700) * 2)
    file = header.ljust(144, b"\0")
    for begin, end in pairwise(places):
        data = content[begin:end]
        packed = struct.pack("<H6xL4x", method, len(data)) + (zlib.compress(data, 1) if method else data)
        size = 16 + len(packed)
        file += struct.pack("<4sHHLL", b"LOBJ", 16, 1, size, 10) + packed + bytes(size % 4)
    return file


@hypothesis_settings(max_examples=250, deadline=None)
@given(
    objects=st.lists(st.one_of(whole_classic, whole_classic, any_object, st.just(b"\0\0")), max_size=20),
    cuts=st.lists(st.integers(0, 5000), max_size=3),
    method=st.sampled_from([0, 2]),
)
def test_any_objects(objects: list[bytes], cuts: list[int], method: int) -> None:
    content = b"".join(objects)
    assume(not has_too_short_an_object(content) and not has_an_old_error_frame(content))
    file = file_of(content, cuts, method)
    assert by_blocks(file) == as_python_can_reads(file)


@hypothesis_settings(max_examples=150, deadline=None)
@given(
    objects=st.lists(whole_classic, min_size=1, max_size=20),
    cuts=st.lists(st.integers(0, 1000), max_size=2),
    changes=st.lists(st.tuples(st.integers(0, 1000), st.integers(0, 255)), min_size=1, max_size=3),
)
def test_damaged_objects(objects: list[bytes], cuts: list[int], changes: list[tuple[int, int]]) -> None:
    content = bytearray(b"".join(objects))
    for place, byte in changes:
        content[place % len(content)] = byte
    assume(not has_too_short_an_object(bytes(content)) and not has_an_old_error_frame(bytes(content)))
    file = file_of(bytes(content), cuts, 0)
    assert by_blocks(file) == as_python_can_reads(file)


@given(st.sampled_from([b"", bytes(1), bytes(2), bytes(3)]), st.lists(whole_classic, min_size=1, max_size=20))
@hypothesis_settings(max_examples=100, deadline=None)
def test_ordinary_objects_are_read_together(padding: bytes, objects: list[bytes]) -> None:
    """Else all would be right and nothing gained. A container may begin with what the last object was padded by."""
    flat = [each.replace(b"LOBJ", b"lobj").replace(b"lobj", b"LOBJ", 1) for each in objects]
    (block,) = items(file_of(padding + b"".join(flat), [], 2))
    assert isinstance(block, FrameBlock)
    assert len(block) == len(objects)
    remote = sum(bool(each[-14] & 0x80) for each in objects)
    assert len(block.odd) == remote


@pytest.mark.parametrize("version", [1, 2])
def test_error_frames_of_the_old_kind_are_told_of(version: int) -> None:
    """python-can passes over them: CAN_ERROR, of which only the channel is known."""

    def one(kind: int, ms: int, body: bytes) -> bytes:
        header = struct.pack("<4sHHLL", b"LOBJ", 32, version, {1: 32, 2: 40}[version] + len(body), kind)
        return header + struct.pack("<LHHQ", 2, 0, 0, ms * 10**6) + bytes({1: 0, 2: 8}[version]) + body

    classic = struct.pack("<HBBL8s", 1, 0, 8, 0x1A0, b"12345678")
    old_error = struct.pack("<HHL", 2, 6, 0xFFFFFFFF)
    file = file_of(one(1, 10, classic) + one(2, 20, old_error) + one(1, 30, classic), [], 2)
    (block,) = items(file)
    assert isinstance(block, FrameBlock)
    before, error, after = block
    assert (error.kind, error.bus, error.can_id, error.data) == (FrameKind.ERROR, "rear", 0, b"")
    assert error.time_s - before.time_s == pytest.approx(0.01, abs=1e-6)
    assert [before, after] == as_python_can_reads(file)[0]
