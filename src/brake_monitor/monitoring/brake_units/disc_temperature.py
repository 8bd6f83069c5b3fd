"""How hot the discs are, from the heat that the pads made: one lump, C dT/dt = P − H(v) (T − T_ambient)."""

from math import exp

from brake_monitor.settings.wear_settings import WearSettings


def disc_temperature_c(
    before_c: float, power_w: float, speed_mps: float, step_s: float, settings: WearSettings
) -> float:
    """Temperature after `step_s` with `power_w` into all discs of the wheelset: the lump's exact solution.

    Both are taken as constant over the step, which may be of any length: a pause of the monitor is one step.
    """
    final_c = settings.ambient_c + power_w / settings.discs_per_wheelset / _cooling_wpk(speed_mps, settings)
    return final_c + (before_c - final_c) * _left(speed_mps, step_s, settings)


class EarlierHeat:
    """How much is left of the heat in which an earlier run left the discs, which may become known only later."""

    def __init__(self, settings: WearSettings) -> None:
        self._settings = settings
        self._left, self._lasted_s = 1.0, 0.0  # of what there was as this run began, so long ago
        self._began_mps: float | None = None  # at this speed

    def cool(self, speed_mps: float, step_s: float) -> None:
        """Take the next step of this run; the first one is its first observation."""
        if self._began_mps is None:
            self._began_mps = speed_mps
        self._left *= _left(speed_mps, step_s, self._settings)
        self._lasted_s += step_s

    def left_c(self, earlier_c: float, since_s: float) -> float:
        """By how much discs are warmer for it that had `earlier_c` so long ago."""
        pause_s = since_s - self._lasted_s
        left = self._left * _left(self._began_mps or 0.0, pause_s, self._settings)
        return (earlier_c - self._settings.ambient_c) * left


def _left(speed_mps: float, step_s: float, settings: WearSettings) -> float:
    """The share of what a disc is warmer than it ends up that is left after a step."""
    time_constant_s = settings.disc_mass_kg * settings.disc_heat_capacity_jpkgk / _cooling_wpk(speed_mps, settings)
    return exp(-max(step_s, 0.0) / time_constant_s)


def _cooling_wpk(speed_mps: float, settings: WearSettings) -> float:
    return settings.disc_cooling_wpk + settings.disc_cooling_per_speed_wpk * abs(speed_mps)
