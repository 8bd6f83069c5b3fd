"""Samples → Estimate: time, observability and resets around the filter."""

from collections.abc import Iterable
from enum import StrEnum
from math import sqrt

import numpy as np
from msgspec import Struct

from brake_monitor import ekf
from brake_monitor.alignment import Alignment
from brake_monitor.config import EstimatorSettings, Vehicle
from brake_monitor.held_input import HeldInput
from brake_monitor.pad_contact import PadContact
from brake_monitor.samples import Channel, Quality, Quantity, Sample
from brake_monitor.tuning import PRESETS
from brake_monitor.wagon import GRAVITY_MPS2, Array, Wagon

SLOWEST_MPS = 1.0  # below it slip has no meaning, sensors cut out and static friction rules: parameters are held
LONGEST_STEP_S = 1.0  # a longer gap between measurements says nothing of what happened in it
LATEST_SAMPLE_S = 0.05  # a sample this much older than the filter is still fused, an older one means time jumped
SETTLING_S = 3.0  # from a start or restart to `valid`
SLIDING_SLIP = 0.05  # WSP acts from here on (EN 15595 controllers: 5-25 %)
QUICK_SLIP = 0.02  # from here on adhesion may change within hundredths of a second
LOCKED_FRACTION = 0.03  # circumferential over vehicle speed of a wheelset that does not turn
SURPRISE_NIS = 9.0  # beyond three sigma the adhesion is taken to have jumped
OUTLIER_SIGMA = 6.0
OUTLIERS_BELIEVED = 3  # as many in a row are no outliers but the truth
FASTEST_WHEEL_RADPS2 = 80.0  # brake torque or re-adhesion over inertia; a faster change is a bad reading
FASTEST_WAGON_MPS2 = 3.0  # beyond the model's own prediction
UNKNOWN_TORQUE_DENSITY = 40.0  # (rad/s)²/s while the pressing force is not known
PAUSE_S = 2.0  # without any contact for longer, the next contact is a new brake application
FRICTION_PAUSE_STD = 0.02  # how far friction moves between two stops (cooling, wet discs), at most
FRICTION_PAUSE_TIME_S = 120.0
FRICTION_RANGE = (0.02, 1.0)
ADHESION_LIMIT = 0.8


class Status(StrEnum):
    """How far an estimate may be trusted."""

    VALID = "valid"
    HELD = "held"  # not observable now; the last value is kept and its uncertainty grows
    CONVERGING = "converging"
    INVALID = "invalid"


class WheelsetEstimate(Struct, frozen=True):
    """What is known of one wheelset and its brake unit at one instant."""

    omega_radps: float
    slip: float  # (v - omega r_W) / v, dimensionless; 0 near standstill
    friction: float  # pad-disc friction coefficient mu_b,i
    friction_std: float
    friction_status: Status
    adhesion: float  # the wheelset's own F_x / F_z
    adhesion_std: float
    pressing_force_n: float
    wsp_active: bool


class Estimate(Struct, frozen=True):
    """What is known of the wagon at one instant, after the frame captured then was fused."""

    time_s: float
    speed_mps: float
    adhesion: float  # utilised wheel-rail adhesion mu_w = F_x / F_z of the wagon
    adhesion_std: float
    saturated: bool  # the wheels were asked for as much as the rail gave: adhesion is the available one
    deceleration_mps2: float  # d, the unmodelled longitudinal deceleration
    deceleration_std_mps2: float
    wheelsets: tuple[WheelsetEstimate, ...]
    status: Status
    reasons: tuple[str, ...]  # why the status is not valid, empty otherwise
    nis: float  # normalised innovation squared of the last fused sample
    reset_count: int


