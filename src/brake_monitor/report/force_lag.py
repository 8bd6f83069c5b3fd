"""How much later than its wheelset's speed a pressing force of a recording comes, or earlier: see `ForceTiming`.

Only slides tell: there the wheelset obeys its brake at once.
"""

from collections.abc import Sequence

import numpy as np

from brake_monitor.estimation.brake_work import SLIDING_SLIP
from brake_monitor.estimation.force_timing import EARLY_S, LATE_S, ForceTiming
from brake_monitor.estimation.held_input import PROMPT_S
from brake_monitor.frame_block import Bools, Floats
from brake_monitor.report.first_hour import FirstHour
from brake_monitor.samples import Quantity

LEAST_MPS = 3.0
LOCKED_SLIP = 0.9
LEAST_COUNT = 50  # readings in slides that tell of it


def force_lags_s(first_hour: FirstHour, wheel_radius_m: Sequence[float]) -> list[float | None]:
    """By how much each force comes later, in s, earlier where negative; None where it does not, or nothing tells."""
    speeds = first_hour.speeds_mps(wheel_radius_m)
    if speeds is None:
        return [None] * len(wheel_radius_m)
    vehicle, *wheels = speeds
    lags_s: list[float | None] = []
    for place, ((told_s, rim_mps), radius_m) in enumerate(zip(wheels, wheel_radius_m, strict=True)):
        forces = first_hour.readings(Quantity.PRESSING_FORCE, place)
        is_prompt = forces is not None and float(np.median(np.diff(forces[0]))) <= PROMPT_S
        if forces is None or not is_prompt:
            lags_s.append(None)
            continue
        speed_mps = np.interp(told_s, *vehicle)
        slip = 1.0 - rim_mps / np.maximum(speed_mps, LEAST_MPS)
        slides = (slip > SLIDING_SLIP) & (slip < LOCKED_SLIP) & (speed_mps > LEAST_MPS)
        lags_s.append(_lag_s(told_s, rim_mps / radius_m, slides, _impulses_ns(*forces, told_s)))
    return lags_s


def _impulses_ns(times_s: Floats, forces_n: Floats, until_s: Floats) -> Floats:
    """∫F dt from each of these times to the next one."""
    impulse_ns = np.concatenate(([0.0], np.cumsum(0.5 * (forces_n[1:] + forces_n[:-1]) * np.diff(times_s))))
    impulses: Floats = np.diff(np.interp(until_s, times_s, impulse_ns), prepend=0.0)
    return impulses


def _lag_s(times_s: Floats, omega_radps: Floats, slides: Bools, impulses_ns: Floats) -> float | None:
    timing, told_s = ForceTiming(), []
    for k in np.flatnonzero(slides).tolist():
        if k and not slides[k - 1]:
            timing.see(float(times_s[k - 1]), float(omega_radps[k - 1]), 0.0)
        timing.press(float(impulses_ns[k]))
        timing.see(float(times_s[k]), float(omega_radps[k]), 1.0)
        if timing.is_known:
            told_s.append(timing.lag_s)
    lag_s = float(np.median(told_s)) if len(told_s) >= LEAST_COUNT else 0.0
    return None if -EARLY_S <= lag_s <= LATE_S else lag_s
