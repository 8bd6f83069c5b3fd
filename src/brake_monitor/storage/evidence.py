"""What was on the bus around an alarm: frames as a candump log, estimates as a table, and the state they met.

The newest frames and estimates are always at hand. When an alarm is raised what came before is written at once, so
that a power cut leaves that; some seconds later it is written again with what came after.
"""

import os
import re
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain, islice
from math import inf, isfinite
from pathlib import Path

import msgspec
from msgspec import Struct

from brake_monitor.bus.candump_log import line_of
from brake_monitor.estimation.estimate import Estimate
from brake_monitor.frame import Frame
from brake_monitor.host.whole_file import whole_file
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.processing import estimate_table
from brake_monitor.processing.at_hand import AtHand, Span
from brake_monitor.processing.remembered import Remembered
from brake_monitor.settings.store_settings import MOST_EVIDENCE_S, StoreSettings

FRAMES_AT_HAND = 150_000  # some 2 MB; a busy bus then reaches back less far
ESTIMATES_EVERY_S = 0.09  # the table's usual rate, whatever the output rate
ESTIMATES_AT_HAND = round(MOST_EVIDENCE_S / ESTIMATES_EVERY_S)  # some 1 MB
STATES_EVERY_S = 5.0
LINES_IN_PIECE = 256  # as they are written
SUFFIXES = (".log", ".csv", ".json")

_UNFIT = re.compile(r"[^A-Za-z0-9._-]")


class State(Struct, frozen=True):
    """`<id>.json`: the alarm, and what the program remembered where the log begins."""

    alarm: Alarm
    remembered: Remembered


class Evidence(Struct, frozen=True):
    """Everything that is kept of one alarm."""

    state: State
    frames: Span[Frame]
    estimates: Span[Estimate]

    @property
    def name(self) -> str:
        """The alarm's id as it can stand in the name of a file."""
        return _UNFIT.sub("_", self.state.alarm.id).lstrip(".")[:100] or "alarm"


class EvidenceRecorder:
    """Keeps the newest frames at hand. Time is the frames'."""

    def __init__(self, settings: StoreSettings) -> None:
        self._before_s = settings.evidence_before_s
        self._after_s = settings.evidence_after_s
        self._frames = AtHand(Frame, FRAMES_AT_HAND)
        self._estimates = AtHand(Estimate, ESTIMATES_AT_HAND)
        self._estimate_s = -inf  # time of the newest of them
        self._states: deque[tuple[float, Remembered]] = deque()
        self._known: set[str] = set()  # ids of alarms that are open
        self._awaited: list[Alarm] = []  # raised, while what comes after has yet to arrive
        self._now_s = -inf

    def resume(self, remembered: Remembered) -> None:
        """The program goes on from here: the alarms that are open have their evidence."""
        self._known |= {alarm.id for alarm in remembered.open_alarms}
        if not self._states:
            self._states.append((-inf, remembered))

    def see_frames(self, frames: Sequence[Frame]) -> None:
        """Take the frames that arrived."""
        self._frames.add(frames)

    def see_estimate(self, estimate: Estimate) -> None:
        """Take what was estimated."""
        if abs(estimate.time_s - self._estimate_s) >= ESTIMATES_EVERY_S:
            self._estimate_s = estimate.time_s
            self._estimates.add([estimate])

    def see_state(self, time_s: float, remembered: Remembered) -> None:
        """Take what would be remembered now."""
        if not self._states or abs(time_s - self._states[-1][0]) >= STATES_EVERY_S:
            self._states.append((time_s, remembered))

    def turn(self, time_s: float, alarms: Sequence[Alarm]) -> list[Evidence]:
        """Time went on to `time_s`, these alarms changed: the evidence that is to be written (anew)."""
        # An alarm that silence has raised may be newer than frames that were still underway.
        complete = [alarm for alarm in self._awaited if abs(time_s - alarm.raised_time_s) >= self._after_s]
        self._awaited = [alarm for alarm in self._awaited if alarm not in complete]
        evidence = [self._evidence(alarm) for alarm in complete]  # before any of it is forgotten
        # A clock that was set: nothing fits together.
        if isfinite(self._now_s) and abs(time_s - self._now_s) > self._before_s + self._after_s:
            self._forget_all_but(time_s)
        self._now_s = time_s
        self._forget_before(time_s - self._before_s - self._after_s)
        new = {alarm.id: alarm for alarm in alarms if alarm.id not in self._known and alarm.cleared_time_s is None}
        raised = list(new.values())  # an alarm that was raised and changed at once counts once
        for alarm in alarms:
            if alarm.cleared_time_s is None:
                self._known.add(alarm.id)
            else:
                self._known.discard(alarm.id)
        self._awaited += raised
        return [*map(self._evidence, raised), *evidence]

    def finish(self) -> list[Evidence]:
        """The program ends: the incomplete evidence, as far as it goes."""
        awaited, self._awaited = self._awaited, []
        return [self._evidence(alarm) for alarm in awaited]

    def _forget_before(self, time_s: float) -> None:
        """The states, frames and estimates from the last state before `time_s` on remain."""
        while len(self._states) > 1 and self._states[1][0] <= time_s:
            self._states.popleft()
        begin_s = self._states[0][0] if self._states else time_s
        self._frames.forget_before(begin_s)
        self._estimates.forget_before(begin_s)

    def _forget_all_but(self, time_s: float) -> None:
        """Keep what arrived just now; the newest state is that of any time."""
        self._frames.keep_near(time_s, self._before_s)
        self._estimates.keep_near(time_s, self._before_s)
        self._states = deque((-inf, state) for _, state in list(self._states)[-1:])

    def _evidence(self, alarm: Alarm) -> Evidence:
        early_enough = [entry for entry in self._states if entry[0] <= alarm.raised_time_s - self._before_s]
        begin_s, remembered = (early_enough[-1:] or list(self._states)[:1] or [(-inf, Remembered())])[0]
        end_s = alarm.raised_time_s + self._after_s
        return Evidence(
            State(alarm, remembered),
            self._frames.between(begin_s, end_s),
            self._estimates.between(begin_s, end_s),
        )


