"""One wheelset's readings: whether it turns, and how it last came to stop.

A wheelset that is stopped while the wagon moves is the gravest thing there is to see, and a wheel-speed sensor that
has died reads the same. How it came to stop tells most of it: brake torque takes some tenths of a second to stop a
wheelset, at most mu_b F r_B / J; a sensor falls from one reading to the next, also with no pad pressing. One that falls
slowly and evenly has mass, whatever its brake says (`Descent`).
"""

from enum import StrEnum
from math import inf

from brake_monitor.estimation.estimate import Estimate
from brake_monitor.monitoring.inputs.descent import ROLLS, STANDS, WHOLE, Descent
from brake_monitor.monitoring.inputs.holding_force import HoldingForce
from brake_monitor.monitoring.inputs.speed_bursts import SpeedBursts
from brake_monitor.monitoring.inputs.turning import WATCHED_FROM_MPS, Turning
from brake_monitor.monitoring.inputs.vehicle_speed import VehicleSpeed
from brake_monitor.monitoring.inputs.wheel_state import WheelState
from brake_monitor.settings.bounds import LARGEST_FRICTION
from brake_monitor.settings.config import Vehicle

TOLD_S = 2.0  # a speed of the vehicle that is older says nothing of a wheelset
TURNS = 0.5  # circumferential over vehicle speed: from here on a wheelset turns beyond doubt
TURNS_AGAIN = 0.2
CUTS_OUT_BELOW_MPS = 3.0  # below WATCHED_FROM_MPS speed sensors cut out, and some sooner
STANDSTILL_MPS = 0.5
FORCE_DOUBT = 1.5  # of the torque that stopped it: calibration of the force, lag, inertia
UNTOLD_N = 30e3  # a brake may press with as much whatever its sensor says
SHORTEST_FALL_S = 0.05  # frames may be bunched, so a fall is not taken for quicker


class Origin(StrEnum):
    """How a wheelset came to stand."""

    UNSEEN = "unseen"  # it stood when the recording began
    STOOD = "stood"  # it has not turned since the wagon stood
    STOPPED = "stopped"  # as a brake stops it, or a bearing that seizes
    DROPPED = "dropped"  # as nothing but a sensor falls


NOT_TURNED = {Origin.UNSEEN, Origin.STOOD}  # of a wheelset that has not been seen to turn since it could


