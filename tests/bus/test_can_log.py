import gzip
import logging
import sqlite3
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from random import Random

import can
import cantools
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from brake_monitor.bus import gathering
from brake_monitor.bus.can_log import open_log
from brake_monitor.bus.time_order import TimeOrder
from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.errors import InputError
from brake_monitor.frame import Frame, FrameKind
from brake_monitor.frame_block import FrameBlock
from brake_monitor.host import python_can
from brake_monitor.samples import Quality, Quantity
from brake_monitor.settings.config import CanBus
from brake_monitor.settings.config_file import load_settings

DATA = Path(__file__).parents[1] / "data"
FORMATS = (".log", ".asc", ".blf", ".trc", ".csv", ".db", ".mf4")
ONE = (CanBus("virtual", "can0", (), "can0"),)
TWO = (CanBus("virtual", "vcan0", (), "front"), CanBus("virtual", "vcan1", (), "rear"))

MESSAGES = [
    can.Message(
        timestamp=1700000000.0 + 0.01 * i,
        arbitration_id=0x1A0 if i % 2 else 0x18FF5030,
        is_extended_id=i % 2 == 0,
        data=bytes(range(i % 9)),
        channel=0,
    )
    for i in range(40)
]

RANDOM = Random(3)
UNLIKE = [  # as long packed as their number says
    can.Message(timestamp=1.7e9 + k, arbitration_id=0x1A0, is_extended_id=False, data=RANDOM.randbytes(8), channel=0)
    for k in range(4000)
]


def recorded(path: Path, messages: list[can.Message] = MESSAGES) -> Path:
    writer: Callable[..., can.Logger] = can.Logger
    if path.suffix == ".mf4":
        pytest.importorskip("asammdf")
        writer = python_can.mf4().MF4Writer
    with writer(str(path)) as logger:
        for message in messages:
            logger.on_message_received(message)
    return path


def zipped(path: Path) -> Path:
    packed = path.with_name(path.name + ".gz")
    packed.write_bytes(gzip.compress(path.read_bytes()))
    return packed


def refusal(path: Path, buses: tuple[CanBus, ...] = ONE) -> str:
    with pytest.raises(InputError) as caught:
        list(open_log(path, buses))
    sentence = str(caught.value)
    assert sentence.startswith(str(path))
    assert "\n" not in sentence
    return sentence.removeprefix(str(path))


# --- recordings ---


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize("pack", [lambda path: path, zipped], ids=["plain", "gz"])
def test_every_format_gives_the_same_frames(tmp_path: Path, suffix: str, pack: Callable[[Path], Path]) -> None:
    log = open_log(pack(recorded(tmp_path / f"x{suffix}")), ONE)
    assert log.progress() == 0.0
    frames = list(log)
    assert log.progress() == 1.0
    assert [(f.bus, f.can_id, f.extended, f.data, f.kind) for f in frames] == [
        ("can0", m.arbitration_id, m.is_extended_id, bytes(m.data), FrameKind.DATA) for m in MESSAGES
    ]
    start_s = frames[0].time_s  # .asc counts from 0, the others keep the date
    assert [f.time_s - start_s for f in frames] == pytest.approx([0.01 * i for i in range(40)], abs=2e-4)
    assert list(log) == frames  # each iteration starts anew