class Estimator:
    """Feeds samples in time order to the filter and says what is known. No clock: time is the samples'."""

    def __init__(self, vehicle: Vehicle, settings: EstimatorSettings, channels: Iterable[Channel]) -> None:
        self._wagon = Wagon.from_vehicle(vehicle)
        self._layout = self._wagon.layout
        self._settings = settings
        self._tuning = PRESETS[settings.preset]
        self._channels = {(channel.quantity, channel.wheelset): channel for channel in channels}
        self._alignment = Alignment(self._channels.values())
        self._lost = set(self._channels)  # not seen yet, or stale
        n = self._layout.wheelset_count
        self._inputs = self._wagon.inputs()
        self._force = [HeldInput() for _ in range(n)]
        self._torque = [HeldInput() for _ in range(n)]
        self._contact = [PadContact(settings.contact_force_n) for _ in range(n)]
        self._wsp = np.zeros(n, dtype=np.bool_)
        self._followed_n = np.zeros(n)  # pressing forces that mu_w has followed so far
        self._load_n: dict[int, float] = {}
        self._rejected = np.zeros(n + 1, dtype=np.int64)  # outliers in a row, per measured state
        self._fused_s = np.full(n + 1, -np.inf)  # when each measured state was last fused
        self.time_s = -np.inf
        self.nis = 0.0
        self.reset_count = 0
        self.outlier_count = 0
        self.late_count = 0
        self._started_s = -np.inf
        self._pressed_s = -np.inf
        self._x = np.zeros(self._layout.size)
        self._covariance = np.zeros((self._layout.size, self._layout.size))
        self._reset_parameters()

    # -- samples in ---------------------------------------------------------------------------------------------

    def take(self, sample: Sample) -> bool:
        """Take one sample as captured; True when it, or one that waited for it, was fused as a measurement."""
        fused = False
        for aligned in self._alignment.put(sample):
            fused |= self._take_aligned(aligned)
        return fused

    def _take_aligned(self, sample: Sample) -> bool:
        place = (sample.quantity, sample.wheelset)
        if sample.quality is Quality.STALE:
            self._lost.add(place)
        if sample.quality is not Quality.GOOD:
            return False
        self._lost.discard(place)
        match sample.quantity:
            case Quantity.SPEED:
                return self._measure(self._layout.speed, sample, self._tuning.speed_variance)
            case Quantity.AXLE_SPEED:
                return self._measure(sample.wheelset, sample, self._tuning.omega_variance)
            case _:
                self._take_input(sample)
                return False

    def _take_input(self, sample: Sample) -> None:
        """Known inputs act from their own time on; they need no prediction."""
        i, value = sample.wheelset, sample.value
        match sample.quantity:
            case Quantity.PRESSING_FORCE:
                self._force[i].sample(sample.time_s, value, LONGEST_STEP_S)
                self._contact[i].see(sample.time_s, value)
            case Quantity.WHEEL_TORQUE:
                self._torque[i].sample(sample.time_s, value, LONGEST_STEP_S)
            case Quantity.WSP_ACTIVE:
                shared = (Quantity.WSP_ACTIVE, 1) not in self._channels
                self._wsp[slice(None) if shared else i] = value != 0.0
            case Quantity.GRADIENT:
                self._inputs.gradient = value
            case Quantity.LOAD_FORCE:
                self._load_n[i] = value
                if len(self._load_n) == sum(q is Quantity.LOAD_FORCE for q, _ in self._channels):
                    self._inputs.mass_kg = sum(self._load_n.values()) / GRAVITY_MPS2

    # -- time ---------------------------------------------------------------------------------------------------

    def _measure(self, index: int, sample: Sample, fixed_variance: float | None) -> bool:
        noise_std = self._channels[sample.quantity, sample.wheelset].noise_std
        variance = noise_std**2 if fixed_variance is None else fixed_variance
        value = abs(sample.value)  # a reversing wagon brakes by the same equations
        step_s = sample.time_s - self.time_s
        if not -LATEST_SAMPLE_S <= step_s <= LONGEST_STEP_S:
            self._restart(sample.time_s)
        elif step_s > 0.0:
            self._predict(sample.time_s, step_s)
        elif step_s < 0.0:  # as late as a few milliseconds: carry the reading forward to the filter's time
            self.late_count += 1
            drift = float(self._wagon.derivative(self._x, self._inputs)[index]) * -step_s
            value += drift
            variance += drift * drift
        fused = self._fuse(index, value, variance)
        if not ekf.is_sound(self._x, self._covariance):
            self._reset_parameters()
            self._restart(sample.time_s)
        return fused

    def _restart(self, time_s: float) -> None:
        """Forget the kinematics, keep what was learned: the next readings are taken as they come."""
        if np.isfinite(self.time_s):
            self.reset_count += 1
        self.time_s = self._started_s = time_s
        self._fused_s[:] = -np.inf
        self._rejected[:] = 0
        for held in (*self._force, *self._torque):
            held.restart(time_s)
        self._forget(self._layout.adhesion, 0.0, self._tuning.adhesion_std)

    def _reset_parameters(self) -> None:
        """Start from what is known before any frame: nominal friction, no adhesion in use, nothing unmodelled."""
        s, p, tuning = self._layout, self._covariance, self._tuning
        self._x[:] = 0.0
        p[:] = 0.0
        self._x[s.friction] = self._settings.friction_nominal
        self._spread(s.friction, self._settings.friction_nominal_std**2, tuning.friction_own_std**2)
        self._spread(s.adhesion, 0.0, tuning.adhesion_std**2)
        p[s.deceleration, s.deceleration] = tuning.deceleration_std**2

    def _spread(self, block: slice, common: float, own: float) -> None:
        """Add variance that the wheelsets share and variance that each has for itself."""
        self._covariance[block, block] += common + own * np.eye(self._layout.wheelset_count)

    def _forget(self, place: int | slice, value: float, std: float) -> None:
        """Give states a new value that is unrelated to everything else."""
        self._x[place] = value
        self._covariance[place, :] = 0.0
        self._covariance[:, place] = 0.0
        indices = np.arange(self._layout.size)[place]
        self._covariance[indices, indices] = std**2

    # -- prediction ---------------------------------------------------------------------------------------------

    def _predict(self, time_s: float, step_s: float) -> None:
        """Carry the estimate to time_s with the mean of the inputs over the step."""
        u = self._inputs
        for i, (force, torque) in enumerate(zip(self._force, self._torque, strict=True)):
            u.pressing_force_n[i] = force.mean_until(time_s, step_s)
            u.wheel_torque_nm[i] = torque.mean_until(time_s, step_s)
        self.time_s = time_s
        self._note_application(time_s)
        if self._is_slow():
            self._covariance[self._kinematic, self._kinematic] += np.eye(self._kinematic.stop) * step_s
            return
        u.turning = self._x[self._layout.omega] * self._wagon.wheel_radius_m > LOCKED_FRACTION * self.speed_mps
        derivative = self._wagon.derivative(self._x, u)
        jacobian = self._wagon.jacobian(self._x, u)
        self._x += derivative * step_s
        follow = self._follow_brake_torque()
        self._x += follow @ self._x
        density = self._density()
        noise = density * step_s if self._tuning.literal else ekf.process_noise(jacobian, density, step_s)
        ekf.predict(self._covariance, np.eye(self._layout.size) + jacobian * step_s + follow, noise)

    def _follow_brake_torque(self) -> Array:
        """While a wheelset rolls, the adhesion it uses follows its brake torque; shape (n, n), to be added to F.

        Without this, a brake application looks like a random walk of mu_w to the filter: it lags, and puts the
        difference into mu_b. A sliding wheelset turns a change of brake torque into rotation instead.
        """
        s, wagon = self._layout, self._wagon
        now_n = np.array([force.value for force in self._force])
        change_n = now_n - self._followed_n
        self._followed_n = now_n
        follow = np.zeros((s.size, s.size))
        if self._tuning.literal:
            return follow
        rolls = ~self._is_quick() & self._inputs.turning
        load_n = self._inputs.mass_kg * GRAVITY_MPS2 * wagon.static_load_share
        follow[s.adhesion, s.friction] = np.diag(
            np.where(rolls, wagon.brake_radius_m * change_n / (wagon.wheel_radius_m * load_n), 0.0)
        )
        return follow

    @property
    def _kinematic(self) -> slice:
        """The measured states: omega and v."""
        return slice(0, self._layout.speed + 1)

    def _density(self) -> Array:
        """Q, shape (n, n), for the regime the wagon is in."""
        s, tuning, n = self._layout, self._tuning, self._layout.wheelset_count
        density = np.zeros((s.size, s.size))
        wheels = np.arange(n)
        omega = np.where(self._inputs.turning, tuning.omega, UNKNOWN_TORQUE_DENSITY)
        omega[[self._is_lost(Quantity.PRESSING_FORCE, i) for i in range(n)]] = UNKNOWN_TORQUE_DENSITY
        density[wheels, wheels] = omega
        density[s.speed, s.speed] = tuning.speed
        observed = np.array([self._observes_friction(i) for i in range(n)])
        density[s.friction, s.friction] = np.outer(observed, observed) * (
            tuning.friction + tuning.friction_own * np.eye(n)
        )
        own = np.where(self._is_quick(), tuning.adhesion_sliding, tuning.adhesion_own)
        density[s.adhesion, s.adhesion] = tuning.adhesion + np.diag(own)
        braking = any(contact.pressed for contact in self._contact)
        density[s.deceleration, s.deceleration] = tuning.deceleration_braking if braking else tuning.deceleration
        return density

    def _note_application(self, time_s: float) -> None:
        """At the first contact after a pause the friction may differ from that of the last stop."""
        if not any(contact.pressed for contact in self._contact):
            return
        pause_s = time_s - self._pressed_s
        self._pressed_s = time_s
        if PAUSE_S < pause_s < np.inf:
            grown = self._pause_variance(pause_s)
            self._spread(self._layout.friction, 0.8 * grown, 0.2 * grown)

    @staticmethod
    def _pause_variance(pause_s: float) -> float:
        """Friction relaxes towards an unknown resting value as the discs cool."""
        return FRICTION_PAUSE_STD**2 * (1.0 - float(np.exp(-pause_s / FRICTION_PAUSE_TIME_S)))

    # -- conditions ---------------------------------------------------------------------------------------------

    @property
    def speed_mps(self) -> float:
        """The estimated vehicle speed v."""
        return float(self._x[self._layout.speed])

    @property
    def mass_kg(self) -> float:
        """The configured mass, or what the load signals say."""
        return self._inputs.mass_kg

    def _is_lost(self, quantity: Quantity, wheelset: int = 0) -> bool:
        return (quantity, wheelset) in self._lost

    def _is_slow(self) -> bool:
        return self.speed_mps < SLOWEST_MPS

    def _slip(self) -> Array:
        """(v - omega r_W) / v per wheelset, shape (N,); 0 near standstill."""
        if self._is_slow():
            return np.zeros(self._layout.wheelset_count)
        return 1.0 - self._x[self._layout.omega] * self._wagon.wheel_radius_m / self.speed_mps

    def _is_quick(self) -> np.ndarray:
        """Wheelsets whose adhesion may change at once, shape (N,)."""
        return self._wsp | (np.abs(self._slip()) > QUICK_SLIP)

    def _observes_friction(self, i: int) -> bool:
        """mu_b,i shows only while the pad presses, the wheel turns and both are measured (17)."""
        return (
            self._contact[i].is_settled(self.time_s)
            and bool(self._inputs.turning[i])
            and not self._is_slow()
            and not self._is_lost(Quantity.PRESSING_FORCE, i)
            and not self._is_lost(Quantity.AXLE_SPEED, i)
        )

    def _held(self) -> np.ndarray:
        """States that no innovation may touch now, shape (n,)."""
        s = self._layout
        held = np.zeros(s.size, dtype=np.bool_)
        if self._is_slow():
            held[s.speed + 1 :] = True
        else:
            held[s.friction] = [not self._observes_friction(i) for i in range(s.wheelset_count)]
        return held

    # -- correction ---------------------------------------------------------------------------------------------

    def _fuse(self, index: int, value: float, variance: float) -> bool:
        since_s = self.time_s - self._fused_s[index]
        if not np.isfinite(since_s):
            self._accept_anew(index, value, variance)
            return True
        seen = ekf.innovation(self._x, self._covariance, index, value, variance)
        if self._is_outlier(index, seen, since_s):
            self._rejected[index] += 1
            self.outlier_count += 1
            if self._rejected[index] < OUTLIERS_BELIEVED:
                return False
            self._accept_anew(index, value, variance)
            return True
        if index < self._layout.speed and seen.nis > SURPRISE_NIS and since_s > 0.0:
            self._admit_adhesion_jump(index, seen.residual, since_s)
            seen = ekf.innovation(self._x, self._covariance, index, value, variance)
        ekf.update(self._x, self._covariance, index, seen, self._held())
        self._keep_physical()
        self._rejected[index] = 0
        self._fused_s[index] = self.time_s
        self.nis = seen.nis
        return True

    def _accept_anew(self, index: int, value: float, variance: float) -> None:
        self._forget(index, value, sqrt(variance))
        self._rejected[index] = 0
        self._fused_s[index] = self.time_s

    def _is_outlier(self, index: int, seen: ekf.Innovation, since_s: float) -> bool:
        """A reading that neither noise nor physics explains; a sliding wheel is explained by physics."""
        fastest = FASTEST_WAGON_MPS2 if index == self._layout.speed else FASTEST_WHEEL_RADPS2
        reach = OUTLIER_SIGMA * sqrt(seen.variance) + fastest * since_s
        return abs(seen.residual) > reach

    def _admit_adhesion_jump(self, wheelset: int, residual: float, since_s: float) -> None:
        """Widen the adhesion of a wheelset whose speed surprises, as if it had jumped since its last reading."""
        s = self._layout
        place = s.adhesion.start + wheelset
        per_adhesion = self._wagon.jacobian(self._x, self._inputs)[wheelset, place] * since_s
        if per_adhesion <= 0.0:
            return
        direction = np.zeros(s.size)
        direction[wheelset] = per_adhesion
        direction[place] = 1.0
        self._covariance += (residual / per_adhesion) ** 2 * np.outer(direction, direction)

    def _keep_physical(self) -> None:
        s = self._layout
        np.clip(self._x[s.friction], *FRICTION_RANGE, out=self._x[s.friction])
        np.clip(self._x[s.adhesion], -ADHESION_LIMIT, ADHESION_LIMIT, out=self._x[s.adhesion])
        np.maximum(self._x[self._kinematic], 0.0, out=self._x[self._kinematic])

    # -- estimate out -------------------------------------------------------------------------------------------

    def estimate(self, time_s: float) -> Estimate:
        """Say what is known at time_s: that of the last fused sample, or a later one when nothing came since."""
        s = self._layout
        load_share = self._wagon.wheel_load_n(
            self._wagon.acceleration_mps2(self._x, self._inputs), self._inputs.mass_kg
        ) / (self._inputs.mass_kg * GRAVITY_MPS2)
        adhesion_variance = load_share @ self._covariance[s.adhesion, s.adhesion] @ load_share
        adhesion_std = sqrt(max(float(adhesion_variance), 0.0))
        slip = self._slip()
        wheelsets = tuple(self._wheelset_estimate(i, float(slip[i])) for i in range(s.wheelset_count))
        status, reasons = self._status(adhesion_std)
        variance = float(self._covariance[s.deceleration, s.deceleration])
        return Estimate(
            time_s=time_s,
            speed_mps=self.speed_mps,
            adhesion=float(load_share @ self._x[s.adhesion]),
            adhesion_std=adhesion_std,
            saturated=self._is_saturated(slip),
            deceleration_mps2=float(self._x[s.deceleration]),
            deceleration_std_mps2=sqrt(max(variance, 0.0)),
            wheelsets=wheelsets,
            status=status,
            reasons=reasons,
            nis=self.nis,
            reset_count=self.reset_count,
        )

    def _is_saturated(self, slip: Array) -> bool:
        if self._is_slow() or self._is_lost(Quantity.SPEED):
            return False
        return bool(self._wsp.any() or (slip > SLIDING_SLIP).any())

    def _wheelset_estimate(self, i: int, slip: float) -> WheelsetEstimate:
        s, p = self._layout, self._covariance
        friction, adhesion = s.friction.start + i, s.adhesion.start + i
        variance = float(p[friction, friction])
        if not self._contact[i].pressed and np.isfinite(self._pressed_s):
            variance += self._pause_variance(max(self.time_s - self._pressed_s, 0.0))
        friction_std = sqrt(max(variance, 0.0))
        return WheelsetEstimate(
            omega_radps=float(self._x[i]),
            slip=slip,
            friction=float(self._x[friction]),
            friction_std=friction_std,
            friction_status=self._friction_status(i, friction_std),
            adhesion=float(self._x[adhesion]),
            adhesion_std=sqrt(max(float(p[adhesion, adhesion]), 0.0)),
            pressing_force_n=self._force[i].value,
            wsp_active=bool(self._wsp[i]),
        )

    def _friction_status(self, i: int, friction_std: float) -> Status:
        needed = (
            (Quantity.SPEED, 0),
            (Quantity.AXLE_SPEED, i),
            (Quantity.PRESSING_FORCE, i),
        )
        if any(place in self._lost for place in needed):
            return Status.INVALID
        if not self._observes_friction(i):
            return Status.HELD
        return Status.CONVERGING if friction_std > self._tuning.converged_friction_std else Status.VALID

    def _status(self, adhesion_std: float) -> tuple[Status, tuple[str, ...]]:
        essential = (Quantity.SPEED, Quantity.AXLE_SPEED, Quantity.PRESSING_FORCE)
        lost = sorted((q, i) for q, i in self._lost if q in essential)
        if lost:
            return Status.INVALID, tuple(f"{quantity} {i + 1} lost" for quantity, i in lost)
        if self._is_slow():
            return Status.HELD, ("standstill",)
        if self.time_s - self._started_s < SETTLING_S:
            return Status.CONVERGING, ("settling",)
        if adhesion_std > self._tuning.converged_adhesion_std:
            return Status.CONVERGING, ("adhesion uncertain",)
        return Status.VALID, ()
