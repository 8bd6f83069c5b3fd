"""What acts on the wagon and its wheelsets at the moment, and what they do.

`compiled` makes records of these classes: each attribute is a number, a list of numbers, or an object of such.
"""

from math import inf

from brake_monitor.estimation.brake_work import WheelsetWork
from brake_monitor.estimation.doubts.braking_reference import BrakingReference
from brake_monitor.estimation.doubts.consistency import Consistency, WheelChecks
from brake_monitor.estimation.doubts.force_departure import ForceDeparture
from brake_monitor.estimation.doubts.force_gate import ForceGate
from brake_monitor.estimation.doubts.force_trend import ForceTrend
from brake_monitor.estimation.doubts.frozen_reading import FrozenReading
from brake_monitor.estimation.doubts.seizing import Seizing
from brake_monitor.estimation.doubts.spike_watch import SpikeWatch
from brake_monitor.estimation.inputs.held_input import HeldInput
from brake_monitor.estimation.inputs.pad_contact import PadContact
from brake_monitor.estimation.inputs.slide_protection import SlideProtection
from brake_monitor.estimation.model.wheelset import Wheelset, is_on_tread
from brake_monitor.estimation.rolling.line_roughness import LineRoughness
from brake_monitor.estimation.rolling.radius_calibration import RadiusCalibration

SNAPSHOTS = 3  # of x and P, to go back to: a speed that turns out to be frozen has taught nonsense since it froze


class BrakeApplication:
    """The last brake application: what was known as it, or the estimate, began, and what is doubted since."""

    def __init__(self) -> None:
        self.began_s = -inf
        self.pull_variance = 0.0  # (m/s²)², see `BrakeFilter.pull_variance`: what pulled the wagon then may end
        self.lag_s = 0.0  # L then, ...
        self.lag_variance = 0.0  # ... and how well it was known
        self.friction = 0.0  # the pads' mean friction then, ...
        self.friction_variance = inf  # ... and how well it was known
        self.ends_at_once = False  # the last force that was told to press was gone faster than air can move
        self.strays_s = inf  # since when mean friction is off that; inf: it is not
        self.friction_is_doubted = False  # it was widened against d
        self.impossible_s = inf  # since when mean friction is what no pads have; inf: it is not
        self.lately = BrakingReference(lasts_s=2.0)  # what a line does within some tens of metres shows by the one, ...
        self.longer_ago = BrakingReference(lasts_s=8.0)  # ... what discs do that dry by the other
        self.followed = 0.0  # share of friction by which it was widened, as forces may have followed it, not the line
        self.doubted = 0.0  # variance by which such changes have widened friction, in all
        self.back_from = 0.0  # by how much it had strayed, with its sign, before it began to come back; 0: it does not
        self.away_s = -inf  # when it was last that far off
        self.line_friction_std = 0.0  # by how much, once, for a line that may have changed as it began, ...
        self.line_friction_share = 0.0  # ... and which share of its variance that was then
        self.line_mps2 = 0.0  # the part of d that the line can have made, ...
        self.line_m = 0.0  # ... and the distance up to which that was followed


