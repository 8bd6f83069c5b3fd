"""Brake pad on disc: friction that depends on speed, pressure and heat, and the heat itself."""

import math

from brake_monitor.simulator.physics.compiled import compiled

NOMINAL_FRICTION = 0.35
LOW_SPEED_RISE = 0.08  # friction gained as the disc slows down ...
LOW_SPEED_MPS = 3.0  # ... below about this sliding speed between pad and disc
PRESSURE_LOSS = 0.03  # friction lost at full pressing force
FADE_START_C = 400.0
FADE_END_C = 700.0
FADE_LOSS = 0.4  # fraction of the friction lost at the end of fading
CONTACT_TIME_CONSTANT_S = 1.5  # contact patches grow and decay; friction follows its causes with this lag (Ostermeyer)

AMBIENT_C = 15.0
DISC_HEAT_CAPACITY_JPK = 110e3  # the discs of one wheelset, about 220 kg
COOLING_STILL_WPK = 60.0
COOLING_PER_SPEED_WPK = 6.0  # per m/s


@compiled
def steady_friction(sliding_speed_mps: float, relative_force: float, temperature_c: float) -> float:
    """Friction coefficient that this operating point settles to; `relative_force` is 1 at full pressing force."""
    fading = min(max((temperature_c - FADE_START_C) / (FADE_END_C - FADE_START_C), 0.0), 1.0)
    fade = FADE_LOSS * fading * fading * (3.0 - 2.0 * fading)
    rise = LOW_SPEED_RISE * math.exp(-abs(sliding_speed_mps) / LOW_SPEED_MPS)
    return (NOMINAL_FRICTION + rise - PRESSURE_LOSS * relative_force) * (1.0 - fade)


@compiled
def disc_temperature(temperature_c: float, step_s: float, friction_power_w: float, speed_mps: float) -> float:
    """Temperature of a wheelset's discs after `step_s` of this heat and this wind of the journey."""
    cooling_wpk = COOLING_STILL_WPK + COOLING_PER_SPEED_WPK * abs(speed_mps)
    loss_w = cooling_wpk * (temperature_c - AMBIENT_C)
    return temperature_c + step_s * (friction_power_w - loss_w) / DISC_HEAT_CAPACITY_JPK


@compiled
def following(friction: float, step_s: float, target: float) -> float:
    """Friction after `step_s` on its way to `target`, the `steady_friction` of these pads."""
    return friction + (target - friction) * step_s / CONTACT_TIME_CONSTANT_S
