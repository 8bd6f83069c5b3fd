"""The one path: frame → samples → estimate → alarms. No threads, no clock, no I/O: time is the frames'."""

from bisect import bisect_left
from collections.abc import Iterable, Iterator
from math import isfinite
from typing import Self

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from brake_monitor.decoding.sample_block import SampleBlock
from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.decoding.time_outs import Passage
from brake_monitor.estimation.estimate import Estimate
from brake_monitor.estimation.estimator import Estimator
from brake_monitor.frame import YEAR_S, Frame
from brake_monitor.frame_block import FrameBlock
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.monitoring.brake_units.application_record import ApplicationRecord
from brake_monitor.monitoring.brake_units.brake_book import BrakeBook
from brake_monitor.monitoring.brake_units.gauge import Gauge, after_gauge
from brake_monitor.monitoring.bus_watch import BusWatch
from brake_monitor.monitoring.creep_meter import CreepMeter
from brake_monitor.monitoring.inputs.input_judge import InputJudge
from brake_monitor.monitoring.misled import MisledBy, qualified
from brake_monitor.monitoring.monitor import Monitor
from brake_monitor.monitoring.observation import OBSERVATION_PERIOD_S, Observation
from brake_monitor.monitoring.rules.all_rules import all_rules
from brake_monitor.processing.block_taker import BlockTaker, OneByOne
from brake_monitor.processing.remembered import Remembered
from brake_monitor.processing.stretches import Stretches
from brake_monitor.processing.turns import BLIND_S, Turns
from brake_monitor.samples import Sample
from brake_monitor.settings.config import Settings


class Outputs(Struct, frozen=True):
    """What one step gave out: an estimate when one was due, the alarms that changed, what ended."""

    estimate: Estimate | None = None
    alarms: tuple[Alarm, ...] = ()
    applications: tuple[ApplicationRecord, ...] = ()  # brake applications that have ended


NOTHING = Outputs()
LONGEST_SILENCE_S = 60.0  # the rules see the first minute of a gap; beyond it a recorder was off, or the clock set