def test_progress_rises_while_reading(tmp_path: Path) -> None:
    log = open_log(recorded(tmp_path / "x.log", MESSAGES * 2000), ONE)
    seen = [log.progress() for _ in log]
    assert seen == sorted(seen)
    assert 0.2 < seen[len(seen) // 2] < 0.8


def test_a_recording_that_is_moved_while_it_is_read_is_read_to_its_end(tmp_path: Path) -> None:
    path = recorded(tmp_path / "x.log", MESSAGES * 2000)
    log = open_log(path, ONE)
    blocks = log.blocks()
    read = [next(blocks)]
    path.rename(tmp_path / "x.log.1")
    assert 0.0 < log.progress() < 1.0
    assert sum(map(len, [*read, *blocks])) == len(MESSAGES) * 2000


def test_kinds_of_frames_survive(tmp_path: Path) -> None:
    messages = [
        can.Message(timestamp=1.0, arbitration_id=1, is_extended_id=False, is_remote_frame=True, dlc=2),
        can.Message(timestamp=2.0, is_error_frame=True),
        can.Message(timestamp=3.0, arbitration_id=1, is_extended_id=False, is_fd=True, data=bytes(24)),
    ]
    for suffix in (".log", ".blf"):
        frames = list(open_log(recorded(tmp_path / f"x{suffix}", messages), ONE))
        assert [frame.kind for frame in frames] == [FrameKind.REMOTE, FrameKind.ERROR, FrameKind.DATA]
        assert len(frames[2].data) == 24


@pytest.mark.parametrize(
    ("suffix", "lines"),
    [
        (
            ".asc",
            ["base hex", "internal events logged", "0.1 1 1A0 Rx r 4", "0.2 1 1A0 Rx d f 01 02 03 04 05 06 07 08"],
        ),
        (
            ".trc",
            [";$FILEVERSION=2.1", ";$COLUMNS=N,O,T,I,d,L,D", "1 1.0 RR 01A0 Rx 4", f"2 2.0 DT 01A0 Rx 15 {' 07' * 8}"],
        ),
    ],
)
def test_a_text_may_tell_of_more_bytes_than_there_have_to_be(tmp_path: Path, suffix: str, lines: list[str]) -> None:
    """A remote frame has none of those it asks for, and a classic one has eight whatever more its number says."""
    path = tmp_path / f"x{suffix}"
    path.write_text("\n".join(lines) + "\n")
    frames = list(open_log(path, ONE))
    assert [(frame.kind, len(frame.data)) for frame in frames] == [(FrameKind.REMOTE, 0), (FrameKind.DATA, 8)]


TRC_FILES = {  # one of each version, and what is none beside it
    "1.0": ["1) 1841 0001 2 00 01", "2) 1842 0008 4 ERROR 00 19 08 08", "3) 1843 FFFFFFFF 4 00 00 00 04 BUSLIGHT"],
    "1.1": ["1) 1841.0 Rx 0001 2 00 01", "2) 1842.0 Error 0008 4 00 19 08 08", "3) 1843.0 Warng FFFFFFFF 1 04"],
    "1.3": ["1) 1841.0 1 Rx 0001 - 2 00 01", "2) 1842.0 2 Error 0008 - 4 00 19 08 08"],
    "2.0": ["1 1841.0 DT 0001 Rx 2 00 01", "2 1842.0 ER Rx 5 04 00 02 00 00", "3 1843.0 EV an Error and an ER"],
    "2.1": ["1 1841.0 DT 1 0001 Rx - 2 00 01", "2 1842.0 ER 2 - Rx - 5 04 00 02 00 00", "3 1843.0 EC 1 - Rx - 2 01 00"],
}
TRC_COLUMNS = {"2.0": "N,O,T,I,d,l,D", "2.1": "N,O,T,B,I,d,R,L,D"}


@pytest.mark.parametrize("version", TRC_FILES)
def test_error_frames_of_a_trc_file_are_told_of(tmp_path: Path, version: str) -> None:
    path = tmp_path / "x.trc"
    header = [] if version == "1.0" else [f";$FILEVERSION={version}", ";$STARTTIME=43000.5"]
    header += [f";$COLUMNS={TRC_COLUMNS[version]}"] if version in TRC_COLUMNS else []
    path.write_text("\n".join([*header, *TRC_FILES[version], ""]))
    data, error = open_log(path, TWO)
    assert (data.kind, data.bus, data.data) == (FrameKind.DATA, "front", b"\x00\x01")
    assert (error.kind, error.bus) == (FrameKind.ERROR, "rear" if version in ("1.3", "2.1") else "front")
    assert error.time_s - data.time_s == pytest.approx(0.001, abs=1e-6)


def test_channels_of_a_candump_log_are_buses_by_channel_or_name(tmp_path: Path) -> None:
    path = tmp_path / "x.log"
    path.write_text("".join(f"(1.0) {channel} 001#00\n" for channel in ("vcan1", "front", "vcan0", "can7", "rear")))
    assert [frame.bus for frame in open_log(path, TWO)] == ["rear", "front", "front", "", "rear"]
    one = open_log(path, ONE)
    assert {frame.bus for frame in one} == {"can0"}  # one bus: every channel is it, and that is told once
    assert one.remarks == (f"{path}: it has frames of several channels, as vcan1 and front: all taken for the one bus",)


@pytest.mark.parametrize("suffix", [".asc", ".blf", ".trc"])
def test_numbered_channels_are_buses_by_place(tmp_path: Path, suffix: str) -> None:
    messages = [can.Message(timestamp=1.0 + n, arbitration_id=n, channel=n, data=b"\0") for n in (0, 1, 2)]
    assert [frame.bus for frame in open_log(recorded(tmp_path / f"x{suffix}", messages), TWO)] == ["front", "rear", ""]


@pytest.mark.parametrize(("channels", "begins_at_0"), [((1, 2, 3), False), ((0, 1, 2), True), ((0,), True)])
def test_an_mf4_file_counts_its_channels_from_1_unless_there_is_a_0(
    tmp_path: Path, channels: tuple[int, ...], begins_at_0: bool
) -> None:
    """Loggers begin with 1; python-can's writer puts down what its interfaces are called, can0 as 0."""
    messages = [can.Message(timestamp=1.7e9 + n, arbitration_id=n, channel=n, data=b"\0") for n in channels]
    path = recorded(tmp_path / "x.mf4", messages)
    log = open_log(path, TWO)
    assert [frame.bus for frame in log] == ["front", "rear", ""][: len(channels)]
    remark = f"{path}: it has a bus channel 0: taken for front, 1 for the next"
    assert log.remarks == ((remark,) if begins_at_0 else ())
    said = f"{path}: it has frames of several channels, as 1 and 2: all taken for the one bus"
    assert open_log(path, ONE).remarks == ((said,) if len(channels) > 1 else ())


@pytest.mark.parametrize(
    ("place", "said"),
    [
        (8, "its parts do not fit together"),  # not ASCII
        (64, "it is not a valid MDF file"),
        (100, "its parts do not fit together"),  # a number that none may be
        (120, "Incomplete block at 0xffffffff exceeds the file size"),
    ],
)
def test_damage_is_told_without_what_python_calls_things(tmp_path: Path, place: int, said: str) -> None:
    path = recorded(tmp_path / "x.mf4", [can.Message(timestamp=1.7e9, arbitration_id=1, channel=1, data=b"\0")])
    content = bytearray(path.read_bytes())
    content[place : place + 4] = b"\xff" * 4
    path.write_bytes(content)
    with pytest.raises(InputError) as refusal:
        open_log(path, ONE)
    assert str(refusal.value).startswith(f"{path}: damaged, or not a .mf4 file: {said}")
    assert "_io." not in str(refusal.value)
    assert "From_" not in str(refusal.value)


def test_damage_without_a_word_for_it(tmp_path: Path) -> None:
    path = recorded(tmp_path / "x.blf", [can.Message(timestamp=1.7e9, arbitration_id=1, channel=1, data=b"\0")])
    path.write_bytes(path.read_bytes() + bytes(1000))
    with pytest.raises(InputError, match=r"damaged, or not a \.blf file: its parts do not fit together"):
        list(open_log(path, ONE))


PADDED = "(1.0) can0 000001A0#0102\n\n(1.1) can0 20000080#00\n(1.2) can0 000002FF#\n"


@pytest.mark.parametrize("pack", [lambda path: path, zipped], ids=["plain", "gz"])
def test_a_recorder_that_pads_its_ids_is_seen_through(tmp_path: Path, pack: Callable[[Path], Path]) -> None:
    path = tmp_path / "x.log"
    path.write_text(PADDED)
    log = open_log(pack(path), ONE)
    (remark,) = log.remarks
    assert "taken for 11-bit ids" in remark
    data = [frame for frame in log if frame.kind is FrameKind.DATA]
    assert [(frame.can_id, frame.extended) for frame in data] == [(0x1A0, False), (0x2FF, False)]


@pytest.mark.parametrize("other", ["1A0#01", "18FF5030#01", "00000800#01"])
@pytest.mark.parametrize("is_first", [True, False])
def test_a_recorder_that_does_not_is_believed(tmp_path: Path, other: str, is_first: bool) -> None:
    """An extended twin of a standard id is another message, wherever in the file the other ids show it."""
    path = tmp_path / "x.log"
    path.write_text(f"(1.0) can0 {other}\n{PADDED}" if is_first else f"{PADDED * 500}(2.0) can0 {other}\n")
    log = open_log(path, ONE)
    assert log.remarks == ()
    assert {frame.extended for frame in log if frame.can_id in (0x1A0, 0x2FF) and len(frame.data) != 1} == {True}


# --- recordings that are damaged or none ---


def test_what_is_no_recording(tmp_path: Path) -> None:
    (tmp_path / "folder.log").mkdir()
    (tmp_path / "x.foo").touch()
    assert refusal(tmp_path / "none.log") == ": cannot be read: No such file or directory"
    assert refusal(tmp_path / "folder.log") == ": cannot be read: Is a directory"
    for path in (tmp_path, tmp_path / "x.foo", tmp_path / "x", tmp_path / "x.gz"):
        assert refusal(path).startswith(": unknown kind of log, expected one of .log, ")


def test_a_table_of_something_else_is_told_which_columns_are_expected(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    path.write_text("time,speed\n0.1,12.5\n")
    columns = "timestamp, arbitration_id, extended, remote, error, dlc, data"
    assert refusal(path) == f":2: damaged, or not a .csv file: expected {columns}, as python-can writes them"


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize(
    "content", [b"", bytes(range(256)) * 40, b"no frames\nare here\n"], ids=["empty", "garbage", "text"]
)
def test_files_without_frames(tmp_path: Path, suffix: str, content: bytes, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / f"x{suffix}"
    path.write_bytes(content)
    assert refusal(path)
    assert capsys.readouterr().err == ""  # no reader's own noise beside the one sentence


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize("pack", [lambda path: path, zipped], ids=["plain", "gz"])
def test_an_empty_file_is_called_so(tmp_path: Path, suffix: str, pack: Callable[[Path], Path]) -> None:
    path = tmp_path / f"x{suffix}"
    path.touch()
    assert refusal(pack(path)) == ": is empty"


@pytest.mark.parametrize("pack", [lambda path: path, zipped], ids=["plain", "gz"])
def test_a_text_may_begin_with_a_byte_order_mark(tmp_path: Path, pack: Callable[[Path], Path]) -> None:
    path = recorded(tmp_path / "x.log")
    frames = list(open_log(path, ONE))
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert list(open_log(pack(path), ONE)) == frames


def test_an_mf4_file_that_was_cut_off_says_so(tmp_path: Path) -> None:
    path = recorded(tmp_path / "x.mf4", MESSAGES * 50)
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
    assert refusal(path) == ": damaged, or not a .mf4 file: it ends in the middle"


def test_an_mf4_file_that_its_recorder_did_not_finish_says_so(tmp_path: Path) -> None:
    path = recorded(tmp_path / "x.mf4")
    assert open_log(path, ONE).remarks == ()
    content = path.read_bytes()
    assert content.startswith(b"MDF     ")
    path.write_bytes(b"UnFinMF " + content[8:])
    source = open_log(path, ONE)
    assert len(list(source)) == len(MESSAGES)
    assert source.remarks == (
        f"{path}: was not finished by its recorder, as those of some never are, or was cut off: read as far as it goes",
    )


def test_an_mf4_file_that_cannot_be_read_as_far_as_it_goes_is_refused_in_one_sentence(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """asammdf is to work out the length of its last block, and stumbles over its own names."""
    path = recorded(tmp_path / "x.mf4")
    content = path.read_bytes()
    length_unknown = (4).to_bytes(2, "little")
    path.write_bytes(b"UnFinMF " + content[8:60] + length_unknown + content[62:])
    assert refusal(path) == ": damaged, or not a .mf4 file: its parts do not fit together"
    assert capfd.readouterr() == ("", "")


def test_what_asammdf_prints_while_it_reads_is_not_heard(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = recorded(tmp_path / "x.mf4")
    readers = python_can.mf4().MF4Reader
    read = readers.__iter__

    def read_aloud(reader: object) -> Iterator[can.Message]:
        for message in read(reader):
            print("a traceback")
            yield message
        raise KeyError("CAN_DataFrame.ID")

    monkeypatch.setattr(readers, "__iter__", read_aloud)
    with closing(iter(open_log(path, ONE))) as frames:
        next(frames)
        print("our own word")
    assert refusal(path) == ": damaged, or not a .mf4 file: its parts do not fit together"
    assert capfd.readouterr() == ("our own word\n", "")


def test_what_asammdf_complains_of_is_one_remark(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """The comment of the header is XML; without its end the frames are there all the same."""
    path = recorded(tmp_path / "x.mf4")
    content = path.read_bytes()
    assert content.count(b"<HDcomment") == content.count(b"</HDcomment>") == 1
    path.write_bytes(content.replace(b"</HDcomment>", b"<<HDcomment>"))
    source = open_log(path, ONE)
    assert len(list(source)) == len(MESSAGES)
    (remark,) = source.remarks
    assert remark.startswith(f"{path}: may be damaged: ")
    assert capfd.readouterr().err == ""
    assert logging.getLogger("asammdf").filters == []


def test_an_mf4_file_with_spoilt_blocks_is_refused_in_one_sentence(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = recorded(tmp_path / "x.mf4")
    content = path.read_bytes()
    for block in (b"##CN", b"##CG", b"##DG", b"##CA"):
        if block in content:
            path.write_bytes(content.replace(block, b"#<" + block[2:]))
            assert refusal(path).startswith(": damaged, or not a .mf4 file: ")
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("suffix", FORMATS)
def test_what_is_not_packed_is_refused(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"x{suffix}.gz"
    path.write_bytes(b"this is not packed at all")
    assert "gzip" in refusal(path).lower()


@pytest.mark.parametrize("suffix", [".blf", ".db", ".mf4"])
def test_a_packed_file_that_was_cut_off_and_has_no_lines(tmp_path: Path, suffix: str) -> None:
    packed = zipped(recorded(tmp_path / f"x{suffix}"))
    packed.write_bytes(packed.read_bytes()[:-12])
    assert refusal(packed) == f": damaged, or not a {suffix} file: it ends in the middle"


LINES = [".log", ".asc", ".trc", ".csv"]


@pytest.mark.parametrize("suffix", LINES)
@pytest.mark.parametrize("share", [0.2, 0.9])
def test_a_packed_text_that_was_cut_off_is_read_up_to_there(tmp_path: Path, suffix: str, share: float) -> None:
    path = recorded(tmp_path / f"x{suffix}", UNLIKE)
    whole, packed = list(open_log(path, ONE)), zipped(path)
    packed.write_bytes(packed.read_bytes()[: int(share * packed.stat().st_size)])
    log = open_log(packed, ONE)
    frames = list(log)
    assert frames == whole[: len(frames)]
    assert share - 0.15 < len(frames) / len(whole) < share + 0.05
    assert list(log) == frames
    assert log.remarks == (f"{packed}: is cut off: read up to there",)


@pytest.mark.parametrize("cut", [1, 8])
def test_a_packed_text_that_lacks_nothing_but_its_end_mark_is_read_to_its_end(tmp_path: Path, cut: int) -> None:
    path = recorded(tmp_path / "x.log", UNLIKE)
    whole, packed = list(open_log(path, ONE)), zipped(path)
    packed.write_bytes(packed.read_bytes()[:-cut])
    log = open_log(packed, ONE)
    assert list(log) == whole
    assert log.remarks == (f"{packed}: is cut off: read up to there",)


def test_ids_are_seen_through_though_the_packed_file_is_cut_off(tmp_path: Path) -> None:
    path = tmp_path / "x.log"
    path.write_text("".join(f"({k}.0) can0 000001A0#{k * 7919 % 65536:04X}\n" for k in range(500)))
    packed = zipped(path)
    packed.write_bytes(packed.read_bytes()[: packed.stat().st_size // 2])
    log = open_log(packed, ONE)
    assert {(frame.can_id, frame.extended) for frame in log} == {(0x1A0, False)}
    assert len(log.remarks) == 2


@pytest.mark.parametrize("suffix", LINES)
@pytest.mark.parametrize("size", [5, 40])
def test_a_packed_text_that_was_cut_off_before_its_first_frame_is_no_recording(
    tmp_path: Path, suffix: str, size: int
) -> None:
    packed = zipped(recorded(tmp_path / f"x{suffix}", UNLIKE))
    packed.write_bytes(packed.read_bytes()[:size])
    assert refusal(packed)


@pytest.mark.parametrize("suffix", LINES)
def test_a_packed_text_that_is_damaged_in_its_middle_is_refused(tmp_path: Path, suffix: str) -> None:
    packed = zipped(recorded(tmp_path / f"x{suffix}", UNLIKE))
    content = bytearray(packed.read_bytes())
    content[len(content) // 2] ^= 0xFF
    packed.write_bytes(content)
    assert refusal(packed)


@pytest.mark.parametrize("suffix", [".log", ".trc", ".csv"])
def test_a_line_that_was_cut_off_is_named(tmp_path: Path, suffix: str) -> None:
    path = recorded(tmp_path / f"x{suffix}")
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join(lines[:-1]) + lines[-1][: len(lines[-1]) // 3] + "\n")
    assert refusal(path).startswith(f":{len(lines)}: ")
    lines[-3] = "@@@\n"
    path.write_text("".join(lines))
    assert refusal(path).startswith(f":{len(lines) - 2}: ")


@pytest.mark.parametrize("pack", [lambda path: path, zipped], ids=["plain", "gz"])
@pytest.mark.parametrize("copies", [1, 400])  # one block and several
@pytest.mark.parametrize(
    "rest",
    ["(1700", "(1700000000.1) can0 1A0", "(1700000000.1) can0 1A0#0", "\0" * 70],
    ids=["time", "id", "data", "zeros"],
)
def test_the_last_line_of_a_recorder_that_lost_power_is_left_out(
    tmp_path: Path, pack: Callable[[Path], Path], copies: int, rest: str
) -> None:
    path = recorded(tmp_path / "x.log", MESSAGES * copies)
    frames = list(open_log(path, ONE))
    path.write_text(path.read_text() + rest)
    path = pack(path)
    log = open_log(path, ONE)
    assert list(log) == frames
    assert list(log) == frames
    of_lines = [remark for remark in log.remarks if not remark.startswith(f"{path}: ")]  # the copies' times repeat
    assert of_lines == [f"{path}:{len(frames) + 1}: the last line is cut off: left out"]


@pytest.mark.parametrize("pack", [lambda path: path, zipped], ids=["plain", "gz"])
@pytest.mark.parametrize(("suffix", "share"), [(".asc", 0.8), (".trc", 0.9), (".csv", 0.5)])
@pytest.mark.parametrize("zeros", ["", "\0" * 70], ids=["cut", "zeros"])
def test_so_is_that_of_any_text(
    tmp_path: Path, pack: Callable[[Path], Path], suffix: str, share: float, zeros: str
) -> None:
    path = recorded(tmp_path / f"x{suffix}", UNLIKE[:100])
    frames = list(open_log(path, ONE))
    lines = [
        line for line in path.read_text().splitlines(keepends=True) if "TriggerBlock" not in line or "Begin" in line
    ]
    path.write_text("".join(lines[:-1]) + lines[-1][: int(share * len(lines[-1]))] + zeros)
    path = pack(path)
    log = open_log(path, ONE)
    assert list(log) == frames[:-1]
    assert log.remarks == (f"{path}:{len(lines)}: the last line is cut off: left out",)


@pytest.mark.parametrize("rest", ["(1.", "(1.3) can0 0000", "(1.3) can0 000001A0#0"])
def test_ids_are_seen_through_though_the_last_line_is_cut_off(tmp_path: Path, rest: str) -> None:
    path = tmp_path / "x.log"
    path.write_text(PADDED + rest)
    log = open_log(path, ONE)
    data = [frame for frame in log if frame.kind is FrameKind.DATA]
    assert [(frame.can_id, frame.extended) for frame in data] == [(0x1A0, False), (0x2FF, False)]
    assert len(log.remarks) == 2


def test_a_single_line_that_is_none_is_no_recording(tmp_path: Path) -> None:
    (tmp_path / "x.log").write_text("what is this")
    assert refusal(tmp_path / "x.log").startswith(":1: not a line of candump's log format")


@pytest.mark.parametrize("stamp", ["", " (1700000000.001790)", " (000.000000)"], ids=["none", "absolute", "difference"])
def test_who_recorded_what_candump_shows_is_told_how_to_record(tmp_path: Path, stamp: str) -> None:
    (tmp_path / "x.log").write_text(f"{stamp}  can0  1A0   [8]  E4 2E D9 2E 00 00 00 00\n" * 3)
    assert ":1: not a line of candump's log format, which candump -l writes: " in refusal(tmp_path / "x.log")


@pytest.mark.parametrize("pack", [lambda path: path, zipped], ids=["plain", "gz"])
@pytest.mark.parametrize("share", [0.2, 0.5, 0.999])
def test_a_blf_file_that_was_cut_off_says_so(tmp_path: Path, pack: Callable[[Path], Path], share: float) -> None:
    path = recorded(tmp_path / "x.blf", MESSAGES * 20)
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    assert f"cut off: its header says {len(content)} bytes" in refusal(pack(path))


@pytest.mark.parametrize("length", [0, 144], ids=["none", "as at its beginning"])
@pytest.mark.parametrize("cut", [0, 3, 20, 34])
def test_a_blf_file_that_its_recorder_did_not_finish_is_read_as_far_as_it_goes(
    tmp_path: Path, length: int, cut: int
) -> None:
    path = recorded(tmp_path / "x.blf")
    whole = path.read_bytes()
    content = bytearray(whole + whole[144:])  # a second container, of which no more than its headers is there
    content[16:24] = length.to_bytes(8, "little")
    path.write_bytes(content[: len(whole) + cut])
    log = open_log(path, ONE)
    assert len(list(log)) == len(MESSAGES)
    assert [remark.removeprefix(f"{path}: ") for remark in log.remarks] == [
        "was not finished by its recorder, as those of some never are, or was cut off: read as far as it goes"
    ]


def test_containers_of_a_blf_file_are_put_together(tmp_path: Path) -> None:
    many = MESSAGES * 600
    log = open_log(recorded(tmp_path / "many.blf", many), ONE)
    sizes = [len(block) for block in log.blocks()]
    assert sum(sizes) == len(many)
    assert min(sizes[:-1]) >= gathering.BLOCK_FRAMES
    assert [frame.data for frame in log] == [message.data for message in many]


def test_a_blf_object_without_length_is_refused(tmp_path: Path) -> None:
    """python-can would go round at it for ever."""
    path = tmp_path / "x.blf"
    with can.BLFWriter(path, compression_level=0) as writer:
        for message in MESSAGES:
            writer(message)
    content = bytearray(path.read_bytes())
    place = content.rindex(b"LOBJ") + 8  # after signature, length of the header and its version
    content[place : place + 4] = bytes(4)
    path.write_bytes(content)
    assert refusal(path).endswith("an object says that it has 0 bytes")


def test_a_blf_file_whose_header_says_more_than_any_file_has(tmp_path: Path) -> None:
    path = recorded(tmp_path / "x.blf")
    content = bytearray(path.read_bytes())
    content[16:24] = b"\xff" * 8  # the length of the file
    path.write_bytes(content)
    assert refusal(path) == f": damaged, or not a .blf file: cut off: its header says {2**64 - 1} bytes"


@pytest.mark.parametrize("header", ["timestamps relative", "Timestamps Relative"])
def test_an_asc_file_whose_times_count_from_line_to_line_is_refused(tmp_path: Path, header: str) -> None:
    """One whose times count from the start, whatever its header calls that, is read."""
    lines = ["date Mon Oct 5 10:00:00.000 am 2026", f"base hex  {header}", "internal events logged"]
    lines += ["Begin Triggerblock Mon Oct 5 10:00:00.000 am 2026", "   0.000000 Start of measurement"]
    from_start = [f"   {time_s} 1  123             Rx   d 2 01 02" for time_s in ("0.100000", "0.110000", "0.120000")]
    path = tmp_path / "x.asc"
    path.write_text("\n".join([*lines, *from_start, "End TriggerBlock", ""]))
    assert [round(frame.time_s % 1.0, 6) for frame in open_log(path, ONE)] == [0.1, 0.11, 0.12]
    path.write_text("\n".join([*lines, *from_start, from_start[0], "End TriggerBlock", ""]))
    assert "timestamps are relative, and they fall" in refusal(path)
    assert "expected absolute ones" in refusal(path)


IN_ASC = ["0.1 1 123 Rx d 2 01 02", "0.2 1 124 Rx d 2 10 20"]
DATED = "date Mon Oct 5 10:00:00.000 am 2026"


@pytest.mark.parametrize("header", [[DATED, "base hex  timestamps absolute"], [DATED], []])
def test_an_asc_file_whose_header_has_no_end_is_read_from_its_first_frame_on(tmp_path: Path, header: list[str]) -> None:
    path = tmp_path / "x.asc"
    path.write_text("\n".join([*header, *IN_ASC, ""]))
    assert [(frame.can_id, frame.data.hex()) for frame in open_log(path, ONE)] == [(0x123, "0102"), (0x124, "1020")]


@pytest.mark.parametrize("other", ["", "; made by a converter", "version 8.5.1", "internal events logged"])
@pytest.mark.parametrize("base", ["base dec  timestamps absolute", "Base Dec"])
def test_the_base_of_an_asc_file_counts_wherever_in_the_header_it_stands(tmp_path: Path, other: str, base: str) -> None:
    path = tmp_path / "x.asc"
    path.write_text("\n".join([other, DATED, base, "internal events logged", *IN_ASC, ""]))
    assert [(frame.can_id, frame.data.hex()) for frame in open_log(path, ONE)] == [(123, "0102"), (124, "0a14")]


def test_an_asc_file_that_tells_what_was_to_be_sent_has_each_frame_once(tmp_path: Path) -> None:
    path = tmp_path / "x.asc"
    sent = ["0.3 1 1A0x Tx d 1 01", "0.5 CANFD 1 Tx 1A1 1 0 1 1 02"]
    requests = ["0.1 1 1A0x TxRq d 1 01", "0.4 CANFD 1 TxRq 1A1 1 0 1 1 02"]
    path.write_text("\n".join(["base hex", requests[0], sent[0], requests[1], sent[1], ""]))
    assert [(frame.time_s, frame.can_id) for frame in open_log(path, ONE)] == [(0.3, 0x1A0), (0.5, 0x1A1)]


def test_a_csv_file_without_header_is_read_from_its_first_frame_on(tmp_path: Path) -> None:
    """As python-can writes it where it is told to append to a file that is not there yet."""
    path = tmp_path / "x.csv"
    with can.Logger(str(path), append=True) as logger:
        for message in MESSAGES:
            logger.on_message_received(message)
    assert len(list(open_log(path, ONE))) == len(MESSAGES)


def test_a_trc_file_may_have_an_empty_line_anywhere(tmp_path: Path) -> None:
    path = recorded(tmp_path / "x.trc")
    header, _, frames = path.read_text().rpartition(";---")
    rule, *lines = frames.splitlines()
    path.write_text(f"{header};---{rule}\n\n" + "\n \n".join(lines) + "\n\n")
    assert len(list(open_log(path, ONE))) == len(MESSAGES)


@pytest.mark.parametrize(
    ("suffix", "lines", "place", "expected"),
    [
        (".trc", [";$FILEVERSION=3.0", "     1)      1.900  DT  0300  2  07 08"], 2, "a hexadecimal number, got 'DT'"),
        (".asc", ["base hex", "internal events logged", "0.1 1 A1G Rx d 1 02"], 3, "a hexadecimal number, got 'A1G'"),
        (".csv", ["timestamp,arbitration_id,…", "x,0x300,0,0,0,2,Bwg="], 2, "a number, got 'x'"),
    ],
)  # fmt: skip
def test_what_stands_where_a_number_should_is_named(
    tmp_path: Path, suffix: str, lines: list[str], place: int, expected: str
) -> None:
    path = tmp_path / f"x{suffix}"
    path.write_text("\n".join([*lines, ""]))
    assert refusal(path) == f":{place}: damaged, or not a {suffix} file: expected {expected}"


@pytest.mark.parametrize(("size", "is_fd"), [(8, False), (24, True)])
def test_a_line_with_fewer_bytes_than_it_announces_is_named(tmp_path: Path, size: int, is_fd: bool) -> None:
    message = can.Message(timestamp=1.7e9, arbitration_id=0x18FF5030, is_fd=is_fd, data=bytes(range(size)))
    path = recorded(tmp_path / "x.asc", [message, message])
    lines = path.read_text().splitlines(keepends=True)
    place = next(number for number, line in enumerate(lines) if "18FF5030" in line)
    lines[place] = lines[place].rpartition(f" {size - 2:02X} ")[0] + "\n"
    path.write_text("".join(lines[: place + 1]))
    assert refusal(path) == f":{place + 1}: damaged, or not a .asc file: {size - 2} of {size} bytes are there"


@pytest.mark.parametrize("suffix", [".mf4", ".db", ".blf", ".asc"])
@hypothesis_settings(max_examples=25, deadline=None)
@given(share=st.floats(0.0, 0.99))
def test_a_file_cut_anywhere_gives_frames_or_one_sentence(
    tmp_path_factory: pytest.TempPathFactory, suffix: str, share: float
) -> None:
    folder = tmp_path_factory.getbasetemp()
    whole = folder / f"whole{suffix}"
    if not whole.exists():
        recorded(whole, MESSAGES[:10])
    content = whole.read_bytes()
    cut = folder / f"cut{suffix}"
    cut.write_bytes(content[: int(share * len(content))])
    try:
        frames = list(open_log(cut, ONE))
    except InputError:
        return
    assert len(frames) <= 10


def test_mf4_without_its_extra_says_how_to_get_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = recorded(tmp_path / "x.mf4")
    monkeypatch.setitem(sys.modules, "asammdf", None)
    assert "pip install '.[mf4]' in the checkout" in refusal(path)
    assert "No such file" in refusal(tmp_path / "y.mf4")


def test_a_reader_leaves_no_handler_behind(tmp_path: Path) -> None:
    list(open_log(recorded(tmp_path / "x.trc"), ONE))
    assert logging.getLogger("can.io.trc").handlers == []


def test_a_database_of_something_else(tmp_path: Path) -> None:
    with sqlite3.connect(tmp_path / "x.db") as database:
        database.execute("create table cheese (kind text)")
    database.close()
    assert "no such table" in refusal(tmp_path / "x.db")


# --- a J1939 recording through the whole decoding path ---


def test_a_j1939_recording_decodes_as_cantools_does() -> None:
    settings = load_settings(DATA / "mini_j1939.toml")
    decoder = SignalDecoder.from_settings(settings)
    dbc = cantools.database.load_file(DATA / "mini_j1939.dbc", strict=False)
    wanted = {
        0x0CFF0421: "VehicleSpeed", 0x18FF0400: "VehicleSpeed", 0x18EF0033: "WheelSpeed", 0x04EF2705: "WheelSpeed",
    }  # fmt: skip
    qualities: Counter[Quality] = Counter()
    for frame in open_log(DATA / "mini_j1939.log", settings.can):
        samples = {sample.quantity: sample for sample in decoder.decode(frame)}
        qualities.update(sample.quality for sample in samples.values())
        if not samples:
            continue
        physical = dbc.get_message_by_name(wanted[frame.can_id]).decode(frame.data[:8], decode_choices=False)
        if Quantity.SPEED in samples:
            assert samples[Quantity.SPEED].value == pytest.approx(physical["v"] / 3.6)
        else:
            assert samples[Quantity.AXLE_SPEED].value == pytest.approx(physical["n"] / 3.6 / 0.5)
            assert samples[Quantity.PRESSING_FORCE].value == pytest.approx(physical["F"])
    # 20 of each message, and at the end: one error code, one not available, one FD frame, one out of range
    assert qualities == {Quality.GOOD: 61, Quality.NOT_AVAILABLE: 2, Quality.OUT_OF_RANGE: 1}
    counts = decoder.counts
    assert (counts.frames, counts.mapped, counts.unmapped) == (88, 45, 41)
    assert (counts.short_frames, counts.error_frames, counts.remote_frames) == (1, 1, 1)


@pytest.mark.parametrize(
    ("times_s", "said"),
    [
        ([0.0, 0.1, 0.07, 0.2, 0.151], None),  # interfaces that were read one after the other
        ([0.0, 5.0, 1.0, 1.1, 6.0], "time goes back once, by up to 4 s, and the estimate starts anew"),
        ([0.0, 0.4, 0.1, 0.5, 0.3], "time goes back 2 times, by up to 0.3 s, and the estimate starts anew; sort"),
        ([1.0, 0.98, 0.96, 0.94, 0.92, 0.9, 0.88], "time goes back 2 times, by up to 0.06 s"),
    ],
    ids=["hardly", "a clock that was set", "merged unsorted", "reversed"],
)
def test_frames_out_of_order_are_remarked(tmp_path: Path, times_s: list[float], said: str | None) -> None:
    log = tmp_path / "trip.log"
    log.write_text("".join(f"({1e9 + time_s:.6f}) can0 123#00\n" for time_s in times_s))
    source = open_log(log, ONE)
    for _ in range(2):
        assert [round(frame.time_s - 1e9, 6) for frame in source] == times_s
    assert len(source.remarks) == (said is not None)
    assert all(remark.startswith(f"{log}: {said}") for remark in source.remarks)


@pytest.mark.parametrize(("count", "moves", "is_told"), [(100, False, True), (99, False, False), (100, True, False)])
def test_a_recording_without_times_is_remarked(tmp_path: Path, count: int, moves: bool, is_told: bool) -> None:
    """As of a converter that had none: everything at once. In less there may be no time."""
    log = tmp_path / "x.log"
    log.write_text("(0.0) can0 001#00\n" * (count - 1) + f"({0.001 * moves}) can0 001#00\n")
    source = open_log(log, ONE)
    list(source)
    said = f"{log}: its {count} frames all have the same time: nothing can be estimated from them"
    assert source.remarks == ((said,) if is_told else ())


DAY_S = 86400.0


@pytest.mark.parametrize(
    ("times_s", "said"),
    [
        ([0.0, 300.0 * DAY_S], []),  # a wagon that stood for long
        (
            [0.0, 1.0, 1.0 + 3.0 * 365.25 * DAY_S],
            ["time goes ahead once by up to 3 years from one frame to the next: "],
        ),
        ([0.0, 1e8, 1.0], ["time goes back once, by up to 100000000 s", "time goes ahead once by up to 3.17 years"]),
    ],
)
@pytest.mark.parametrize("suffix", [".log", ".csv"])
def test_frames_that_are_years_apart_are_remarked(
    tmp_path: Path, suffix: str, times_s: list[float], said: list[str]
) -> None:
    log = tmp_path / f"trip{suffix}"
    if suffix == ".log":
        log.write_text("".join(f"({1e9 + time_s:.6f}) can0 123#00\n" for time_s in times_s))
    else:
        recorded(log, [can.Message(timestamp=1e9 + time_s, arbitration_id=1, data=b"") for time_s in times_s])
    source = open_log(log, ONE)
    assert len(list(source)) == len(times_s)
    assert len(source.remarks) == len(said)
    assert all(remark.startswith(f"{log}: {one}") for remark, one in zip(source.remarks, said, strict=True))
    order = TimeOrder()
    for time_s in times_s:  # nor does it matter where a block ends
        order.see(FrameBlock.of([Frame(time_s, "can0", 1, False, b"")]))
    assert [remark.startswith(one) for remark, one in zip(order.remarks, said, strict=True)] == [True] * len(said)


def test_an_identifier_of_more_bits_than_there_are_is_refused(tmp_path: Path) -> None:
    path = recorded(tmp_path / "x.csv", [can.Message(timestamp=1.0, arbitration_id=0x20000001, data=b"")])
    assert "identifier 0x20000001 has more than 29 bits" in refusal(path)
