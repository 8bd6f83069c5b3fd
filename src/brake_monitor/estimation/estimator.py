"""Samples → Estimate. The core takes ordinary samples; here is all else: losses, doubts, clocks and restarts."""

from collections.abc import Iterable, Sequence
from math import inf, isfinite
from typing import ClassVar

from brake_monitor.estimation.brake_work import SLIDING_SLIP
from brake_monitor.estimation.core.core import Core
from brake_monitor.estimation.core.correction import ASIDE, CONTRADICTED, FROZEN, FUSED, NOT_ORDINARY
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
from brake_monitor.estimation.model.friction_pause import COMMON_SHARE, OWN_SHARE, onset_variance
from brake_monitor.estimation.model.tuning import Tuning, resolve
from brake_monitor.estimation.model.wagon import GRAVITY_MPS2, FrictionRelaxation, Wagon
from brake_monitor.estimation.moment import SNAPSHOTS, ChannelState
from brake_monitor.estimation.statement import Statement
from brake_monitor.frame import MOST_LATE_S
from brake_monitor.samples import MEASURED, Channel, InputCondition, Measurand, Quality, Quantity, Sample
from brake_monitor.settings.config import EstimatorSettings, Vehicle

UNKNOWN_SPEED_STD_MPS = 30.0  # after a gap: of any speed of a wagon
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
        self._tuning = tuning or resolve(settings)
        self.channels = tuple(channels)
        has_motors = any(channel.quantity is Quantity.WHEEL_TORQUE for channel in self.channels)
        wagon = self.wagon_type.from_vehicle(
            vehicle, FrictionRelaxation.from_settings(settings), has_motors=has_motors and not self._tuning.literal
        )
        self.filter = self.filter_type(wagon, self._tuning, settings.friction_nominal, settings.friction_nominal_std)
        self._layout = wagon.layout
        self._channel_numbers = {channel.measurand: k for k, channel in enumerate(self.channels)}
        self.alignment = Alignment(self.channels)
        self.waits = self.alignment.waits  # samples wait for those of slower sensors
        self.core = new_core(self.core_type, self.filter, settings, self.channels, foretells=foretells)
        self._now = self.core.now
        self._trust = InputTrust(self.core, self._channel_numbers)
        self._known = KnownInputs(self.core)
        count, one_flag = len(self.core.wheels), self.core.one_wsp_signal
        self._statement = Statement(self._trust, self._known, count, one_flag=one_flag)
        self.changes = 0  # counts what happens to the core here: a compiled copy of it is out of date then
        self.reset_count = 0
        self.late_count = 0
        self.clock_ahead_s = 0.0  # of the samples' time: what the clock that tells the time was set by meanwhile
        self._earlier_run = EarlierRun(self.core, self._tuning)
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
                self._distrust(self.core.readings[self._channel(sample).measures].frozen.since_s)
            return False
        if outcome == CONTRADICTED:
            self._distrust()
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
                self._hand_over_gradient(told_gradient)

    def _lose_known(self, sample: Sample) -> None:
        told_gradient = self._now.gradient
        self._known.lose(sample)
        if sample.quantity is Quantity.GRADIENT:
            self._hand_over_gradient(told_gradient)

    def _hand_over_gradient(self, before: float) -> None:
        """Let d take over a gradient that is lost, or give back one that is told again: the track has not changed."""
        if self._tuning.deceleration_std:
            handed_over_mps2, place = GRAVITY_MPS2 * (before - self._now.gradient), self._layout.deceleration
            for known in (self.filter.x, *self.filter.saved):
                known[place] += handed_over_mps2
            self._now.hand_over(handed_over_mps2)

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
            self._distrust()
            if quantity is Quantity.AXLE_SPEED:  # it rolls, for all that is known
                rolling_radps = self.speed_mps / self.core.wheels[wheelset].radius.radius_m
                self.filter.forget(wheelset, rolling_radps, SLIDING_SLIP * rolling_radps)
        self._forget_snapshots()  # which may have been learned from them, too

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

    def _distrust(self, since_s: float = -inf) -> None:
        """Restart with the parameters of a snapshot from before readings turned wrong, or else with the prior ones."""
        self.filter.forget_parameters()
        known = [(saved_s, place) for place, saved_s in enumerate(self._now.saved_s) if -inf < saved_s <= since_s]
        if known:
            _, newest = max(known)
            self.filter.restore_parameters(newest)
            if not self._now.has_slid:  # as it may have then
                self.core.end_slides()
        self._now.application.line_mps2 = self.filter.x[self._layout.deceleration]
        self._now.consistency.bias.restart()
        self._restart(self._now.time_s)

    def _forget_snapshots(self) -> None:
        """Drop all snapshots: x and P until now are not to be restored."""
        self._now.saved_s = [-inf] * SNAPSHOTS

    # -- time --------------------------------------------------------------------------------------------------

    def _measure(self, sample: Sample) -> int:
        told = self._channel(sample)
        index, variance, value = told.measures, told.variance, abs(sample.value)
        step_s = sample.time_s - self._now.time_s
        if not -MOST_LATE_S <= step_s <= LONGEST_STEP_S:
            self._restart(sample.time_s)
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
            self._begin_application(pause_s)
        self.core.predict(step_s)

    def _begin_application(self, pause_s: float) -> None:
        """Widen what may have changed since the last brake application: friction, d (a train that pulls), L."""
        now, brakes, grown = self._now, self.filter, onset_variance(pause_s)
        self._forget_snapshots()
        brakes.infer_idle_friction(self.idle_brakes)
        brakes.renew_friction(COMMON_SHARE * grown, OWN_SHARE * grown)
        brakes.admit_deceleration_jump()
        now.application.began_s, now.application.pull_variance = now.time_s, brakes.pull_variance(now.coasting_mps2)
        for wheel in self.core.wheels:
            wheel.contact.begin_application()
        if self.core.learns_lag:
            brakes.doubt_lag()
        self.core.note_beginning()

    def _restart(self, time_s: float) -> None:
        """Restart speeds, adhesions and inputs, keep what was learned: the next readings are taken as they come."""
        now = self._now
        if isfinite(now.time_s):
            self.reset_count += 1
            if time_s < now.time_s:
                self._set_back(now.time_s - time_s)
        else:
            self._earlier_run.recall(time_s + self.clock_ahead_s)
        now.time_s = now.started_s = time_s
        for readings in self.core.readings:
            readings.fused_s, readings.rejected_in_a_row = -inf, 0
        self._known.restart(time_s)
        now.pitching_mps2 = 0.0
        now.line.forget_look()
        self.core.note_beginning()
        self.filter.forget_all(self._layout.adhesion, 0.0, self._tuning.adhesion_std)
        if now.speed_lost:  # then wheelsets tell v, whatever it was before
            self.filter.forget(self._layout.speed, self.speed_mps, UNKNOWN_SPEED_STD_MPS)

    def _set_back(self, by_s: float) -> None:
        """Set all times back with the clock: what happened is still as long ago."""
        for wheel in self.core.wheels:
            wheel.slid_s -= by_s
            wheel.locked_s -= by_s
        self._now.pressed_s -= by_s
        self._now.application.began_s -= by_s
        self._now.saved_s = [saved_s - by_s for saved_s in self._now.saved_s]
        self._now.consistency.set_back(by_s)

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
        readout = [0.0] * width(self._layout.wheelset_count)
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
