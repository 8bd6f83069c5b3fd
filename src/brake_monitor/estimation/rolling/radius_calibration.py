"""The radius of a wheel from how fast it turns while it rolls: worn wheels are up to 9 % smaller and fake slip."""

LEAST_SPEED_MPS = 5.0  # below it the speeds' own noise counts too much
LARGEST_CHANGE = 0.10  # relative: worn, or new where a worn one is configured; more is a wrong configuration
MEMORY_S = 30.0  # of rolling; long against the noise, short against wear
PRIOR_S = 0.5  # of rolling: the weight of the configured radius, or of one from before a long pause
TURNED_S = 3600.0  # a pause in which a wheelset may have been turned or changed


def radius_range(configured_m: float) -> tuple[float, float]:
    """The least and the largest radius that is learned of a wheel, in m, given the configured one."""
    return configured_m * (1.0 - LARGEST_CHANGE), configured_m * (1.0 + LARGEST_CHANGE)


class RadiusCalibration:
    """Averages v / omega over stretches of free rolling, within bounds around the configured radius."""

    def __init__(self, configured_m: float) -> None:
        self.configured_m = self.radius_m = configured_m
        self._least_m, self._most_m = radius_range(configured_m)
        self.rolled_s = PRIOR_S  # of rolling over which the radius is the mean

    def see_rolling(self, speed_mps: float, omega_radps: float, step_s: float) -> None:
        """Take the speeds of a wheelset that neither brakes nor drives."""
        if speed_mps < LEAST_SPEED_MPS or not self._least_m * omega_radps < speed_mps < self._most_m * omega_radps:
            return
        rolled_s = self.rolled_s + step_s
        self.rolled_s = rolled_s = rolled_s if rolled_s < MEMORY_S else MEMORY_S
        self.radius_m += (speed_mps / omega_radps - self.radius_m) * step_s / rolled_s
