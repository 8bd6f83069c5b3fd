"""Whether the vehicle speed of a recording is but the mean of its wheel speeds.

While all roll that is as good as any. In a slide it is slow as they are, and by it nobody can tell what slips then and
what the rail gives. A speed that comes from elsewhere is the fastest wheelset's then, or more.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from brake_monitor.inspection.first_hour import FirstHour

LEAST_MPS = 3.0
SLIDING = 0.05  # by so much of the fastest wheelset's speed the wheelsets lie apart
LEAST_COUNT = 5  # readings of the vehicle speed meanwhile
AT_THE_MEAN = 0.2  # of the way from the mean to the fastest: as near are ...
MOST = 0.8  # ... so many of these readings


def remarks_on_wheels_mean(first_hour: FirstHour, wheel_radius_m: Sequence[float]) -> Iterator[str]:
    """What to do about it; nothing where nothing slides, or there is one wheelset alone."""
    speeds = first_hour.speeds_mps(wheel_radius_m)
    if speeds is None or len(wheel_radius_m) == 1:
        return
    (times_s, told_mps), *wheels = speeds
    rolling_mps = np.array([np.interp(times_s, *series) for series in wheels])
    mean_mps, fastest_mps = rolling_mps.mean(axis=0), rolling_mps.max(axis=0)
    slides = (fastest_mps > LEAST_MPS) & (fastest_mps - rolling_mps.min(axis=0) > SLIDING * fastest_mps)
    count = int(np.count_nonzero(slides))
    if count < LEAST_COUNT:
        return
    way = (told_mps - mean_mps)[slides] / (fastest_mps - mean_mps)[slides]  # 0 at the mean, 1 at the fastest
    if float(np.quantile(np.abs(way), MOST)) < AT_THE_MEAN:
        yield (
            "speed is the mean of the wheel speeds, also while they slide: by it nobody can tell slip or adhesion "
            "then; map a speed from something that is not braked, as a satellite receiver or a radar"
        )
