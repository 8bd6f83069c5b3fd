"""A wheel speed without what its pole wheel adds once a revolution."""

from math import cos, inf, pi, sin

import numpy as np

from brake_monitor.decoding.run_out import RunOut
from brake_monitor.frame import MOST_LATE_S

LEAST_RADPS = 4.0  # 6 km/h: below, many sensors cut out, and the angle is lost
LONGEST_GAP_S = 0.5  # what a wheelset does meanwhile leaves the angle known
JUMP_RADPS = 20.0  # from reading to reading: a spike, or a sensor that was away
MOST_TURN_RAD = 2.5  # from reading to reading, on average: with less than two and a half a turn they tell of no turn
READINGS = 24  # ... and ...
TURNED_RAD = 6.0 * pi  # ... so far: long enough for a look, and short enough for a ratio that is not known yet
LONGEST_LOOK_S = 6.0
STANDS_STILL = 3  # repetitions in a row; two come by chance where noise is no more than some steps of the sensor
REST_S = 10.0  # where there is none


class PoleWheel:
    """Sees the readings of one wheel speed, in order. Where no run-out is sure they stay what they are."""

    def __init__(self, noise_std_radps: float) -> None:
        self.run_out = RunOut()
        self._noise_std_radps = noise_std_radps
        self._time_s, self._speed_radps, self._angle_rad = -inf, 0.0, 0.0
        self._true_radps = 0.0  # what was made of it ...
        self._repeated = 0  # ... and how often it was told again
        self._knows_angle = False
        self._usual_step_s = inf  # between readings
        self._rests_until_s = -inf
        self._times_s: list[float] = []
        self._speeds_radps: list[float] = []
        self._angles_rad: list[float] = []

    def true(self, time_s: float, speed_radps: float) -> float:
        """The speed that a reading tells of. One that repeats itself stays as it was: so a sensor that froze shows."""
        step_s = time_s - self._time_s
        if -MOST_LATE_S <= step_s <= 0.0:  # a frame that came late, or once more
            return self._without_run_out(self._angle_rad + speed_radps * step_s, speed_radps)
        before_radps, self._time_s, self._speed_radps = self._speed_radps, time_s, speed_radps
        goes_on = 0.0 < step_s <= LONGEST_GAP_S and abs(speed_radps - before_radps) <= JUMP_RADPS
        if goes_on and abs(speed_radps) >= LEAST_RADPS:
            self._turn_on(0.5 * (before_radps + speed_radps) * step_s * (1.0 + self.run_out.ratio))
        elif self._knows_angle:
            self._lose_angle()
        self._repeated = self._repeated + 1 if speed_radps == before_radps else 0
        if self._repeated < STANDS_STILL:
            self._true_radps = self._without_run_out(self._angle_rad, speed_radps)
        return self._true_radps

    def _turn_on(self, by_rad: float) -> None:
        """Go on by the newest reading."""
        self._knows_angle = True
        self._angle_rad += by_rad
        if self._time_s >= self._rests_until_s:
            self._times_s.append(self._time_s)
            self._speeds_radps.append(self._speed_radps)
            self._angles_rad.append(self._angle_rad)
            if len(self._times_s) >= READINGS:
                self._look()

    def _without_run_out(self, angle_rad: float, speed_radps: float) -> float:
        run_out = self.run_out
        if not run_out.is_sure or abs(speed_radps) * self._usual_step_s > MOST_TURN_RAD:
            return speed_radps
        return speed_radps / (1.0 + run_out.cos_share * cos(angle_rad) + run_out.sin_share * sin(angle_rad))

    def _look(self) -> None:
        """Look for a run-out, where the readings have turned far enough."""
        span_s, turned_rad = self._times_s[-1] - self._times_s[0], abs(self._angles_rad[-1] - self._angles_rad[0])
        if turned_rad < TURNED_RAD and span_s <= LONGEST_LOOK_S:
            return
        steps = len(self._times_s) - 1
        self._usual_step_s = span_s / steps
        if turned_rad >= TURNED_RAD and turned_rad <= MOST_TURN_RAD * steps:
            times_s, speeds_radps, angles_rad = map(np.array, (self._times_s, self._speeds_radps, self._angles_rad))
            self.run_out.look(times_s, speeds_radps, angles_rad, self._noise_std_radps)
            self._rests_until_s = self._time_s + REST_S if self.run_out.is_none else -inf
        self._forget_readings()

    def _lose_angle(self) -> None:
        self._knows_angle, self._angle_rad, self._rests_until_s = False, 0.0, -inf
        self.run_out.lose_angle()
        self._forget_readings()

    def _forget_readings(self) -> None:
        for values in (self._times_s, self._speeds_radps, self._angles_rad):
            values.clear()