class Pipeline:
    """Takes frames in the order they were captured; live, replay, simulation and tests all run this object."""

    def __init__(self, settings: Settings, decoder: SignalDecoder) -> None:
        self.settings = settings
        self.decoder = decoder
        self.estimator = Estimator(settings.vehicle, settings.estimator, decoder.channels)
        self.shadows: list[Estimator] = []  # they take the same samples, and give nothing out
        self.taker: BlockTaker = OneByOne(self.estimator)
        count, contact_force_n = settings.vehicle.wheelset_count, settings.estimator.contact_force_n
        creep = CreepMeter(contact_force_n)
        self.brake_book = BrakeBook(count, settings.wear, contact_force_n, creep, settings.calibration)
        self.monitor = Monitor(all_rules(settings, creep))
        self._bus_watch = BusWatch((bus.name for bus in settings.can), decoder.channels)
        self._input_judge = InputJudge(settings, decoder.channels, creep)
        self.memory_failure = ""  # why the memory cannot be written, told by whoever keeps one
        self.is_told = False  # whether any mapped value has come yet: before, estimates are but guesses
        self._turns = Turns(settings.output.rate_hz)

    @classmethod
    def from_settings(cls, settings: Settings) -> Self:
        """Load the DBC files and put the stages together; InputError when the mapping does not fit them."""
        return cls(settings, SignalDecoder.from_settings(settings))

    def step(self, frame: Frame) -> Outputs:
        """Take the next frame."""
        if ahead_s := self.estimator.clock_ahead_s:
            frame = frame._replace(time_s=frame.time_s - ahead_s)
        return self._step(frame, self.decoder.decode(frame))

    def play(self, block: FrameBlock, samples: SampleBlock | None = None) -> Iterator[Outputs]:
        """Take the next frames of a recording, as `step` takes each; gives what that gave out.

        Between the instants at which something is due, samples are handed on together and other frames passed over.
        `samples` are the block's where another decoder of the same settings gives them, which then counts them.
        """
        if samples is None:
            samples = self.decoder.decode_block(block)
        stretches = Stretches(block, samples, self._turns, waits=self.estimator.waits)
        passage: Passage | None = None
        frame = place = 0  # the next frame with samples, and the place of what follows the one before
        count = len(stretches.places)
        while frame < count:
            end = frame
            if not stretches.abrupt[frame]:
                passage = passage or self.decoder.passage(samples, frame)
                end = passage.quiet_until(frame, stretches.end(frame))
            if end == frame:
                if passage is not None:
                    passage.settle(frame - 1)
                yield from self._play_alone(block, samples, frame, place)
                passage, end = None, frame + 1
            else:
                self._hear(block, place, stretches.places[end - 1] + 1)
                yield self._go_on(self._fuse_together(samples, frame, end), stretches.times_s[end - 1])
            frame, place = end, stretches.places[end - 1] + 1
        if passage is not None:
            passage.settle(frame - 1)
        if stretches.abrupt[frame]:
            yield from self._pass_over(block, place, len(block))
        else:
            self._hear(block, place, len(block))
        self.taker.settle()

    def _play_alone(self, block: FrameBlock, samples: SampleBlock, frame: int, begin: int) -> Iterator[Outputs]:
        """Take one of the frames with samples, and those without from `begin` up to it, as `step` takes each."""
        place = int(samples.frames[frame])
        yield from self._pass_over(block, begin, place)
        (alone,) = block.frames(np.array([place]))
        own = samples.of_frames(frame, frame + 1)
        self.decoder.note(own)
        yield self._step(alone, own)

    def _pass_over(self, block: FrameBlock, begin: int, end: int) -> Iterator[Outputs]:
        """Take frames without samples, which are counted already; a step is due where time alone says so."""
        while begin < end:
            passed_s = block.time_s[begin:end] - self._turns.taken_s
            due = np.flatnonzero((passed_s < 0.0) | (passed_s >= OBSERVATION_PERIOD_S))
            stop = begin + int(due[0]) if len(due) else end
            self._hear(block, begin, stop)
            if stop < end:
                (frame,) = block.frames(np.array([stop]))
                yield self._step(frame, [])
            begin = stop + 1

    def _hear(self, block: FrameBlock, begin: int, end: int) -> None:
        """Let the bus watch take frames of any kind."""
        errors = block.errors
        for place in errors[bisect_left(errors, begin) : bisect_left(errors, end)] if errors else ():
            if begin < place:
                self._bus_watch.pass_over(block, begin, place)
            self._bus_watch.see(block.odd[place])
            begin = place + 1
        if begin < end:
            self._bus_watch.pass_over(block, begin, end)

    def _step(self, frame: Frame, samples: list[Sample]) -> Outputs:
        time_s = frame.time_s
        passed_s = time_s - self._turns.taken_s
        if not samples and 0.0 <= passed_s < OBSERVATION_PERIOD_S:
            self._bus_watch.see(frame)
            return NOTHING
        missed = self._bridge(time_s) if passed_s > BLIND_S and self._turns.have_begun else NOTHING
        self._bus_watch.see(frame)
        outputs = self._take(samples, time_s)
        if missed is NOTHING:
            return outputs
        return Outputs(outputs.estimate, missed.alarms + outputs.alarms, missed.applications + outputs.applications)

    def advance(self, time_s: float) -> Outputs:
        """Nothing arrived until time_s: inputs may have become stale."""
        return self._take([], time_s - self.estimator.clock_ahead_s)

    @property
    def due_s(self) -> float:
        """Before which time of capture no frame makes anything due: an estimate to give out, or rules to judge."""
        return self._turns.due_s + self.estimator.clock_ahead_s

    @property
    def newest_reading_s(self) -> float | None:
        """When the newest reading was captured that the estimate contains; None before the first."""
        return self._turns.fused_s + self.estimator.clock_ahead_s if isfinite(self.estimator.time_s) else None

    def clock_set(self, by_s: float) -> None:
        """The clock that stamps frames was set ahead by so much, or back: what seems to be a gap is none.

        Inside, time runs on. What comes after, by the new time, is brought to it; what is told is told by the clock.
        """
        self.estimator.clock_ahead_s += by_s

    def bus_down(self, name: str, is_down: bool) -> None:
        """Note that the interface of a bus, by its configured name, went down or works again."""
        self._bus_watch.down(name, is_down)

    def acknowledge(self, alarm_id: str, time_s: float) -> Outputs:
        """A person has seen an open alarm; nothing when none has this id, or it was seen before."""
        alarm = self.monitor.acknowledge(alarm_id, time_s)
        return NOTHING if alarm is None else Outputs(None, (alarm,))

    def remembered(self) -> Remembered:
        """The state that a restart should not forget."""
        brakes = self.brake_book.kept
        known = None if brakes.time_s is None else brakes
        learned = self.estimator.learned()
        if learned is not None:
            learned = replace(learned, calibration=self.settings.calibration)
        return Remembered(learned, known, self.monitor.open_alarms())

    def resume(self, remembered: Remembered) -> None:
        """Go on with the state of an earlier run; InputError, and nothing changed, when none can be like that."""
        if (learned := remembered.learned) is not None:
            if learned.calibration not in (None, self.settings.calibration):
                estimator = self.settings.estimator
                learned = learned.with_friction(estimator.friction_nominal, estimator.friction_nominal_std)
            self.estimator.resume(learned)
        if remembered.brakes is not None:
            self.brake_book.resume(remembered.brakes)
        self._input_judge.resume(remembered.open_alarms)
        self.monitor.resume(remembered.open_alarms)

    def apply(self, gauge: Gauge) -> None:
        """Take up what a person measured; InputError, and nothing changed, when it cannot be."""
        self.brake_book.brakes = after_gauge(self.brake_book.brakes, gauge, self.settings.wear)

    def _bridge(self, time_s: float) -> Outputs:
        """Let the rules see the silence before a frame, as they do when a daemon tells of it meanwhile."""
        alarms: list[Alarm] = []
        applications: list[ApplicationRecord] = []
        from_s = self._turns.taken_s
        if time_s - from_s > YEAR_S:
            return NOTHING
        for k in range(1, int(min(time_s - from_s, LONGEST_SILENCE_S) / OBSERVATION_PERIOD_S)):
            outputs = self._take([], from_s + k * OBSERVATION_PERIOD_S, gives_estimate=False)
            alarms += outputs.alarms
            applications += outputs.applications
        return Outputs(None, tuple(alarms), tuple(applications))

    def _take(self, samples: list[Sample], time_s: float, *, gives_estimate: bool = True) -> Outputs:
        lapsed = self.decoder.expire(time_s)
        self.is_told |= bool(samples)
        fused_s = self._fuse(lapsed + samples if lapsed else samples)
        return self._go_on(fused_s, time_s, gives_estimate=gives_estimate)

    def _fuse(self, samples: Iterable[Sample]) -> float | None:
        """Hand samples on; returns the time of the last one that was fused, None when none was."""
        self.taker.settle()
        fused_s = None
        see, take, shadows = self._input_judge.see, self.estimator.take, self.shadows
        for sample in samples:
            see(sample)
            if take(sample):
                fused_s = sample.time_s
            for shadow in shadows:
                shadow.take(sample)
        return fused_s

    def _fuse_together(self, samples: SampleBlock, begin: int, end: int) -> float | None:
        """Hand on the samples of successive frames, given by their numbers; returns as `_fuse`, of the last frame."""
        first, last = samples.places(begin, end)
        self.is_told = True
        self._input_judge.see_together(samples, first, last)
        for shadow in self.shadows:
            for place in range(first, last):
                shadow.take(samples.sample(place))
        fused = self.taker.take(samples, first, last)
        if fused is None:
            return None
        fused_s = float(samples.time_s[fused])
        if fused >= samples.places(end - 1, end)[0]:
            return fused_s
        self._turns.fused_s = fused_s
        return None

    def _go_on(self, fused_s: float | None, time_s: float, *, gives_estimate: bool = True) -> Outputs:
        """Let time go on and give out what is due; `fused_s` as `_fuse` gives it, of the samples of `time_s`."""
        turns, is_fused = self._turns, fused_s is not None
        turns.go_on(time_s, fused_s)
        is_blind = turns.is_blind
        if not (is_fused or is_blind):
            return NOTHING
        time_s = turns.come_to(time_s)
        is_wanted = gives_estimate and turns.give(is_fused)
        is_looked_at = turns.look()
        if not (is_wanted or is_looked_at):
            return NOTHING
        until_s = None
        if is_blind:
            until_s = self.estimator.catch_up(time_s)
            for shadow in self.shadows:
                shadow.catch_up(time_s)
        estimate = self.taker.estimate(until_s)
        observed = self._observe(estimate, time_s) if is_looked_at else NOTHING
        if not is_wanted:
            return observed
        given = qualified(estimate, self.monitor.misled_by | self._input_judge.misled_by)
        return Outputs(given.by_the_clock, observed.alarms, observed.applications)

    def _observe(self, estimate: Estimate, time_s: float) -> Outputs:
        """Judge the inputs, keep the books of the brake units, show the rules all of it; what changed and ended."""
        estimator = self.estimator
        inputs, wheels = self._input_judge.judge(estimate, estimator.input_condition, estimator.input_changes)
        a_brake_drags = MisledBy.DRAG in self.monitor.misled_by
        applications = self.brake_book.see(estimate, inputs, a_brake_drags=a_brake_drags)
        seen = Observation(
            estimate,
            inputs,
            wheels=wheels,
            buses=self._bus_watch.reports(time_s),
            brakes=self.brake_book.brakes,
            memory_failure=self.memory_failure,
            misled_by=self._input_judge.misled_by,
        )
        disbelieved, idle = inputs.disbelieved, self._input_judge.idle_brakes
        if disbelieved != estimator.disbelieved or idle != estimator.idle_brakes:
            self.taker.settle()
            for each in (estimator, *self.shadows):
                each.disbelieve(disbelieved)
                each.know_idle(idle)
        return Outputs(None, self.monitor.see(seen), applications)
