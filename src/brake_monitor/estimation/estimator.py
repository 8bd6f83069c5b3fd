"""Samples → Estimate. The core takes ordinary samples; here is all else: losses, doubts, clocks and restarts."""

from collections.abc import Iterable, Sequence
from math import isfinite
from typing import ClassVar

from brake_monitor.estimation.brake_work import SLIDING_SLIP
from brake_monitor.estimation.core.core import Core
from brake_monitor.estimation.core.correction import ASIDE, CONTRADICTED, FROZEN, FUSED, NOT_ORDINARY, TAKEN
from brake_monitor.estimation.core.new_core import new_core
from brake_monitor.estimation.core.readout import read_out, width
from brake_monitor.estimation.doubts.plausibility import is_possible
from brake_monitor.estimation.earlier_run import EarlierRun
from brake_monitor.estimation.estimate import LONGEST_STEP_S, Estimate
from brake_monitor.estimation.filter.brake_filter import BrakeFilter
from brake_monitor.estimation.input_trust import InputTrust
from brake_monitor.estimation.inputs.alignment import Alignment
from brake_monitor.estimation.known_inputs import KnownInputs
from brake_monitor.estimation.learned import Learned
from brake_monitor.estimation.model.tuning import Tuning, resolve
from brake_monitor.estimation.model.wagon import FrictionRelaxation, Wagon
from brake_monitor.estimation.moment import ChannelState
from brake_monitor.estimation.statement import Statement
from brake_monitor.estimation.turning_points import TurningPoints
from brake_monitor.frame import MOST_LATE_S
from brake_monitor.samples import MEASURED, Channel, InputCondition, Measurand, Quality, Quantity, Sample
from brake_monitor.settings.config import EstimatorSettings, Vehicle

GOOD = Quality.GOOD  # an enumeration's member takes long to look up


