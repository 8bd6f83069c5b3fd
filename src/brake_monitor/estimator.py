"""Samples → Estimate: time, observability and resets around the filter."""

from collections.abc import Iterable, Iterator, Sequence
from math import hypot, inf, isfinite, sqrt
from typing import ClassVar

from msgspec.structs import replace

from brake_monitor.alignment import Alignment
from brake_monitor.brake_filter import SURPRISE_NIS, BrakeFilter
from brake_monitor.brake_work import CRAWLING_MPS, SLIDING_SLIP, WheelsetWork
from brake_monitor.config import EstimatorSettings, Vehicle
from brake_monitor.consistency import Consistency, Doubt
from brake_monitor.ekf import Innovation
from brake_monitor.estimate import SLOWEST_MPS, Estimate, Status, WheelsetEstimate, slip_of
from brake_monitor.friction_pause import onset_variance, pause_variance
from brake_monitor.input_trust import InputTrust
from brake_monitor.known_inputs import LONGEST_STEP_S, KnownInputs
from brake_monitor.learned import Learned
from brake_monitor.load_transfer import LoadTransfer
from brake_monitor.plausibility import FrozenReading, is_possible
from brake_monitor.radius_calibration import RadiusCalibration
from brake_monitor.regime import Flags, Regime
from brake_monitor.samples import ESSENTIAL, MEASURED, Channel, InputCondition, Quality, Quantity, Sample
from brake_monitor.slide_protection import SlideProtections
from brake_monitor.tuning import Tuning, resolve
from brake_monitor.wagon import GRAVITY_MPS2, FrictionRelaxation, Wagon

LATEST_SAMPLE_S = 0.05  # a sample this much older than the filter is still fused, an older one means time jumped
SETTLING_S = 3.0  # from a start or restart to `valid`
UNSETTLED_S = 2.0  # after a slide
SPACING_SHARE = 0.05  # of the newest reading in the mean spacing of a wheelset's
QUICK_SLIP = 0.01  # from here on adhesion may change within hundredths of a second
LOCKED_FRACTION = 0.03  # circumferential over vehicle speed of a wheelset that does not turn
OUTLIER_SIGMA = 6.0
OUTLIERS_BELIEVED = 3  # as many in a row are no outliers but the truth
FASTEST_WHEEL_RADPS2 = 80.0  # brake torque or re-adhesion over inertia; a faster change is a bad reading
FASTEST_WAGON_MPS2 = 3.0  # beyond the model's own prediction
LARGEST_FRICTION = 0.6  # no pad has more: a force that acts is not measured
UNEXPLAINED_SIGMAS = 3.0  # of d as known beforehand; in `wagon` a gradient of 30 per mille
ROLLING_AGAIN_S = 3.0  # after the last contact of any pad, every wheelset has found back to rolling
PAUSE_S = 1.0  # without any contact for longer, the next contact is a new brake application


