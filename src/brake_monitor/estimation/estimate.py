"""What is known: the estimate of the wagon at one instant."""

from enum import StrEnum

from msgspec import Struct
from msgspec.structs import replace

from brake_monitor.estimation.brake_work import WheelsetWork
from brake_monitor.samples import Measurand, Quantity

SLOWEST_MPS = 1.0  # below it slip has no meaning, sensors cut out and static friction rules: parameters are held
MOTORS_ERR = 0.1  # relative error of the torque that motors are said to have
MOTOR_ACTS_MPS2 = 0.03  # of the mass on its wheelset; less is noise of the motor's sensor, and shows nowhere
LONGEST_STEP_S = 1.0  # what happened in a longer gap between readings is not known: the filter restarts after it
INTERVAL_SIGMAS = 1.96  # of what is told: half of its 95 % interval
BEGINS = "settling"  # why an estimate that has only begun is not valid yet


class Status(StrEnum):
    """How far an estimate may be trusted."""

    VALID = "valid"
    HELD = "held"  # not observable now; the last value is kept and its uncertainty grows
    CONVERGING = "converging"
    INVALID = "invalid"


class WheelsetEstimate(Struct, frozen=True):
    """What is known of one wheelset and its brake unit at one instant."""

    omega_radps: float
    omega_noise: float  # (rad/s)² s, variance of its readings times their spacing: over T s the mean's is noise / T
    slip: float  # (v - omega r_W) / v, dimensionless; 0 near standstill
    friction: float  # pad-disc friction coefficient mu_b,i
    friction_std: float
    friction_status: Status
    adhesion: float  # the wheelset's own F_x / F_z
    adhesion_std: float
    adhesion_status: Status
    pressing_force_n: float
    renewed_slides: int  # how often it has begun to slide anew while the pressing force stands still
    wsp_active: bool  # its wheel-slide protection says that it acts
    is_protected: bool  # ... and this is what shows of it: it has let the brake go, and again
    work: WheelsetWork
    line_friction_std: float = 0.0  # the part of friction_std that is due to a line that may have changed
    motor_force_n: float | None = 0.0  # with which its motor brakes, at the rail; negative as it drives; None: not told
    relative_load: float = 1.0  # F_z,i over the mean of all wheelsets
    speed_scatters: bool = False  # the readings of its speed do, far beyond their noise


class Estimate(Struct, frozen=True):
    """What is known of the wagon at one instant, after the frame captured then was fused.

    Time runs on though the clock that frames are stamped with is set: `time_s` is what durations are measured by,
    `clock_s` what is told. In `by_the_clock` both are the clock's.
    """

    time_s: float
    speed_mps: float
    distance_m: float  # travelled since the start
    adhesion: float  # utilised wheel-rail adhesion mu_w = F_x / F_z of the wagon
    adhesion_std: float
    saturated: bool  # the wheels were asked for as much as the rail gave: adhesion is the available one
    deceleration_mps2: float  # d, the unmodelled longitudinal deceleration
    deceleration_std_mps2: float
    wheelsets: tuple[WheelsetEstimate, ...]
    mass_kg: float  # the configured one, or what the load signals say
    sanding: bool
    latitude_deg: float | None  # None without position signals
    longitude_deg: float | None
    status: Status
    reasons: tuple[str, ...]  # why the status is not valid, empty otherwise
    nis: float  # normalised innovation squared of the last fused sample
    reset_count: int
    unknown: frozenset[Measurand] = frozenset()  # never told, and flags that are not told now: above 0 or False
    clock_ahead_s: float = 0.0  # of time_s: by how much the clock was set so far
    speed_scatters: bool = False  # the readings of the vehicle's speed do, far beyond their noise

    @property
    def clock_s(self) -> float:
        """What the clock showed."""
        return self.time_s + self.clock_ahead_s

    @property
    def by_the_clock(self) -> "Estimate":
        """The estimate as it is given out: all times are the clock's."""
        return replace(self, time_s=self.clock_s, clock_ahead_s=0.0) if self.clock_ahead_s else self

    @property
    def forces_n(self) -> tuple[float, ...]:
        """The pressing force of each wheelset."""
        return tuple([own.pressing_force_n for own in self.wheelsets])

    @property
    def protection_acts(self) -> bool:
        """Whether any wheel-slide protection says that it acts."""
        return True in [own.wsp_active for own in self.wheelsets]

    @property
    def a_motor_acts(self) -> bool:
        """Whether any motor brakes or drives, or may: then not all that wheelsets do is due to their pads."""
        least_n = self._least_motor_n
        return any(own.motor_force_n is None or abs(own.motor_force_n) >= least_n for own in self.wheelsets)

    @property
    def motors_brake(self) -> list[bool]:
        """For each wheelset whether its motor brakes, or may."""
        least_n = self._least_motor_n
        return [own.motor_force_n is None or own.motor_force_n >= least_n for own in self.wheelsets]

    @property
    def _least_motor_n(self) -> float:
        return MOTOR_ACTS_MPS2 * self.mass_kg / len(self.wheelsets)

    def knows(self, quantity: Quantity, wheelset: int = 0) -> bool:
        """Whether anything is known of what a signal tells; wheelsets from 0."""
        return (quantity, wheelset) not in self.unknown

    def knows_slip(self, wheelset: int) -> bool:
        """Whether both speeds that make the slip of a wheelset are known; wheelsets from 0."""
        return self.knows(Quantity.SPEED) and self.knows(Quantity.AXLE_SPEED, wheelset)


def slip_of(omega_radps: float, wheel_radius_m: float, speed_mps: float) -> float:
    """(v - omega r_W) / v; 0 near standstill."""
    return 0.0 if speed_mps < SLOWEST_MPS else 1.0 - omega_radps * wheel_radius_m / speed_mps
