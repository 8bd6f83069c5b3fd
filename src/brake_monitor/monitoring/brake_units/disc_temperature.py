"""How hot the discs are, from the heat that the pads made: one lump, C dT/dt = P − H(v) (T − T_ambient)."""

from math import exp

from brake_monitor.settings.wear_settings import WearSettings


class Cooling:
    """How discs cool in a step, all alike, at a speed that is taken as constant.

    It may be of any length: a pause of the monitor is one step.
    """

    def __init__(self, speed_mps: float, step_s: float, settings: WearSettings) -> None:
        self._ambient_c, self._discs = settings.ambient_c, settings.discs_per_wheelset
        self._cooling_wpk = settings.disc_cooling_wpk + settings.disc_cooling_per_speed_wpk * abs(speed_mps)
        time_constant_s = settings.disc_mass_kg * settings.disc_heat_capacity_jpkgk / self._cooling_wpk
        self.left = exp(-max(step_s, 0.0) / time_constant_s)  # of what a disc is warmer than it ends up

    def temperature_c(self, before_c: float, power_w: float) -> float:
        """After it, with `power_w` all the time into all discs of the wheelset: the lump's exact solution."""
        final_c = self._ambient_c + power_w / self._discs / self._cooling_wpk
        return final_c + (before_c - final_c) * self.left


class EarlierHeat:
    """How much is left of the heat that discs had as an earlier run ended; what that was may become known later."""

    def __init__(self, settings: WearSettings) -> None:
        self._settings = settings
        self._left, self._lasted_s = 1.0, 0.0  # share of it since this run began, and how long ago that is
        self._began_mps: float | None = None  # the speed then

    def cool(self, cooling: Cooling, speed_mps: float, step_s: float) -> None:
        """Take the next step of this run, and how discs cooled in it; the first one is its first observation."""
        if self._began_mps is None:
            self._began_mps = speed_mps
        self._left *= cooling.left
        self._lasted_s += step_s

    def left_c(self, earlier_c: float, since_s: float) -> float:
        """By how much discs are warmer for it that had `earlier_c` so long ago."""
        pause_s = since_s - self._lasted_s
        left = self._left * Cooling(self._began_mps or 0.0, pause_s, self._settings).left
        return (earlier_c - self._settings.ambient_c) * left
