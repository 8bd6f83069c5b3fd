"""Core → Estimate: what is known at an instant, and how far it may be trusted."""

from collections.abc import Mapping, Sequence
from math import hypot, isfinite, sqrt

from brake_monitor.estimation.brake_filter import BrakeFilter
from brake_monitor.estimation.brake_work import SLIDING_SLIP, WheelsetWork
from brake_monitor.estimation.consistency import Consistency, Doubt
from brake_monitor.estimation.core import Core
from brake_monitor.estimation.estimate import Estimate, Status, WheelsetEstimate
from brake_monitor.estimation.force_departure import ForceDeparture
from brake_monitor.estimation.friction_pause import pause_variance
from brake_monitor.estimation.held_input import HeldInput
from brake_monitor.estimation.input_trust import InputTrust
from brake_monitor.estimation.known_inputs import KnownInputs
from brake_monitor.estimation.learned import Learned
from brake_monitor.estimation.moment import Now, Readings, Wheel
from brake_monitor.estimation.pad_contact import PadContact
from brake_monitor.estimation.radius_calibration import RadiusCalibration
from brake_monitor.estimation.slide_protection import SlideProtections
from brake_monitor.estimation.tuning import Tuning
from brake_monitor.estimation.wagon import GRAVITY_MPS2
from brake_monitor.samples import ESSENTIAL, Quantity

INVALID, HELD, CONVERGING, VALID = Status.INVALID, Status.HELD, Status.CONVERGING, Status.VALID
SETTLING_S = 3.0  # from a start or restart to `valid`

# The numbers of the core that a statement reads: who counts with copies of them brings these back before one.
STATED: Mapping[type, frozenset[str]] = {
    Now: frozenset({"time_s", "started_s", "pressed_s", "distance_m", "nis", "slow", "mass_kg"}),
    Consistency: frozenset({"biased_s", "scattered_s", "out_of_step_s", "still_s", "unexplained_s"}),
    Wheel: frozenset({"next_wheel_load_n", "wsp_active", "observed"}),
    HeldInput: frozenset({"value"}),
    PadContact: frozenset({"pressed"}),
    ForceDeparture: frozenset({"_lately_n", "_learned_n"}),
    RadiusCalibration: frozenset({"radius_m"}),
    WheelsetWork: frozenset({"pad_energy_j", "force_travel_nm", "sliding_distance_m"}),
    Readings: frozenset({"spacing_s"}),
}


