"""Candump logs that a power cut tore: what is whole is read, and what is no such log is refused as before."""

import gzip
from pathlib import Path

import can
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from brake_monitor.bus import candump_blocks
from brake_monitor.bus.can_log import open_log
from brake_monitor.errors import InputError
from brake_monitor.frame import Frame, FrameKind
from brake_monitor.settings.config import CanBus

BUSES = (CanBus("virtual", "can0", (), "can0"),)
SOUND = ["(1.000000) can0 123#AA\n", "(2.000000) can0 18FF5030#0011\n", "(3.000000) can0 123#BB\n"]
FRAMES = [
    Frame(1.0, "can0", 0x123, False, b"\xaa"),
    Frame(2.0, "can0", 0x18FF5030, True, b"\x00\x11"),
    Frame(3.0, "can0", 0x123, False, b"\xbb"),
]
SAID = "torn, as a power cut leaves it: only what stands whole behind the tear is read"
ROOM = 4096 * "\0"


@pytest.mark.parametrize("is_packed", [False, True])
@pytest.mark.parametrize("place", [0, 1, 2])
@pytest.mark.parametrize(
    "torn",
    [
        "(", "(14365090", "(1436509052.65", "(1.0)", "(1.0) ca", "(1.0) can0 1", "(1.0) can0 123", "(1.0) can0 18FF",
        "(1.0) can0 123#", "(1.0) can0 123#0", "(1.0) can0 123#00", "(1.0) can0 123##1001", "(1.0) can0 123#R",
        ROOM, ROOM + "\n", f"(1.0) can{ROOM}", f"(1.0) can0 1{ROOM}\n", f"(1.0) can0 123#{ROOM}AA\n",
        f"{ROOM}436.5) can0 123#AA\n", f"{ROOM}0 123##1{'00' * 64}\r\n", f"{ROOM}{'00' * 8} T\n",
    ],
)  # fmt: skip
def test_what_stands_whole_behind_a_tear_is_read(tmp_path: Path, torn: str, place: int, is_packed: bool) -> None:
    path = tmp_path / ("x.log.gz" if is_packed else "x.log")
    content = "".join([*SOUND[:place], torn, *SOUND[place:]]).encode()
    path.write_bytes(gzip.compress(content) if is_packed else content)
    log = open_log(path, BUSES)
    for _ in range(2):
        assert list(log) == FRAMES
    assert log.remarks == (f"{path}:{place + 1}: {SAID}",)


def test_of_several_torn_lines_the_first_is_named_and_all_are_counted(tmp_path: Path) -> None:
    path = tmp_path / "x.log"
    path.write_text("(0.9) c".join(["", *SOUND]) + f"{ROOM}\n" * 2)
    log = open_log(path, BUSES)
    assert list(log) == FRAMES
    assert log.remarks == (f"{path}:1: {SAID}, as of 4 further lines",)


@pytest.mark.parametrize(
    "line",
    [
        "(1.0) can0 1\n", "what is this(1.0) can0 123#AA\n", "(1.0) can0 XY(1.0) can0 123#AA\n",
        "(1.0) can0 123#00(1.0) can0 1\n", f"{ROOM}what is this\n", f"what is this{ROOM}\n",
        f"(1.0) can0 12{ROOM}3#A{ROOM}A\n", f"{ROOM}(1.0) can0 E0000080#00\n",
    ],
)  # fmt: skip
def test_any_other_line_that_is_none_is_refused(tmp_path: Path, line: str) -> None:
    path = tmp_path / "x.log"
    path.write_text("".join([*SOUND, line, *SOUND]))
    with pytest.raises(InputError) as caught:
        list(open_log(path, BUSES))
    assert str(caught.value).startswith(f"{path}:4: ")


@pytest.mark.parametrize("content", ["".join(SOUND).encode("utf-16-le"), ROOM.encode(), f"{ROOM}\n".encode() * 3])
def test_a_file_without_any_line_is_no_recording(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "x.log"
    path.write_bytes(content)
    with pytest.raises(InputError):
        open_log(path, BUSES)


@pytest.mark.parametrize("torn", ["(1.0) can0 0000", "(1.0) can0 000001A0#", f"{ROOM}1A0#01\n"])
def test_ids_are_seen_through_though_a_line_is_torn(tmp_path: Path, torn: str) -> None:
    path = tmp_path / "x.log"
    path.write_text(f"(1.0) can0 000001A0#01\n{torn}(2.0) can0 000002FF#01\n")
    assert [(frame.can_id, frame.extended) for frame in open_log(path, BUSES)] == [(0x1A0, False), (0x2FF, False)]


messages = st.builds(
    lambda time_us, can_id, extended, data, kind: can.Message(
        timestamp=time_us / 1e6,
        channel="can0",
        arbitration_id=can_id if extended else can_id & 0x7FF,
        is_extended_id=extended,
        is_fd=kind == "FD",
        is_remote_frame=kind == "remote",
        data=b"" if kind == "remote" else data if kind == "FD" else data[:8],
    ),
    st.integers(0, 2 * 10**15), st.integers(0, 0x1FFFFFFF), st.booleans(),
    st.sampled_from([0, 1, 5, 8, 12, 64]).flatmap(lambda size: st.binary(min_size=size, max_size=size)),
    st.sampled_from(["classic", "classic", "FD", "remote"]),
)  # fmt: skip
begun, zeros, ends = st.floats(0.0, 1.0), st.integers(0, 3), st.floats(0.0, 1.0)
tears = st.none() | st.tuples(messages, begun, zeros, ends)


def text_of(message: can.Message, folder: Path) -> str:
    """Its line, as python-can writes it."""
    path = folder / "line.log"
    with can.CanutilsLogWriter(path) as writer:
        writer.on_message_received(message)
    return path.read_text()


def remains(line: str, begun: float, zeros: int, ends: float) -> str:
    """What a tear leaves of a line: its beginning; where room was made for more, its end may have come as well."""
    room = zeros * "\0"
    return line[: int(begun * (len(line) - 1))] + room + (line[1 + int(ends * (len(line) - 1)) :] if room else "")


@pytest.mark.parametrize("chunk_bytes", [1, 100, 1 << 17])
@hypothesis_settings(max_examples=150, deadline=None)
@given(recorded=st.lists(st.tuples(tears, messages), min_size=1, max_size=8))
def test_sound_lines_are_read_as_python_can_reads_them_whatever_is_torn_between(
    tmp_path_factory: pytest.TempPathFactory,
    chunk_bytes: int,
    recorded: list[tuple[tuple[can.Message, float, int, float] | None, can.Message]],
) -> None:
    folder = tmp_path_factory.getbasetemp()
    torn, sound = folder / "torn.log", folder / "sound.log"
    lines = [text_of(message, folder) for _, message in recorded]
    pieces = [remains(text_of(tear[0], folder), *tear[1:]) if tear else "" for tear, _ in recorded]
    sound.write_text("".join(lines))
    torn.write_text("".join(piece + line for piece, line in zip(pieces, lines, strict=True)))
    with pytest.MonkeyPatch.context() as patch, can.CanutilsLogReader(sound) as oracle:
        patch.setattr(candump_blocks, "CHUNK_BYTES", chunk_bytes)
        frames, said = list(open_log(torn, BUSES)), list(oracle)
    assert [(f.time_s, f.can_id, f.data, f.kind is FrameKind.REMOTE) for f in frames] == [
        (m.timestamp, m.arbitration_id, bytes(m.data), m.is_remote_frame) for m in said
    ]