class WagonMoment:
    """The wagon as a whole."""

    def __init__(self, mass_kg: float, deceleration_per_metre: float) -> None:
        """`deceleration_per_metre` as in `Tuning`."""
        self.time_s = -inf  # of the filter
        self.started_s = -inf  # when it was last started or restarted
        self.pressed = False  # any pad touches its disc
        self.pressed_s = -inf  # when any did last
        self.distance_m = 0.0
        self.nis = 0.0  # of the last reading fused
        self.outlier_count = 0
        self.near_standstill = True  # v is below SLOWEST_MPS: parameters are held, speeds are as measured
        self.braked = False  # any pad presses in the step, or did at its beginning
        self.driven = False  # any motor acts in the step, or did at its beginning
        self.all_roll = False  # all wheelsets roll, and have for a while; all torques are known
        self.has_slid = False  # any wheelset has since all rolled: else E, B and C_k have no covariances to others
        self.lag_observable = False  # L is a state, and a brake acts or did lately: else L has no covariances to others
        self.line = LineRoughness(deceleration_per_metre)
        self.force_trend = ForceTrend()
        self.stands_pressed = True  # it stands, or stood, as pads press or did last
        self.coasting_mps2 = 0.0  # d after the last release at speed, when nothing pulls the wagon yet
        self.application = BrakeApplication()
        self.mean_deceleration_mps2 = 0.0  # the mean deceleration of the last L
        self.speed_per_lag_mps2 = 0.0  # by how much a reading of v is more than v, per second of L: its element of H
        self.missed_deceleration_mps2 = 0.0  # by how much the deceleration has changed since what late forces tell of
        self.any_friction_observable = False  # any mu_b,i is
        self.wsp_active = False  # any slide protection is, by its own word
        self.configured_kg = mass_kg
        self.mass_kg = mass_kg
        self.weighed = 0  # load readings in the mean of the mass
        self.gradient = 0.0
        self.deceleration_density = 0.0  # (m/s²)²/s, as in `Tuning`, ...
        self.following_density = 0.0  # ... of which, for brakes that may follow the line
        self.torque_error_density = 0.0  # 1/s, of K
        self.motor_direction = 0.0  # 1 while motors drive, -1 while they brake, 0 where neither was lately
        self.motors_acted_s = -inf  # when any did last
        self.pitching_mps2 = 0.0  # see `Wagon.loads_after_step`
        self.heading = 1.0  # -1 while the wagon reverses, as a speed with a sign has told, ...
        self.heading_told_by = -1  # ... this measured state; -1: none has, so that the wagon is taken to run forwards
        self.speed_lost = True
        self.saved_s = [-inf] * SNAPSHOTS  # when each was, in this brake application or since the last one; -inf: none
        self.newest_snapshot = 0
        self.protections_s = -inf  # when slide protections were looked at last
        self.flagged = -1  # the wheelset that a flag for all of them is about; -1: none
        self.consistency = Consistency()

    def hand_over(self, gradient_mps2: float) -> None:
        """Note that d is so much more, by a gradient that is told no longer: with what it is compared is, too."""
        applied = self.application
        self.coasting_mps2 += gradient_mps2
        applied.line_mps2 += gradient_mps2
        applied.lately.unmodelled_mps2 += gradient_mps2
        applied.longer_ago.unmodelled_mps2 += gradient_mps2
        self.line.forget_look()


class Surprise:
    """What the last wheel speed that surprised found and changed: if it was a spike, that is taken back."""

    def __init__(self) -> None:
        self.adhesion = 0.0  # mu_w,i before it ...
        self.adhesion_variance = 0.0
        self.speed_variance = 0.0  # ... and how well v was known
        self.moved_mps = 0.0  # v by it


