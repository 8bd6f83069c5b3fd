"""How hot the discs are, from the heat that the pads made: one lump, C dT/dt = P − H(v) (T − T_ambient)."""

from math import exp

from brake_monitor.settings.wear_settings import WearSettings


def disc_temperature_c(
    before_c: float, power_w: float, speed_mps: float, step_s: float, settings: WearSettings
) -> float:
    """Temperature after `step_s` with `power_w` into all discs of the wheelset: the lump's exact solution.

    Both are taken as constant over the step, which may be of any length: a pause of the monitor is one step.
    """
    cooling_wpk = settings.disc_cooling_wpk + settings.disc_cooling_per_speed_wpk * abs(speed_mps)
    final_c = settings.ambient_c + power_w / settings.discs_per_wheelset / cooling_wpk
    time_constant_s = settings.disc_mass_kg * settings.disc_heat_capacity_jpkgk / cooling_wpk
    return final_c + (before_c - final_c) * exp(-max(step_s, 0.0) / time_constant_s)
