"""By how much a pole wheel runs out: an extended Kalman filter of what a wheel speed does once a revolution.

    told = omega (1 + a cos(theta) + b sin(theta)),    theta the angle that the pole wheel has turned by

A pole wheel that is mounted e beside the axle's centre tells a speed that is too high and too low by turns, by e over
the radius on which its teeth are read: some tenths of a millimetre are 0.1 to 0.3 %.
"""

from math import hypot, sqrt

import numpy as np

from brake_monitor.arrays import Floats

SHARE_STD = 2e-3  # of a and b, before anything is known
RATIO_STD = 0.012  # of turns: a speed that is told as the tread's contains the wheel radius that its sender believes in
LARGEST_RATIO = 0.04
LARGEST_SHARE = 0.02  # more is no run-out

# What may change, per root of a second.
SHARE_WALK = 1e-5
PHASE_WALK_RAD = 0.1  # a sensor that lags tells by an angle later that depends on the speed
RATIO_WALK = 3e-4

SURE_SIGMAS = 4.0  # it is ...
STILL_SURE_SIGMAS = 2.0  # ... and stays so while nothing new is learned, as in a slide
NONE_SHARE = 3e-4  # 0.03 km/h at 100 km/h: less than most noise
UNKNOWNS = 5  # of a look


class RunOut:
    """The state (a, b, rho): rho is by how much more the pole wheel turns than the speed that is told says."""

    def __init__(self) -> None:
        self._state: Floats = np.zeros(3)
        self._covariance: Floats = np.diag([SHARE_STD**2, SHARE_STD**2, RATIO_STD**2])
        self._looked_at: tuple[float, float] | None = None  # time and angle of the last look
        self.cos_share = self.sin_share = self.ratio = 0.0
        self.is_sure = self.is_none = False

    @property
    def share(self) -> float:
        """The greatest relative error of a speed."""
        return hypot(self.cos_share, self.sin_share)

    def lose_angle(self) -> None:
        """Forget how the pole wheel stood; how its turns compare with those that are told stays known."""
        self._looked_at, self.is_sure, self.is_none = None, False, False
        self._state[:2] = self._covariance[:2, 2] = self._covariance[2, :2] = 0.0
        self._covariance[:2, :2] = np.diag([SHARE_STD**2, SHARE_STD**2])
        self.cos_share = self.sin_share = 0.0

    def look(self, time_s: Floats, speed_radps: Floats, angle_rad: Floats, noise_std_radps: float) -> None:
        """Take readings of some revolutions, each shape (K,), with the angles by then as integrated with `ratio`."""
        shares, shares_covariance = _of_stretch(time_s, speed_radps, angle_rad, noise_std_radps)
        now_s, angle = float(time_s.mean()), float(angle_rad.mean())
        before_s, before = self._looked_at or (now_s, angle)
        self._looked_at = now_s, angle
        self._predict(now_s - before_s, angle - before)
        self._correct(shares, shares_covariance)

    def _predict(self, step_s: float, turned_rad: float) -> None:
        """A ratio that is wrong turns (a, b) by its error times the angle."""
        cos_share, sin_share, _ = self._state
        across = np.array([sin_share, -cos_share, 0.0])  # by an angle of 1, to first order
        transition = np.eye(3)
        transition[:, 2] += turned_rad * across
        walk = np.diag([SHARE_WALK**2, SHARE_WALK**2, RATIO_WALK**2]) + PHASE_WALK_RAD**2 * np.outer(across, across)
        self._covariance = transition @ self._covariance @ transition.T + step_s * walk

    def _correct(self, shares: Floats, shares_covariance: Floats) -> None:
        """By Joseph's form, which keeps the covariance one."""
        gain = self._covariance[:, :2] @ np.linalg.inv(self._covariance[:2, :2] + shares_covariance)
        self._state = self._state + gain @ (shares - self._state[:2])
        rest = np.eye(3)
        rest[:, :2] -= gain
        self._covariance = rest @ self._covariance @ rest.T + gain @ shares_covariance @ gain.T
        self._state[2] = min(max(self._state[2], -LARGEST_RATIO), LARGEST_RATIO)
        self.cos_share, self.sin_share, self.ratio = self._state.tolist()
        share_std = sqrt(0.5 * (self._covariance[0, 0] + self._covariance[1, 1]))
        needed = STILL_SURE_SIGMAS if self.is_sure else SURE_SIGMAS
        self.is_sure = needed * share_std < self.share < LARGEST_SHARE
        self.is_none = self.share + SURE_SIGMAS * share_std < NONE_SHARE


def _of_stretch(
    time_s: Floats, speed_radps: Floats, angle_rad: Floats, noise_std_radps: float
) -> tuple[Floats, Floats]:
    """(a, b) of a stretch by least squares beside a speed that changes as a parabola, and their covariance.

    What no parabola and no turn explains, as in a slide, is no noise of single readings: it counts by its square.
    """
    mean_radps = speed_radps.mean()
    place = 2.0 * (time_s - time_s[0]) / (time_s[-1] - time_s[0]) - 1.0
    design = np.stack([np.ones_like(place), place, place**2, np.cos(angle_rad), np.sin(angle_rad)], axis=1)
    inverse = np.linalg.inv(design.T @ design + 1e-9 * np.eye(UNKNOWNS))
    relative = speed_radps / mean_radps - 1.0
    found = inverse @ (design.T @ relative)
    left = relative - design @ found
    noise = (noise_std_radps / mean_radps) ** 2
    variance = max(float(left @ left) / (len(left) - UNKNOWNS), noise)
    return found[3:], variance / noise * variance * inverse[3:, 3:]