class Estimator:
    """Feeds samples in time order to the filter and says what is known. No clock: time is the samples'."""

    wagon_type: ClassVar[type[Wagon]] = Wagon  # the model
    filter_type: ClassVar[type[BrakeFilter]] = BrakeFilter
    core_type: ClassVar[type[Core]] = Core

    def __init__(
        self,
        vehicle: Vehicle,
        settings: EstimatorSettings,
        channels: Iterable[Channel],
        tuning: Tuning | None = None,
        *,
        foretells: bool = False,
    ) -> None:
        """`tuning` takes the place of the settings' own; `foretells`: add up how probable readings are."""
        self.vehicle = vehicle
        self.settings = settings
        tuning = tuning or resolve(settings)
        self.channels = tuple(channels)
        has_motors = any(channel.quantity is Quantity.WHEEL_TORQUE for channel in self.channels)
        wagon = self.wagon_type.from_vehicle(
            vehicle, FrictionRelaxation.from_settings(settings), has_motors=has_motors and not tuning.literal
        )
        self.filter = self.filter_type(wagon, tuning, settings.friction_nominal, settings.friction_nominal_std)
        self._channel_numbers = {channel.measurand: k for k, channel in enumerate(self.channels)}
        self.alignment = Alignment(self.channels)
        self.waits = self.alignment.waits  # samples wait for those of slower sensors
        self.core = new_core(self.core_type, self.filter, settings, self.channels, foretells=foretells)
        self._now = self.core.now
        self._trust = InputTrust(self.core, self._channel_numbers)
        self._known = KnownInputs(self.core)
        self._statement = Statement(self._trust, self._known, self.core)
        self.changes = 0  # counts what happens to the core here: a compiled copy of it is out of date then
        self.late_count = 0
        self.clock_ahead_s = 0.0  # of the samples' time: what the clock that tells the time was set by meanwhile
        self._earlier_run = EarlierRun(self.core)
        self._turning = TurningPoints(self.core)
        self.idle_brakes: frozenset[int] = frozenset()  # by wheelset, see `know_idle`
        self.core.enter_regime()

    # -- samples in --------------------------------------------------------------------------------------------

    def take(self, sample: Sample) -> bool:
        """Take one sample as captured; True when it, or one that waited for it, was fused as a measurement."""
        self.changes += 1
        time_s, quantity, wheelset, value, quality = sample
        if self.waits:
            return self._take_in_order(sample)
        if quality is not GOOD:
            return self._take_with_care(sample)
        outcome = self.core.take(self._channel_numbers[quantity, wheelset], time_s, value)
        return outcome == FUSED if outcome <= FUSED else self.conclude(outcome, sample)

    def take_aside(self, sample: Sample) -> None:
        """Take a good sample that tells the filter nothing."""
        self._known.take(self._channel_numbers[sample.measurand], sample)

    def conclude(self, outcome: int, sample: Sample) -> bool:
        """Do what the core has left to be done, by its outcome for a sample; whether a measurement was fused."""
        if outcome <= FUSED:
            return outcome == FUSED
        if outcome == ASIDE:
            self.take_aside(sample)
            return False
        self.changes += 1
        if outcome == NOT_ORDINARY:
            return self._take_with_care(sample)
        if outcome == FROZEN:
            if self._trust.note(sample.measurand, InputCondition.FROZEN) and sample.quantity in MEASURED:
                self._turning.distrust(self.core.readings[self._channel(sample).measures].frozen.since_s)
            return False
        if outcome == CONTRADICTED:
            self._turning.distrust()
        if not self.filter.is_sound():
            self.filter.reset()
            self._restart(sample.time_s)
        return True

    def catch_up(self, time_s: float) -> float:
        """Take samples that wait for others, as none have arrived for a while; returns until when all are taken."""
        for aligned in self.alignment.ready(time_s):
            self.changes += 1
            self._take_with_care(aligned)
        return self.alignment.whole_until_s(time_s)

    def _take_in_order(self, sample: Sample) -> bool:
        fused = False
        if sample.quality is GOOD and not is_possible(sample):
            self._take_with_care(sample)
            ready = self.alignment.ready(sample.time_s)
        else:
            ready = self.alignment.put(sample)
        for aligned in ready:
            fused |= self._take_with_care(aligned)
        return fused

    def _take_with_care(self, sample: Sample) -> bool:
        measurand = sample.measurand
        if sample.quality is Quality.STALE:
            self._trust.note(measurand, InputCondition.LOST)
            self._lose_known(sample)
        if sample.quality is not GOOD:
            return False
        if not is_possible(sample):
            self._trust.note(measurand, InputCondition.IMPOSSIBLE)
            if isfinite(sample.time_s):
                self._lose_known(sample)
            return False
        if measurand in self._trust.disbelieved and sample.quantity is not Quantity.PRESSING_FORCE:
            self._trust.note(measurand, InputCondition.GOOD)
            return False
        if sample.quantity not in MEASURED:
            self._take_known(sample)
            self._trust.note(measurand, self._known.condition(sample))
            return False
        if self.core.see_repeats(self._channel(sample).measures, sample.time_s, sample.value):
            return self.conclude(FROZEN, sample)
        self._trust.note(measurand, InputCondition.GOOD)
        return self.conclude(self._measure(sample), sample)

    def _channel(self, sample: Sample) -> ChannelState:
        """The core's state of the signal that the sample is from."""
        return self.core.channels[self._channel_numbers[sample.measurand]]

    def _take_known(self, sample: Sample) -> None:
        told_gradient = self._now.gradient
        measurand = sample.measurand
        if self._known.take(self._channel_numbers[measurand], sample):
            self.core.note_force(sample.wheelset, sample.time_s)
            if self._trust.is_lost(*measurand):
                self._known.follow(sample.wheelset)
        elif sample.quantity is Quantity.GRADIENT and self._trust.is_lost(*measurand):
            is_first = self._trust.condition(measurand) is InputCondition.AWAITED
            if not (is_first and self._now.near_standstill):  # else d has learned nothing of that gradient
                self._turning.hand_over_gradient(told_gradient)

    def _lose_known(self, sample: Sample) -> None:
        told_gradient = self._now.gradient
        self._known.lose(sample)
        if sample.quantity is Quantity.GRADIENT:
            self._turning.hand_over_gradient(told_gradient)

    # -- trust -------------------------------------------------------------------------------------------------

    @property
    def disbelieved(self) -> frozenset[Measurand]:
        """The measurands of which no reading is used, by `disbelieve`."""
        return self._trust.disbelieved

    def disbelieve(self, measurands: frozenset[Measurand]) -> None:
        """From now on use no reading of these measurands: what is known beyond the estimator contradicts them.

        A pressing force is held as it is told, and taken for unknown.
        """
        if measurands == self._trust.disbelieved:
            return
        self.changes += 1
        new = measurands - self._trust.disbelieved
        self._trust.disbelieve(measurands)
        for quantity, wheelset in new:
            if quantity is Quantity.WSP_ACTIVE:
                self.core.set_flag(wheelset, False)
                continue
            self._turning.distrust()
            if quantity is Quantity.AXLE_SPEED:  # it rolls, for all that is known
                rolling_radps = self.speed_mps / self.core.wheels[wheelset].radius.radius_m
                self.filter.forget(wheelset, rolling_radps, SLIDING_SLIP * rolling_radps)
        self._turning.forget_snapshots()  # which may have been learned from them, too

    def know_idle(self, wheelsets: frozenset[int]) -> None:
        """From now on take these brakes to do nothing, as their forces say: that is known beyond the estimator.

        Any other brake that does not come on with the rest may work, until it has shown that it does not.
        """
        if wheelsets == self.idle_brakes:
            return
        self.changes += 1
        self.idle_brakes = wheelsets
        for i, wheel in enumerate(self.core.wheels):
            wheel.contact.is_idle = i in wheelsets

    # -- time --------------------------------------------------------------------------------------------------

    def _measure(self, sample: Sample) -> int:
        told = self._channel(sample)
        index, variance, value = told.measures, told.variance, abs(sample.value)
        step_s = sample.time_s - self._now.time_s
        if not -MOST_LATE_S <= step_s <= LONGEST_STEP_S:
            self._restart(sample.time_s)
        elif self.core.awaits_tooth(index, sample.time_s, value):
            return TAKEN
        elif step_s > 0.0:
            self._predict(sample.time_s, step_s)
        elif step_s < 0.0:  # not later than MOST_LATE_S: carry the reading forward to the filter's time
            self.late_count += 1
            drift = self.filter.rate(self._now, self.core.wheels, index) * -step_s
            value += drift
            variance += drift * drift
        self.core.see_heading(index, sample.value)
        return self.core.fuse(index, value, variance)

    def _predict(self, time_s: float, step_s: float) -> None:
        begins, pause_s = self.core.begins_application(time_s), time_s - self._now.pressed_s
        self.core.take_inputs(time_s, step_s)
        if begins:
            self._turning.begin_application(pause_s, self.idle_brakes)
        self.core.predict(step_s)

    def _restart(self, time_s: float) -> None:
        """Begin at this time, with what an earlier run has learned if it is the first; or begin anew."""
        if not isfinite(self._now.time_s):
            self._earlier_run.recall(time_s + self.clock_ahead_s)
        self._turning.restart(time_s)

    def resume(self, learned: Learned) -> None:
        """Go on with what an earlier run has learned; InputError where that is impossible.

        It may come late, from a disk that failed at the start. Once a brake was applied, this run knows better.
        """
        self.changes += 1
        self._earlier_run.take(learned)
        if isfinite(self._now.time_s) and not isfinite(self._now.pressed_s):
            self._earlier_run.recall(self._now.time_s + self.clock_ahead_s)

    # -- what is known -----------------------------------------------------------------------------------------

    def estimate(self, time_s: float | None = None) -> Estimate:
        """Say what is known at time_s, when nothing came since; None: as of the last fused sample."""
        readout = [0.0] * width(self.core.wheelset_count)
        read_out(self.core, readout)
        return self.state(readout, time_s)

    def state(self, readout: Sequence[float], time_s: float | None = None) -> Estimate:
        """Say what the readout of this estimator's core means, see `estimate`."""
        return self._statement.estimate(readout, time_s, self.reset_count, self.clock_ahead_s)

    def learned(self) -> Learned | None:
        """What a restart should not forget; None before anything was measured."""
        if not isfinite(self.time_s):
            return None
        return self._earlier_run.handed_on(self.estimate())

    @property
    def time_s(self) -> float:
        """The filter's time: that of the last measurement fused."""
        return self._now.time_s

    @property
    def speed_mps(self) -> float:
        """The estimated vehicle speed v."""
        return self.core.speed_mps()

    @property
    def reset_count(self) -> int:
        """How often all but what was learned has begun anew, so far."""
        return self._turning.reset_count

    @property
    def outlier_count(self) -> int:
        """Readings that neither noise nor physics explained, so far."""
        return self._now.outlier_count

    def input_condition(self, measurand: Measurand) -> InputCondition:
        """The condition of a mapped signal."""
        return self._trust.condition(measurand)

    @property
    def input_changes(self) -> int:
        """How often the condition of any signal has changed so far."""
        return self._trust.changes

    @property
    def wheel_radius_m(self) -> tuple[float, ...]:
        """The radii as calibrated so far, N of them."""
        return tuple([wheel.radius.radius_m for wheel in self.core.wheels])