class EvidenceFolder:
    """Where evidence is kept: three files per alarm, the oldest out first."""

    def __init__(self, folder: Path, max_bytes: int) -> None:
        self._folder = folder
        self._max_bytes = max_bytes

    def write(self, evidence: Evidence) -> None:
        """Write the files whole, once there is room; WorkError or OSError when the disk does not let it."""
        lines = (map(line_of, evidence.frames), _table(evidence.estimates), [_text(evidence.state)])
        content = {suffix: _pieces(text) for suffix, text in zip(SUFFIXES, lines, strict=True)}
        self._folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        self._make_room(sum(map(len, chain(*content.values()))), evidence.name)
        for suffix, pieces in content.items():
            with whole_file(self._folder / f"{evidence.name}{suffix}") as part, part.open("wb") as stream:
                stream.writelines(pieces)
                stream.flush()
                os.fsync(stream.fileno())
        folder = os.open(self._folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
        try:
            os.fsync(folder)  # the names of the files; without it a power cut leaves `.part-…`, if anything
        finally:
            os.close(folder)

    def _make_room(self, needed_bytes: int, name: str) -> None:
        for left in self._folder.glob(".part-*"):  # of a write that a power cut ended
            left.unlink()
        oldest_first = sorted(
            (path for path in self._folder.iterdir() if path.suffix in SUFFIXES and path.stem != name),
            key=lambda path: (path.stat().st_mtime_ns, path.name),
        )
        used = sum(path.stat().st_size for path in oldest_first)
        while oldest_first and used + needed_bytes > self._max_bytes:
            stem = oldest_first[0].stem
            for path in [path for path in oldest_first if path.stem == stem]:
                used -= path.stat().st_size
                path.unlink()
                oldest_first.remove(path)


def _pieces(lines: Iterable[str]) -> list[bytes]:
    """Some lines together: all at once would take four times the memory, and all one by one twice."""
    left = iter(lines)
    return [*iter(lambda: "".join(islice(left, LINES_IN_PIECE)).encode(), b"")]


def _table(estimates: Iterable[Estimate]) -> Iterator[str]:
    for place, estimate in enumerate(estimates):
        if place == 0:
            yield f"{','.join(estimate_table.header(len(estimate.wheelsets)))}\n"
        yield f"{estimate_table.line(estimate)}\n"


def _text(state: State) -> str:
    return msgspec.json.format(msgspec.json.encode(state)).decode() + "\n"