class WheelsetMoment:
    """One wheelset: what acts on it in a step, and what it does. Flags that the filter multiplies by are 0.0 or 1.0."""

    def __init__(
        self, own: Wheelset, wheel_load_n: float, contact_force_n: float, omega_variance: float, *, has_motor: bool
    ) -> None:
        """`contact_force_n`: from which on its pads touch; `has_motor`: one whose torque is mapped."""
        self.omega_variance = omega_variance  # (rad/s)², of its readings' noise
        self.inertia_kgm2 = own.inertia_kgm2
        self.configured_brake_radius_m = own.brake_radius_m
        self.on_tread = is_on_tread(own.brake_radius_m, own.wheel_radius_m)
        self.force = HeldInput()
        self.torque = HeldInput()
        self.gate = ForceGate()
        self.contact = PadContact(contact_force_n)
        self.departure = ForceDeparture()
        self.radius = RadiusCalibration(own.wheel_radius_m)
        self.work = WheelsetWork()
        self.checks = WheelChecks()
        self.protection = SlideProtection()
        self.begin_load_n = wheel_load_n  # (4), in the last step: mu_w agrees with it
        self.wheel_load_n = wheel_load_n  # ... in this one
        self.next_wheel_load_n = wheel_load_n  # ... after it
        self.pressing_force_n = 0.0  # mean over the step
        self.wheel_torque_nm = 0.0  # mean over the step
        self.begin_force_n = 0.0  # pressing force at the end of the last step: mu_w agrees with it
        self.end_force_n = 0.0  # ... of this one
        self.begin_torque_nm = 0.0  # torque of the motor at the end of the last step: mu_w agrees with it, too
        self.end_torque_nm = 0.0  # ... of this one
        self.impulse_std_ns = 0.0  # how far ∫F dt over the step may be off
        self.unseen_std_ns = 0.0  # ... and by what slide protection may have done since the last sample
        self.wsp_active = False
        self.motor_torque_known = not has_motor  # it was told and is not lost, or the motor has never acted
        self.motor_has_acted = False
        self.force_lost = True
        self.silent = False  # its force has not come on with the others', but its brake may work all the same
        self.silent_adhesion = 0.0  # ... and may have brought mu_w,i to this since the others came on
        self.seizing = Seizing()  # its torque is not known while it is
        self.torque_known = False  # in this step, that of its brake and of its motor
        self.axle_speed_lost = True
        self.slid_s = -inf  # when its slip was last beyond creep
        self.turns = True  # not locked
        self.has_equation = 0.0  # ... and its torque is known, so that its wheel equation (6) can be used
        self.rolls = 0.0  # its slip is creep: mu_w,i follows the brake torque
        self.slides = 0.0  # its slip is above SLIDING_SLIP: mu_w,i decays with slip speed w
        self.unsettled = 0.0  # it slid lately: which share of a changing torque the rail takes up is in doubt
        self.force_effect_observable = 0.0  # E, by which mu_b,i changes with the force, is: it slid lately
        self.friction_observable = 0.0  # mu_b,i is (17): pressed, turning, measured
        self.locked_s = -inf  # when it was locked last
        self.stuck_lately = 0.0  # its pads are, or were lately: mu_b,i walks, up to STUCK_FRICTION_STD
        self.omega_density = 0.0  # (rad/s)²/s, as in `Tuning`
        self.adhesion_density = 0.0  # 1/s, its own
        # By which weights the C_k count at its slip, if it neither rolls nor is locked.
        self.small_slip = self.medium_slip = self.large_slip = 0.0
        self.slip_mps = 0.0  # slip speed w = v - omega r_W before the step
        self.slip_change_mps = 0.0  # Δw since the step before, times e^{-B w}: see `RegimeWatch.enter_creep`
        self.surprise = Surprise()

    @property
    def wheel_radius_m(self) -> float:
        """r_W as calibrated so far."""
        return self.radius.radius_m

    @property
    def brake_radius_m(self) -> float:
        """r_B: of blocks on the tread it wears with the wheel."""
        if self.on_tread:
            return self.configured_brake_radius_m * (self.radius.radius_m / self.radius.configured_m)
        return self.configured_brake_radius_m


class Readings:
    """What has become of the readings of one measured state."""

    def __init__(self, noise_std: float) -> None:
        self.rejected_in_a_row = 0  # readings
        self.believed_in_a_row = 0  # times that rejections ended with a reading believed against the prediction
        self.fused_s = -inf  # when one was last fused, or set; -inf: none since the start
        self.came_s = -inf  # ... came, fused or not
        self.spacing_s = 0.0  # mean time between readings
        self.frozen = FrozenReading(noise_std)
        self.spikes = SpikeWatch()  # of a wheelset's


class ChannelState:
    """What is known of a mapped signal."""

    def __init__(self, tells: int, wheelset: int, measures: int, variance: float, largest: float) -> None:
        self.tells = tells  # SPEED, PRESSING_FORCE, ... of `core`
        self.wheelset = wheelset
        self.measures = measures  # of a speed: the place in x of the state that it reads (15) ...
        self.variance = variance  # ... and R, the variance of its noise
        self.largest = largest  # absolute value that is possible
        self.lost = True  # it says nothing that may be used
