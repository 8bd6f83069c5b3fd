"""Whether the vehicle speed of a recording is made of its wheel speeds.

While all roll that is as good as any. In a slide it is slow as they are, and by it nobody can tell what slips then and
what the rail gives. A speed that comes from elsewhere is the fastest wheelset's then, or more, and does not jump with
it: a wheelset that slides loses or gains within a moment what no wagon can.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from brake_monitor.arrays import Floats
from brake_monitor.inspection.first_hour import LEAST_MPS, FirstHour, Readings

SLIDING = 0.05  # by so much of the fastest wheelset's speed the wheelsets lie apart
LEAST_COUNT = 5  # readings of the vehicle speed meanwhile
AT_THE_MEAN = 0.2  # of the way from the mean to the fastest: as near are ...
MOST = 0.8  # ... so many of these readings
JUMP_S, JUMP_MPS2 = 0.2, 3.0  # a speed that changes so fast for as long jumps: no train and no tram does
LEAST_JUMPS = 12  # readings in one
FOLLOWS = 0.3  # of a jump, what a speed that follows it may miss; one from elsewhere misses more than half
LATE_S = (0.0, 0.05, 0.1)  # it may be


def remarks_on_wheels_mean(first_hour: FirstHour, wheel_radius_m: Sequence[float]) -> Iterator[str]:
    """What to do about it; nothing where nothing slides."""
    speeds = first_hour.speeds_told_together_mps(wheel_radius_m)
    if speeds is None:
        return
    (times_s, told_mps), *wheels = speeds
    if len(wheels) > 1 and _is_mean(told_mps, _at(times_s, wheels)):
        yield (
            "speed is the mean of the wheel speeds, also while they slide: by it nobody can tell slip or adhesion "
            "then; map a speed from something that is not braked, as a satellite receiver or a radar"
        )
    elif any(_jumps_along(times_s, told_mps, _at(times_s - late_s, wheels)) for late_s in LATE_S):
        yield (
            "speed jumps as wheel speeds do in slides, and no vehicle can: it is made of them, and by it nobody can "
            "tell slip or adhesion then; map one from something that is not braked, as a satellite receiver or a radar"
        )


def _at(times_s: Floats, wheels: Sequence[Readings]) -> Floats:
    """What the wheels did then, a row for each."""
    return np.array([wheel.at(times_s) for wheel in wheels])


def _is_mean(told_mps: Floats, rolling_mps: Floats) -> bool:
    mean_mps, fastest_mps = rolling_mps.mean(axis=0), rolling_mps.max(axis=0)
    slides = (fastest_mps > LEAST_MPS) & (fastest_mps - rolling_mps.min(axis=0) > SLIDING * fastest_mps)
    if np.count_nonzero(slides) < LEAST_COUNT:
        return False
    way = (told_mps - mean_mps)[slides] / (fastest_mps - mean_mps)[slides]  # 0 at the mean, 1 at the fastest
    return float(np.quantile(np.abs(way), MOST)) < AT_THE_MEAN


def _jumps_along(times_s: Floats, told_mps: Floats, rolling_mps: Floats) -> bool:
    """Whether it does with the fastest of them, with the second fastest or with their mean."""
    ranked_mps = np.sort(rolling_mps, axis=0)[::-1]
    begins = times_s + JUMP_S <= times_s[-1]

    def change(speed_mps: Floats) -> Floats:
        changes: Floats = Readings(times_s, speed_mps).at(times_s[begins] + JUMP_S) - speed_mps[begins]
        return changes

    told_change_mps = change(told_mps)
    for made_mps in (*ranked_mps[:2], rolling_mps.mean(axis=0)):
        jumps_mps = change(made_mps)
        jumps = (np.abs(jumps_mps) > JUMP_MPS2 * JUMP_S) & (ranked_mps[0][begins] > LEAST_MPS)
        missed = np.abs(told_change_mps - jumps_mps)[jumps] / np.abs(jumps_mps[jumps])
        if len(missed) >= LEAST_JUMPS and float(np.median(missed)) < FOLLOWS:
            return True
    return False
