"""How much later than its wheelset's speed a pressing force of a recording comes, or earlier: see `ForceTiming`.

Only slides tell: there the wheelset obeys its brake at once. They also tell when it obeys another's: then two of them
were taken for each other, and what looks like a lag is none.
`ForceTiming` sees a tenth of a second to both sides. What comes later than that is shifted until it does.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from brake_monitor.arrays import Bools, Floats
from brake_monitor.estimation.brake_work import SLIDING_SLIP
from brake_monitor.estimation.doubts.force_timing import EARLIEST, EARLY_S, LAGS, LATEST, ForceTiming
from brake_monitor.estimation.inputs.held_input import PROMPT_S
from brake_monitor.inspection.first_hour import LEAST_MPS, FirstHour, Readings
from brake_monitor.samples import Quantity

LOCKED_SLIP = 0.9
LEAST_COUNT = 50  # readings in slides that tell of it
BETTER = 2.0  # what its own force leaves unexplained of a wheelset's acceleration, over what another's leaves
CLEARLY_LATE_S = 0.024  # a rail that gives more with slip makes a force look up to 0.022 s late
LONGEST_LAG_S, SHIFT_S = 1.0, 0.2


class Obeyed(NamedTuple):
    """The pressing force that a wheelset obeys."""

    place: int
    lag_s: float  # by which it comes later than it should, earlier where negative; 0 in step
    unexplained: float  # share of the acceleration


def obeyed_forces(first_hour: FirstHour, wheel_radius_m: Sequence[float]) -> list[Obeyed | None]:
    """Which force each wheelset obeys: its own unless another explains far better what it does; None: nothing tells."""
    speeds = first_hour.speeds_mps(wheel_radius_m)
    if speeds is None:
        return [None] * len(wheel_radius_m)
    vehicle, *wheels = speeds
    forces = [first_hour.readings(Quantity.PRESSING_FORCE, place) for place in range(len(wheels))]
    prompt = {
        place: told
        for place, told in enumerate(forces)
        if told is not None and float(np.median(np.diff(told.times_s))) <= PROMPT_S
    }
    obeyed: list[Obeyed | None] = []
    for own, ((told_s, rim_mps), radius_m) in enumerate(zip(wheels, wheel_radius_m, strict=True)):
        speed_mps = vehicle.at(told_s)
        slip = 1.0 - rim_mps / np.maximum(speed_mps, LEAST_MPS)
        turned = _Turned(
            told_s, rim_mps / radius_m, (slip > SLIDING_SLIP) & (slip < LOCKED_SLIP) & (speed_mps > LEAST_MPS)
        )
        earliest_s = first_hour.delay_s(Quantity.PRESSING_FORCE, own)
        shifts_s = [*np.arange(SHIFT_S, LONGEST_LAG_S, SHIFT_S), *np.arange(-SHIFT_S, -earliest_s, -SHIFT_S)]
        tried = [(place, 0.0) for place in prompt] + [(own, float(shift_s)) for shift_s in shifts_s if own in prompt]
        fits = {one: _fit(one[0], turned, prompt[one[0]], one[1]) for one in tried}
        left = {one: fit.unexplained / (BETTER if one == (own, 0.0) else 1.0) for one, fit in fits.items() if fit}
        obeyed.append(fits[min(left, key=left.__getitem__)] if left else None)
    return obeyed


class _Turned(NamedTuple):
    """What a wheelset did."""

    times_s: Floats
    omega_radps: Floats
    slides: Bools


def _impulses_ns(force: Readings, until_s: Floats) -> Floats:
    """∫F dt from each of these times to the next one."""
    times_s, forces_n = force
    impulse_ns = np.concatenate(([0.0], np.cumsum(0.5 * (forces_n[1:] + forces_n[:-1]) * np.diff(times_s))))
    impulses: Floats = np.diff(np.interp(until_s, times_s, impulse_ns), prepend=0.0)
    return impulses


def _fit(place: int, turned: _Turned, force: Readings, shift_s: float) -> Obeyed | None:
    """How well the force at this place explains what the wheelset did, if it is about `shift_s` late."""
    times_s, omega_radps, slides = turned
    if np.count_nonzero(slides) < LEAST_COUNT:
        return None
    impulses_ns = _impulses_ns(force._replace(times_s=force.times_s - shift_s), times_s)
    timing, told_s, unexplained = ForceTiming(), [], []
    around = np.convolve(slides, np.ones(2 * LAGS + 1), "same") > 0.0
    spacing_s = float(np.median(np.diff(times_s)))
    widest_s = (min(EARLIEST, LATEST) - 0.5) * spacing_s  # beyond: no peak, but the search's end
    for k in np.flatnonzero(around).tolist():
        timing.press(float(impulses_ns[k]))
        timing.see(float(times_s[k]), float(omega_radps[k]), 1.0 if slides[k] else 0.0)
        if not slides[k]:
            continue
        if timing.is_known and abs(timing.lag_s) < widest_s:
            told_s.append(timing.lag_s)
        unexplained.append(1.0 - timing.correlation**2)
    if len(told_s) < LEAST_COUNT:
        return None
    lag_s = shift_s + float(np.median(told_s))
    return Obeyed(place, 0.0 if -EARLY_S <= lag_s <= CLEARLY_LATE_S else lag_s, float(np.median(unexplained)))