class Statement:
    """Says what the numbers of one estimator mean."""

    def __init__(
        self, core: Core, tuning: Tuning, trust: InputTrust, known: KnownInputs, protections: SlideProtections
    ) -> None:
        self._core = core
        self._filter: BrakeFilter = core.filter
        self._layout = self._filter.layout
        self._tuning = tuning
        self._trust = trust
        self._known = known
        self._protections = protections
        self._wheels = range(self._layout.wheelset_count)
        self._first_friction, self._first_adhesion = self._layout.friction.start, self._layout.adhesion.start

    def estimate(self, time_s: float, reset_count: int) -> Estimate:
        """Say what is known at time_s: that of the last fused sample, or a later one when nothing came since."""
        s, x, now = self._layout, self._filter.x, self._core.now
        load_share = self.load_share
        adhesion_std = self._adhesion_std(load_share)
        slip = [self._core.slip(i) for i in self._wheels]
        doubts = self._doubts()
        status, reasons = self._status(adhesion_std, doubts)
        return Estimate(
            time_s=time_s,
            speed_mps=x[s.speed],
            distance_m=now.distance_m,
            adhesion=sum([share * mu for share, mu in zip(load_share, x[s.adhesion], strict=True)]),
            adhesion_std=adhesion_std,
            saturated=self._is_saturated(slip),
            deceleration_mps2=x[s.deceleration],
            deceleration_std_mps2=self._filter.std(s.deceleration),
            wheelsets=tuple([self._wheelset(i, slip[i], doubts) for i in self._wheels]),
            mass_kg=now.mass_kg,
            sanding=self._known.sanding,
            latitude_deg=self._known.place_deg.get(Quantity.LATITUDE),
            longitude_deg=self._known.place_deg.get(Quantity.LONGITUDE),
            status=status,
            reasons=reasons,
            nis=now.nis,
            reset_count=reset_count,
        )

    def learned(self) -> Learned:
        """What a restart should not forget."""
        s, x = self._layout, self._filter.x
        return Learned(
            self._core.now.time_s,
            self.wheel_radius_m,
            tuple(x[s.friction]),
            tuple(self._friction_std(i) for i in self._wheels),
            x[s.deceleration],
            self._filter.std(s.deceleration),
        )

    @property
    def wheel_radius_m(self) -> tuple[float, ...]:
        """The radii as calibrated so far, N of them."""
        return tuple([wheel.radius.radius_m for wheel in self._core.wheels])

    @property
    def load_share(self) -> Sequence[float]:
        """F_z,i / (m g) now, N numbers."""
        weight_n = self._core.now.mass_kg * GRAVITY_MPS2
        return [wheel.next_wheel_load_n / weight_n for wheel in self._core.wheels]

    def unseen_friction_variance(self, i: int) -> float:
        """What the friction of wheelset i may have done unseen: at another force, and since its pad left the disc."""
        now, wheel = self._core.now, self._core.wheels[i]
        friction = self._filter.x[self._first_friction + i]
        variance: float = (wheel.departure.relative_std * friction) ** 2
        if not wheel.contact.pressed and isfinite(now.pressed_s):
            variance += pause_variance(max(now.time_s - now.pressed_s, 0.0))
        return variance

    def _adhesion_std(self, load_share: Sequence[float]) -> float:
        """Of the wagon's adhesion, the mean of the wheelsets' by the load that they carry."""
        s = self._layout
        block = [row[s.adhesion] for row in self._filter.covariance[s.adhesion]]
        variance = sum(
            [
                one * other * shared
                for one, row in zip(load_share, block, strict=True)
                for other, shared in zip(load_share, row, strict=True)
            ]
        )
        return sqrt(max(variance, 0.0))

    def _is_saturated(self, slip: Sequence[float]) -> bool:
        now = self._core.now
        if now.slow or now.speed_lost:
            return False
        return max(slip) > SLIDING_SLIP or any(wheel.wsp_active for wheel in self._core.wheels)

    def _wheelset(self, i: int, slip: float, doubts: tuple[Doubt, ...]) -> WheelsetEstimate:
        x, wheel, adhesion = self._filter.x, self._core.wheels[i], self._first_adhesion + i
        friction_std = self._friction_std(i)
        return WheelsetEstimate(
            omega_radps=x[i],
            omega_noise=wheel.omega_variance * self._core.readings[i].spacing_s,
            slip=slip,
            friction=x[self._first_friction + i],
            friction_std=friction_std,
            friction_status=self._friction_status(i, friction_std, doubts),
            adhesion=x[adhesion],
            adhesion_std=self._filter.std(adhesion),
            pressing_force_n=wheel.force.value,
            wsp_active=wheel.wsp_active,
            work=WheelsetWork(
                wheel.work.pad_energy_j,
                wheel.work.force_travel_nm,
                wheel.work.sliding_distance_m,
                self._protections.acts(i),
            ),
        )

    def _friction_std(self, i: int) -> float:
        return hypot(self._filter.std(self._first_friction + i), sqrt(self.unseen_friction_variance(i)))

    def _friction_status(self, i: int, friction_std: float, doubts: tuple[Doubt, ...]) -> Status:
        wheel = self._core.wheels[i]
        if self._is_lost(wheel):
            return INVALID
        if not wheel.observed:
            return HELD
        if self._is_settling() or friction_std > self._tuning.converged_friction_std or doubts:
            return CONVERGING
        return VALID

    def _is_lost(self, wheel: Wheel) -> bool:
        """Whether anything essential of a wheelset, or of the wagon, says nothing that may be used."""
        return self._core.now.speed_lost or wheel.axle_speed_lost or wheel.force_lost

    def _is_settling(self) -> bool:
        return self._core.now.time_s - self._core.now.started_s < SETTLING_S

    def _doubts(self) -> tuple[Doubt, ...]:
        """What the covariances do not know; those of the paper (20) know nothing anyway."""
        now = self._core.now
        return () if self._tuning.literal else now.consistency.doubts(now.time_s)

    def _status(self, adhesion_std: float, doubts: tuple[Doubt, ...]) -> tuple[Status, tuple[str, ...]]:
        if any(map(self._is_lost, self._core.wheels)) and (lost := tuple(self._trust.reasons(ESSENTIAL))):
            return INVALID, lost
        if self._core.now.slow:
            return HELD, ("standstill",)
        if self._is_settling():
            return CONVERGING, ("settling",)
        if adhesion_std > self._tuning.converged_adhesion_std:
            return CONVERGING, ("adhesion uncertain",)
        if doubts:
            return CONVERGING, doubts
        return VALID, ()