class WatchedWheelset:
    """Sees the raw speeds of one wheelset beside the vehicle's, and what could hold it."""

    def __init__(self, vehicle: Vehicle, i: int, contact_force_n: float, vehicle_speed: VehicleSpeed) -> None:
        self._vehicle_speed = vehicle_speed
        self.radius_m = vehicle.wheel_radius_m[i]
        self._inertia_kgm2 = vehicle.wheelset_inertia_kgm2[i]
        self._stop_radps2_per_n = FORCE_DOUBT * LARGEST_FRICTION * vehicle.brake_radius_m[i] / self._inertia_kgm2
        self.holding = HoldingForce(vehicle, i, contact_force_n)
        self.bursts = SpeedBursts()
        self.descent = Descent()
        self.turning = Turning(self.holding, self.bursts)
        self._hardest_mps2 = self._stop_radps2_per_n * UNTOLD_N * self.radius_m  # by which any brake may slow it down
        self._turned: tuple[float, float] | None = None  # (time, rad/s) of the last reading that turns beyond doubt
        self._fell_s = inf  # when it was read to stand since, while the vehicle's speed was not told
        self._wagon_stood = False
        self.unseen = Origin.UNSEEN  # how it came to stand before this run began, as an earlier one has told
        self.read_s, self.rolling_mps = -inf, 0.0  # the last reading
        self.stands_since_s = inf
        self.origin = Origin.UNSEEN
        self.decided: WheelState | None = None  # of one that stands
        self.may_drag = False  # of one that is not believed to stand: the wagon is retarded as if it did ...
        self.drags_since_s = inf  # ... strongly, and ever since
        self.drops = 0  # how often its sensor has fallen to 0 at speed, since the start

    def see_speed(self, time_s: float, value: float) -> None:
        """Take a good reading, beside the vehicle's speed that was read last."""
        speed_mps = self._vehicle_speed.mps
        if speed_mps is None:
            return
        omega_radps = abs(value)
        self.read_s, self.rolling_mps = time_s, omega_radps * self.radius_m
        rolling_mps = self.rolling_mps
        if time_s < self.stands_since_s < inf:  # the clock was set back
            self.stands_since_s = time_s
        if speed_mps < STANDSTILL_MPS:
            self.stand_on(time_s, rolling_mps)
            return
        whole_s = time_s if rolling_mps >= WHOLE * speed_mps else None
        if time_s - self._vehicle_speed.time_s > TOLD_S:
            self._see_alone(time_s, omega_radps, rolling_mps, whole_s)
            return
        if rolling_mps > ROLLS * speed_mps:
            self.turn_on(time_s, omega_radps, rolling_mps, whole_s)
            return
        self.descent.see(time_s, rolling_mps / speed_mps)
        if rolling_mps > TURNS_AGAIN * speed_mps:
            self.stands_since_s, self.decided = inf, None
        if rolling_mps > TURNS * speed_mps:
            self._turned, self._fell_s, self._wagon_stood = (time_s, omega_radps), inf, False
        elif rolling_mps < STANDS * speed_mps and speed_mps > WATCHED_FROM_MPS and self.stands_since_s == inf:
            self.stands_since_s = time_s
            self.origin = self._how(time_s, omega_radps)
            self.drops += self.origin is Origin.DROPPED and not self.fell_at_a_crawl

    def note(self, now: Estimate) -> None:
        """Remember, at each observation, what has been read last."""
        self.holding.bear(now.mass_kg)
        self.holding.remember(now.time_s)
        if self.read_s > -inf:
            speed_mps = self._vehicle_speed.mps or 0.0
            runs_mps = speed_mps if speed_mps >= STANDSTILL_MPS else 0.0
            hardest_mps2 = self._hardest_mps2 * max(self.holding.largest_n / UNTOLD_N, 1.0)
            self.bursts.see(self.read_s, self.rolling_mps, runs_mps, hardest_mps2)

    def _see_alone(self, time_s: float, omega_radps: float, rolling_mps: float, whole_s: float | None) -> None:
        """Take one beside which nothing is known of the vehicle's speed."""
        if rolling_mps > STANDSTILL_MPS:
            self.turn_on(time_s, omega_radps, rolling_mps, whole_s)
        else:
            self._fell_s = min(self._fell_s, time_s)

    @property
    def fell_at_a_crawl(self) -> bool:
        """Whether it came to stand from a speed at which its sensor may have cut out."""
        if self.stands_since_s == inf:
            return False
        if self._turned is None:
            return self.origin is Origin.STOOD  # as the wagon departs it begins to tell as late
        return self._turned[1] * self.radius_m < CUTS_OUT_BELOW_MPS

    def turns_within_s(self, speed_mps: float) -> float:
        """How long a rail that gives hardly anything, of it half in a slide, takes to turn it once nothing holds it."""
        return 2.0 * self._inertia_kgm2 * TURNS_AGAIN * speed_mps / self.radius_m / self.holding.rail_nm

    def turn_on(self, time_s: float, omega_radps: float, rolling_mps: float, whole_s: float | None) -> None:
        """Take a speed at which it turns beyond doubt, or the last of several, and when one was last `WHOLE`."""
        self.descent.rolls(time_s, whole_s)
        self.read_s, self.rolling_mps = time_s, rolling_mps
        self._turned, self._fell_s = (time_s, omega_radps), inf
        self._wagon_stood, self.stands_since_s, self.decided = False, inf, None

    def stand_on(self, time_s: float, rolling_mps: float) -> None:
        """Take a speed while the wagon stands, or the last of several."""
        self.read_s, self.rolling_mps = time_s, rolling_mps
        self._wagon_stood = True
        if self.decided is None:
            self.stands_since_s = inf

    def _how(self, time_s: float, omega_radps: float) -> Origin:
        if self._wagon_stood:
            return Origin.STOOD
        if self._turned is None:
            return self.unseen
        turned_s, turned_radps = self._turned
        fall_radps2 = (turned_radps - omega_radps) / max(min(self._fell_s, time_s) - turned_s, SHORTEST_FALL_S)
        force_n = self.holding.largest_n
        possible = fall_radps2 <= self._stop_radps2_per_n * force_n and force_n >= self.holding.least_n
        return Origin.STOPPED if possible or self.descent.is_a_wheels() else Origin.DROPPED