class Estimator:
    """Feeds samples in time order to the filter and says what is known. No clock: time is the samples'."""

    wagon_type: ClassVar[type[Wagon]] = Wagon  # the model

    def __init__(
        self,
        vehicle: Vehicle,
        settings: EstimatorSettings,
        channels: Iterable[Channel],
        tuning: Tuning | None = None,
    ) -> None:
        """`tuning` takes the place of what the settings say."""
        wagon = self.wagon_type.from_vehicle(vehicle, FrictionRelaxation.from_settings(settings))
        self._tuning = tuning or resolve(settings)
        self._filter = BrakeFilter(wagon, self._tuning, settings.friction_nominal, settings.friction_nominal_std)
        self._layout = wagon.layout
        self._wagon = wagon
        self._brake_radius_m = vehicle.brake_radius_m
        self._channels = {(channel.quantity, channel.wheelset): channel for channel in channels}
        self._alignment = Alignment(self._channels.values())
        self._trust = InputTrust(self._channels)
        self._loads = LoadTransfer(wagon)
        self._known = KnownInputs(wagon, self._channels, settings.contact_force_n)
        wheels = range(self._layout.wheelset_count)
        self._wheels = wheels
        self._omega_variance = [self._channels[Quantity.AXLE_SPEED, i].noise_std ** 2 for i in wheels]
        self._radius = [RadiusCalibration(radius_m) for radius_m in vehicle.wheel_radius_m]
        self._slid_s = [-inf for _ in wheels]  # when each wheelset last slid
        self._work = [WheelsetWork() for _ in wheels]
        self._protections = SlideProtections(len(wheels), one_flag=self._known.one_wsp_signal)
        self._distance_m = 0.0
        self._rejected = [0] * (len(wheels) + 1)  # outliers in a row, per measured state
        self._fused_s = [-inf] * (len(wheels) + 1)  # when each measured state was last fused
        self._spacing_s = [0.0] * (len(wheels) + 1)  # mean time between readings of each
        self._frozen = {place: FrozenReading(channel.noise_std) for place, channel in self._channels.items()}
        self._consistency = Consistency(len(wheels))
        unmodelled_mps2 = hypot(self._tuning.deceleration_std, self._tuning.deceleration_onset_std)
        self._largest_deceleration_mps2 = UNEXPLAINED_SIGMAS * unmodelled_mps2
        self.time_s = -inf
        self.nis = 0.0
        self.reset_count = 0
        self.outlier_count = 0
        self.late_count = 0
        self._started_s = -inf
        self._pressed_s = -inf
        self._resumed: Learned | None = None
        self._regime = self._regime_now()
        self._filter.enter(self._regime)

    # -- samples in --------------------------------------------------------------------------------------------

    def take(self, sample: Sample) -> bool:
        """Take one sample as captured; True when it, or one that waited for it, was fused as a measurement."""
        if sample.quality is Quality.GOOD and not is_possible(sample):
            self._trust.lose((sample.quantity, sample.wheelset), InputCondition.IMPOSSIBLE)
            return False
        fused = False
        for aligned in self._alignment.put(sample):
            fused |= self._take_aligned(aligned)
        return fused

    def _take_aligned(self, sample: Sample) -> bool:
        place = (sample.quantity, sample.wheelset)
        if sample.quality is Quality.STALE:
            self._trust.lose(place, InputCondition.LOST)
            self._lose_known(sample)
        if sample.quality is not Quality.GOOD:
            return False
        if place in self._trust.disbelieved and sample.quantity is not Quantity.PRESSING_FORCE:
            self._trust.gain(place)
            return False
        if sample.quantity not in MEASURED:
            self._take_known(sample)
            self._trust.gain(place)
            return False
        if self._is_frozen(sample):
            if self._trust.lose(place, InputCondition.FROZEN):
                self._distrust()
            return False
        self._trust.gain(place)
        return self._measure(self._layout.speed if sample.quantity is Quantity.SPEED else sample.wheelset, sample)

    def _take_known(self, sample: Sample) -> None:
        told_gradient = self._known.u.gradient
        if self._known.take(sample):
            self._note_force(sample)
        elif (
            sample.quantity is Quantity.GRADIENT
            and self._trust.condition((sample.quantity, sample.wheelset)) is InputCondition.LOST
        ):
            self._hand_over_gradient(told_gradient)

    def _lose_known(self, sample: Sample) -> None:
        told_gradient = self._known.u.gradient
        self._known.lose(sample)
        self._hand_over_gradient(told_gradient)

    def _hand_over_gradient(self, before: float) -> None:
        """The track does not change as its gradient is lost or told again: d takes over, or gives back."""
        if self._tuning.deceleration_std:
            self._filter.x[self._layout.deceleration] += GRAVITY_MPS2 * (before - self._known.u.gradient)

    def _note_force(self, sample: Sample) -> None:
        i = sample.wheelset
        slip = slip_of(self._filter.x[i], self._radius[i].radius_m, self.speed_mps)
        self._consistency.see_force(sample.time_s, i, self._known.pressing_force_n(i), slip)
        if self._trust.is_lost(Quantity.PRESSING_FORCE, i):
            self._known.follow(i)

    def disbelieve(self, places: frozenset[tuple[Quantity, int]]) -> None:
        """From now on use no reading of these: what is known beyond the estimator contradicts them.

        A pressing force is held as it is told, and taken for unknown.
        """
        for quantity, wheelset in places - self._trust.disbelieved:
            if quantity is Quantity.WSP_ACTIVE:
                self._known.let_go_flag(wheelset)
                continue
            self._distrust()
            if quantity is Quantity.AXLE_SPEED:  # it rolls, for all that is known
                rolling_radps = self.speed_mps / self._radius[wheelset].radius_m
                self._filter.forget(wheelset, rolling_radps, SLIDING_SLIP * rolling_radps)
        self._trust.disbelieve(places)

    def _is_frozen(self, sample: Sample) -> bool:
        """Whether a speed repeats itself while the vehicle's, or for the vehicle's that of the wheelsets, moves on."""
        if sample.quantity is Quantity.AXLE_SPEED:
            metres = self._radius[sample.wheelset].radius_m
            reference = self.speed_mps / metres
        else:
            turning = [i for i in self._wheels if self._regime.turning[i]]
            metres, reference = 1.0, max((self._rolling_mps(i) for i in turning), default=0.0)
        repeats = self._frozen[sample.quantity, sample.wheelset].see(sample.time_s, sample.value, reference)
        is_locked = sample.quantity is Quantity.AXLE_SPEED and sample.value == 0.0
        moves = metres * max(reference, abs(sample.value)) > SLOWEST_MPS  # one of them does; both stand at a standstill
        return repeats and moves and not is_locked

    # -- time --------------------------------------------------------------------------------------------------

    def _measure(self, index: int, sample: Sample) -> bool:
        noise_std = self._channels[sample.quantity, sample.wheelset].noise_std
        fixed_variance = self._tuning.speed_variance if index == self._layout.speed else self._tuning.omega_variance
        variance = noise_std**2 if fixed_variance is None else fixed_variance
        value = abs(sample.value)  # a reversing wagon brakes by the same equations
        step_s = sample.time_s - self.time_s
        if not -LATEST_SAMPLE_S <= step_s <= LONGEST_STEP_S:
            self._restart(sample.time_s)
        elif step_s > 0.0:
            self._predict(sample.time_s, step_s)
        elif step_s < 0.0:  # as late as a few milliseconds: carry the reading forward to the filter's time
            self.late_count += 1
            drift = self._wagon.linearise(self._filter.x, self._known.u)[0][index] * -step_s
            value += drift
            variance += drift * drift
        fused = self._fuse(index, value, variance)
        if not self._filter.is_sound():
            self._filter.reset()
            self._restart(sample.time_s)
        return fused

    def _restart(self, time_s: float) -> None:
        """Forget the kinematics, keep what was learned: the next readings are taken as they come."""
        if isfinite(self.time_s):
            self.reset_count += 1
            if time_s < self.time_s:
                self._set_back(self.time_s - time_s)
        elif self._resumed is not None:
            self._recall(self._resumed, time_s - self._resumed.time_s)
        self.time_s = self._started_s = time_s
        self._fused_s = [-inf] * len(self._fused_s)
        self._rejected = [0] * len(self._rejected)
        self._known.restart(time_s)
        self._loads.restart()
        self._filter.forget(self._layout.adhesion, 0.0, self._tuning.adhesion_std)

    def _set_back(self, by_s: float) -> None:
        """The clock was set back: what happened a while ago still happened as long ago."""
        self._slid_s = [slid_s - by_s for slid_s in self._slid_s]
        self._pressed_s -= by_s
        self._consistency.set_back(by_s)

    def _recall(self, learned: Learned, pause_s: float) -> None:
        """Take over what was learned before the program's pause, and doubt what may have changed in it."""
        if pause_s < 0.0:  # a clock that was set back says nothing of how long it was
            pause_s = inf
        s, tuning = self._layout, self._tuning
        variance = max(learned.friction_std) ** 2 + pause_variance(pause_s)
        own_variance = min(tuning.friction_own_std**2, variance)
        self._filter.forget(s.friction, 0.0, 0.0)
        self._filter.x[s.friction] = learned.friction
        self._filter.spread(s.friction, variance - own_variance, own_variance)
        drift = tuning.deceleration * pause_s if tuning.deceleration else 0.0
        std_mps2 = min(sqrt(learned.deceleration_std_mps2**2 + drift), tuning.deceleration_std)
        self._filter.forget(s.deceleration, learned.deceleration_mps2 if std_mps2 else 0.0, std_mps2)

    def _distrust(self) -> None:
        """Start anew, with nothing of what was learned from readings that turned out wrong."""
        self._filter.forget_parameters()
        self._restart(self.time_s)

    def _predict(self, time_s: float, step_s: float) -> None:
        """Carry the estimate to time_s with the mean of the inputs over the step."""
        forces = self._known.advance(time_s, step_s)
        self.time_s = time_s
        self._note_application(time_s)
        self._regime = self._regime_now()
        self._known.take_conditions(self._filter.enter(self._regime), self._loads.wheel_load_n)
        self._filter.predict(step_s, self._known.u, forces)
        self._loads.follow(self._filter.x, self._known.u, step_s)
        self._calibrate_radii(step_s)
        self._add_work(step_s)

    def _add_work(self, step_s: float) -> None:
        """Note what brakes and wheels did in the step that has just been predicted; what crawls may stand."""
        x, u, friction = self._filter.x, self._known.u, self._layout.friction.start
        distance_m = self.speed_mps * step_s if self.speed_mps > CRAWLING_MPS else 0.0
        self._distance_m += distance_m
        slips = self._slip()
        if self._protections.awaits(self.time_s):
            forces_n = [self._known.pressing_force_n(i) for i in self._wheels]
            self._protections.see(self.time_s, self.speed_mps, slips, forces_n, self._known.wsp)
        for i, slip in enumerate(slips):
            if self._rolling_mps(i) > CRAWLING_MPS:
                self._work[i].rub(u.pressing_force_n[i] * self._brake_radius_m[i] * x[i] * step_s, x[friction + i])
            self._work[i].slide(slip, distance_m)

    def _note_application(self, time_s: float) -> None:
        """At the first contact after a pause friction may differ from the last stop's, and the train may pull."""
        if not self._known.any_pressed:
            return
        pause_s = time_s - self._pressed_s
        self._pressed_s = time_s
        if pause_s > PAUSE_S:
            grown = onset_variance(pause_s)
            self._filter.renew_friction(0.8 * grown, 0.2 * grown)
            self._filter.admit_deceleration_jump()

    def _calibrate_radii(self, step_s: float) -> None:
        """A wheelset long without brake and torque rolls: its speed then tells its radius.

        Released by its WSP in a slide it does not roll yet.
        """
        if (
            self.time_s - self._pressed_s < ROLLING_AGAIN_S
            or any(self._known.wsp)
            or self._trust.is_lost(Quantity.SPEED)
        ):
            return
        for i, radius in enumerate(self._radius):
            if self._known.is_free(i) and not self._trust.is_lost(Quantity.AXLE_SPEED, i):
                radius.see_rolling(self.speed_mps, self._filter.x[i], step_s)

    # -- conditions --------------------------------------------------------------------------------------------

    @property
    def speed_mps(self) -> float:
        """The estimated vehicle speed v."""
        return self._filter.x[self._layout.speed]

    @property
    def mass_kg(self) -> float:
        """The configured mass, or what the load signals say."""
        return self._known.u.mass_kg

    def input_condition(self, quantity: Quantity, wheelset: int) -> InputCondition:
        """What is known of a mapped signal; wheelsets from 0."""
        return self._trust.condition((quantity, wheelset))

    def _regime_now(self) -> Regime:
        slow = self.speed_mps < SLOWEST_MPS
        slip = self._slip()
        quick = tuple([abs(s) > QUICK_SLIP for s in slip])
        for i in self._wheels:
            if quick[i]:
                self._slid_s[i] = self.time_s
        turning = tuple([slow or s < 1.0 - LOCKED_FRACTION for s in slip])
        torque_known = tuple([self._knows_torque(i) for i in self._wheels])
        unsettled = tuple([self.time_s - slid_s < UNSETTLED_S for slid_s in self._slid_s])
        return Regime(
            slow=slow,
            braking=self._known.any_pressed,
            observed=tuple(
                [not slow and turning[i] and self._observes_friction(i, torque_known, unsettled) for i in self._wheels]
            ),
            unsettled=unsettled,
            quick=quick,
            turning=turning,
            torque_known=torque_known,
        )

    def _slip(self) -> list[float]:
        """(v - omega r_W) / v per wheelset with the calibrated radii; 0 near standstill."""
        speed_mps = self.speed_mps
        return [slip_of(self._filter.x[i], self._radius[i].radius_m, speed_mps) for i in self._wheels]

    def _rolling_mps(self, i: int) -> float:
        """The wheelset's circumferential speed."""
        return self._filter.x[i] * self._radius[i].radius_m

    def _knows_torque(self, i: int) -> bool:
        """Whether what brakes or drives the wheelset is told."""
        return self._known.torque_is_known(i) and not self._trust.is_lost(Quantity.PRESSING_FORCE, i)

    def _observes_friction(self, i: int, torque_known: Flags, unsettled: Flags) -> bool:
        """mu_b,i shows only while the pad presses and its wheel speed and every force are measured (17).

        A wheelset whose brake torque is unknown may bear any part of what brakes the wagon. So may one whose slide
        protection works faster than its pressing force is told.
        """
        return (
            self._known.is_settled(i, self.time_s)
            and all(torque_known)
            and (not any(unsettled) or self._known.tells_promptly)
            and not self._trust.is_lost(Quantity.AXLE_SPEED, i)
        )

    # -- correction --------------------------------------------------------------------------------------------

    def _fuse(self, index: int, value: float, variance: float) -> bool:
        since_s = self.time_s - self._fused_s[index]
        if isfinite(since_s):
            seen = first = self._filter.innovation(index, value, variance)
            if self._is_outlier(index, seen, since_s):
                self._rejected[index] += 1
                self.outlier_count += 1
                if self._rejected[index] < OUTLIERS_BELIEVED:
                    return False
                self._filter.forget(index, value, sqrt(variance))
            else:
                if index < self._layout.speed and seen.nis > SURPRISE_NIS and since_s > 0.0:
                    self._filter.admit_adhesion_jump(index, seen.residual, since_s, self._known.u)
                    seen = self._filter.innovation(index, value, variance)
                self._filter.fuse(index, seen)
                self.nis = seen.nis
                self._note_spacing(index, since_s)
                if index < self._layout.speed:
                    self._consistency.see_wheel(self.time_s, index, first, self._brake_radps2(index))
                elif self._contradicts(seen):
                    self._distrust()
                    return True
        else:
            self._filter.forget(index, value, sqrt(variance))
        self._rejected[index] = 0
        self._fused_s[index] = self.time_s
        return True

    def _note_spacing(self, index: int, since_s: float) -> None:
        mean_s = self._spacing_s[index] or since_s
        self._spacing_s[index] = mean_s + SPACING_SHARE * (since_s - mean_s)

    def _brake_radps2(self, i: int) -> float:
        """What the brake adds to the wheelset's angular acceleration (6)."""
        friction: float = self._filter.x[self._layout.friction.start + i]
        return -self._wagon.spin_per_impulse(i) * friction * self._known.pressing_force_n(i)

    def _contradicts(self, seen: Innovation) -> bool:
        """Whether speeds and pressing forces no longer fit together."""
        if self._tuning.literal:  # the paper's covariances (20) cannot tell
            return False
        deceleration_mps2 = self._filter.x[self._layout.deceleration]
        self._consistency.see_deceleration(self.time_s, deceleration_mps2, self._largest_deceleration_mps2)
        is_biased = self._consistency.see_speed(self.time_s, seen)
        return is_biased or max(self._filter.x[self._layout.friction]) > LARGEST_FRICTION

    def _is_outlier(self, index: int, seen: Innovation, since_s: float) -> bool:
        """A reading that neither noise nor physics explains; a sliding wheel is explained by physics."""
        fastest = FASTEST_WAGON_MPS2 if index == self._layout.speed else FASTEST_WHEEL_RADPS2
        return abs(seen.residual) > OUTLIER_SIGMA * sqrt(seen.variance) + fastest * since_s

    # -- estimate out ------------------------------------------------------------------------------------------

    def estimate(self, time_s: float) -> Estimate:
        """Say what is known at time_s: that of the last fused sample, or a later one when nothing came since."""
        s, x = self._layout, self._filter.x
        load_share = self.load_share
        adhesion_std = self._adhesion_std(load_share)
        slip = self._slip()
        status, reasons = self._status(adhesion_std)
        return Estimate(
            time_s=time_s,
            speed_mps=self.speed_mps,
            distance_m=self._distance_m,
            adhesion=sum(share * mu for share, mu in zip(load_share, x[s.adhesion], strict=True)),
            adhesion_std=adhesion_std,
            saturated=self._is_saturated(slip),
            deceleration_mps2=x[s.deceleration],
            deceleration_std_mps2=self._filter.std(s.deceleration),
            wheelsets=tuple(self._wheelset_estimate(i, slip[i]) for i in self._wheels),
            mass_kg=self.mass_kg,
            sanding=self._known.sanding,
            latitude_deg=self._known.place_deg.get(Quantity.LATITUDE),
            longitude_deg=self._known.place_deg.get(Quantity.LONGITUDE),
            status=status,
            reasons=reasons,
            nis=self.nis,
            reset_count=self.reset_count,
        )

    def _adhesion_std(self, load_share: Sequence[float]) -> float:
        """Of the wagon's adhesion, the mean of the wheelsets' by the load that they carry."""
        s = self._layout
        block = [row[s.adhesion] for row in self._filter.covariance[s.adhesion]]
        variance = sum(
            one * other * shared
            for one, row in zip(load_share, block, strict=True)
            for other, shared in zip(load_share, row, strict=True)
        )
        return sqrt(max(variance, 0.0))

    def learned(self) -> Learned | None:
        """What a restart should not forget; None before anything was measured."""
        if not isfinite(self.time_s):
            return None
        s, x = self._layout, self._filter.x
        return Learned(
            self.time_s,
            self.wheel_radius_m,
            tuple(x[s.friction]),
            tuple(self._friction_std(i) for i in self._wheels),
            x[s.deceleration],
            self._filter.std(s.deceleration),
        )

    def resume(self, learned: Learned) -> None:
        """Go on, before the first sample, with what an earlier run has learned; InputError when it cannot be."""
        learned.check([radius.configured_m for radius in self._radius])
        for radius, radius_m in zip(self._radius, learned.wheel_radius_m, strict=True):
            radius.radius_m = radius_m
        self._resumed = learned

    @property
    def filter(self) -> BrakeFilter:
        """The filter inside, for a smoother to follow."""
        return self._filter

    @property
    def wheel_radius_m(self) -> tuple[float, ...]:
        """The radii as calibrated so far, N of them."""
        return tuple(radius.radius_m for radius in self._radius)

    @property
    def load_share(self) -> Sequence[float]:
        """F_z,i / (m g) now, N numbers."""
        return [own_n / (self.mass_kg * GRAVITY_MPS2) for own_n in self._loads.wheel_load_n]

    def unseen_friction_variance(self, i: int) -> float:
        """What the friction of wheelset i may have done since its pad left the disc; 0 while it presses."""
        if self._known.is_pressed(i) or not isfinite(self._pressed_s):
            return 0.0
        return pause_variance(max(self.time_s - self._pressed_s, 0.0))

    def _is_saturated(self, slip: list[float]) -> bool:
        if self._regime.slow or self._trust.is_lost(Quantity.SPEED):
            return False
        return any(self._known.wsp) or max(slip) > SLIDING_SLIP

    def _wheelset_estimate(self, i: int, slip: float) -> WheelsetEstimate:
        s = self._layout
        friction_std = self._friction_std(i)
        return WheelsetEstimate(
            omega_radps=self._filter.x[i],
            omega_noise=self._omega_variance[i] * self._spacing_s[i],
            slip=slip,
            friction=self._filter.x[s.friction.start + i],
            friction_std=friction_std,
            friction_status=self._friction_status(i, friction_std),
            adhesion=self._filter.x[s.adhesion.start + i],
            adhesion_std=self._filter.std(s.adhesion.start + i),
            pressing_force_n=self._known.pressing_force_n(i),
            wsp_active=self._known.wsp[i],
            work=replace(self._work[i], wsp_actions=self._protections.acts(i)),
        )

    def _friction_std(self, i: int) -> float:
        return hypot(self._filter.std(self._layout.friction.start + i), sqrt(self.unseen_friction_variance(i)))

    def _friction_status(self, i: int, friction_std: float) -> Status:
        needed = ((Quantity.SPEED, 0), (Quantity.AXLE_SPEED, i), (Quantity.PRESSING_FORCE, i))
        if any(self._trust.is_lost(*place) for place in needed):
            return Status.INVALID
        if not self._regime.observed[i]:
            return Status.HELD
        settling = self.time_s - self._started_s < SETTLING_S
        if settling or friction_std > self._tuning.converged_friction_std or any(self._doubts()):
            return Status.CONVERGING
        return Status.VALID

    def _doubts(self) -> Iterator[Doubt]:
        """What the covariances do not know; those of the paper (20) know nothing anyway."""
        return iter(()) if self._tuning.literal else self._consistency.doubts(self.time_s)

    def _status(self, adhesion_std: float) -> tuple[Status, tuple[str, ...]]:
        if lost := tuple(self._trust.reasons(ESSENTIAL)):
            return Status.INVALID, lost
        if self._regime.slow:
            return Status.HELD, ("standstill",)
        if self.time_s - self._started_s < SETTLING_S:
            return Status.CONVERGING, ("settling",)
        if adhesion_std > self._tuning.converged_adhesion_std:
            return Status.CONVERGING, ("adhesion uncertain",)
        if doubts := tuple(self._doubts()):
            return Status.CONVERGING, doubts
        return Status.VALID, ()
