"""A recording on disk: its frames as any log that python-can writes, its truth as CSV; whole or not at all."""

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path

import can
import msgspec

from brake_monitor.errors import InputError
from brake_monitor.frame import CLASSIC_LENGTH, Frame, FrameKind
from brake_monitor.host import extras, python_can
from brake_monitor.host.whole_file import whole_file
from brake_monitor.settings.config import CanBus
from brake_monitor.simulator.due.alarm import Due
from brake_monitor.simulator.sensor_faults import BUS_OFF
from brake_monitor.simulator.simulate import Recording

# What python-can writes and we read; not .db, whose writer drops what still waits in its queue at the end.
_SUFFIXES = (".log", ".asc", ".blf", ".trc", ".csv", ".mf4")
_NEVER_PACKED = (".blf", ".mf4")
_CANDUMP_ERROR_FLAG = 0x20000000


def to_message(frame: Frame) -> can.Message:
    """The frame as python-can writes and sends it; more than eight bytes make it CAN FD."""
    return can.Message(
        timestamp=frame.time_s,
        arbitration_id=frame.can_id,
        is_extended_id=frame.extended,
        data=frame.data,
        channel=frame.bus,
        is_fd=len(frame.data) > CLASSIC_LENGTH,
        is_error_frame=frame.kind is FrameKind.ERROR,
    )


def check_log_kind(path: Path, buses: Sequence[CanBus]) -> None:
    """Refuse what cannot be written.

    InputError when the suffix names no format that can be written, one whose extra is not installed, or one that
    cannot tell these buses apart.
    """
    suffix, is_gzip = _kind(path)
    if suffix not in _SUFFIXES or (is_gzip and suffix in _NEVER_PACKED):
        kinds = ", ".join(_SUFFIXES)
        raise InputError(
            f"{path}: cannot write this kind of log, expected one of {kinds} (the text formats also with .gz)"
        )
    if suffix == ".mf4":
        extras.require("mf4", f"{path}: writing .mf4")
    if suffix == ".csv" and len(buses) > 1:
        raise InputError(f"{path}: .csv does not say which of {len(buses)} buses a frame was on; .log and .blf do")


def _kind(path: Path) -> tuple[str, bool]:
    """Which format the suffix names, and whether packed."""
    suffixes = [suffix.lower() for suffix in path.suffixes]
    is_gzip = suffixes[-1:] == [".gz"]
    return "".join((suffixes[:-1] if is_gzip else suffixes)[-1:]), is_gzip


def counts_from_s(path: Path, frames: Sequence[Frame]) -> float:
    """The time that a log with these frames counts from: .asc counts from its first frame."""
    return frames[0].time_s if frames and _kind(path)[0] == ".asc" else 0.0


def write_log(path: Path, frames: Iterable[Frame], buses: Sequence[CanBus] = ()) -> None:
    """Write frames in the format that the suffix names; where that numbers its channels, each bus has its place's.

    InputError where one is of a kind that the format does not have.
    """
    check_log_kind(path, buses)
    suffix, _ = _kind(path)
    first = 1 if suffix == ".mf4" else 0  # python-can itself counts up for the others
    numbers = {} if suffix == ".log" else {bus.name: number for number, bus in enumerate(buses, first)}
    with whole_file(path) as part:
        try:
            writer = python_can.mf4().MF4Writer(part) if suffix == ".mf4" else can.Logger(part)
        except ValueError as error:
            raise InputError(f"{path}: {error}") from error
        with writer:
            for frame in frames:
                if suffix == ".trc":
                    _check_trc_has(path, frame)
                if suffix == ".asc":
                    _check_asc_has(path, frame)
                message = to_message(frame)
                if suffix == ".log" and message.is_error_frame:
                    _keep_error_class(message)
                message.channel = numbers.get(frame.bus, frame.bus)
                writer(message)


def _check_trc_has(path: Path, frame: Frame) -> None:
    """InputError for a frame that python-can's writer of .trc drops, telling only its log."""
    if frame.kind is not FrameKind.DATA:
        kind = f"{frame.kind.name.lower()} frames"
    elif len(frame.data) > CLASSIC_LENGTH:
        kind = "CAN FD frames"
    else:
        return
    raise InputError(f"{path}: .trc is written without {kind}, and there are some; .log and .blf hold them")


def _check_asc_has(path: Path, frame: Frame) -> None:
    """InputError for bus-off: .asc has error frames, and not what they tell."""
    if frame.kind is FrameKind.ERROR and frame.can_id & BUS_OFF:
        raise InputError(f"{path}: .asc is written without bus-off, and there is one; .log and .blf hold it")


def _keep_error_class(message: can.Message) -> None:
    """Put its class into the identifier, as candump does: python-can would write the same for all error frames."""
    message.is_error_frame, message.is_extended_id = False, True
    message.arbitration_id |= _CANDUMP_ERROR_FLAG


def write_truth(path: Path, recording: Recording, zero_s: float = 0.0) -> None:
    """Write the truth, one row per 10 ms, times as in a log that counts from `zero_s`."""
    with whole_file(path) as part, part.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(recording.truth_header())
        for row in recording.truth():
            writer.writerow([f"{row[0] - zero_s:.6f}", *(f"{value:.9g}" for value in row[1:])])


def write_due(path: Path, found: Iterable[Due], zero_s: float) -> None:
    """Write the alarms that are due or may come, one JSON object per line, times as in a log from `zero_s`."""
    with whole_file(path) as part:
        part.write_bytes(b"".join(msgspec.json.encode(due.since(zero_s)) + b"\n" for due in found))
