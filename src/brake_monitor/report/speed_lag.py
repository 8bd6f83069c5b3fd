"""How much later than the wheel speeds the vehicle speed of a recording comes, as satellite receivers and filters do.

To the estimator a speed that lags by tau is a slip of tau times the deceleration on all wheelsets, and it takes what is
missing of the deceleration for d: nothing gives it away live. Over a recording it does. While the wagon brakes or pulls
and its wheels roll, the speed repeats what the wheels did before; while they slide it does not, and nothing is said.
Creep looks like a lag of up to a tenth of a second.
"""

from collections.abc import Sequence

import numpy as np

from brake_monitor.frame_block import Floats
from brake_monitor.report.first_hour import FirstHour

LAGS_S = np.arange(0.0, 5.01, 0.05)  # the last one may be any beyond
LEAST_LAG_S = 0.15  # more than creep looks like
EXPLAINED = 0.25  # of the difference between speed and wheels, what a lag may leave of it
STEADY_MPS2, CHANGING_MPS2, SLIDING_MPS2 = 0.15, 0.3, 2.0
SPAN_S = 0.5  # to both sides, for the deceleration
LEAST_MPS = 3.0
LEAST_COUNT = 40  # speeds while it brakes or pulls, and while it does neither


def speed_lag_s(first_hour: FirstHour, wheel_radius_m: Sequence[float]) -> float | None:
    """By how much the speed comes later, in s; None where it does not, or nothing tells."""
    speeds = first_hour.speeds_mps(wheel_radius_m)
    if speeds is None:
        return None
    (told_s, told_mps), *wheels = speeds

    def rolling_mps(at_s: Floats) -> Floats:
        """Of the wheelset that slides least."""
        fastest: Floats = np.max([np.interp(at_s, *series) for series in wheels], axis=0)
        return fastest

    begin_s = max(float(times_s[0]) for times_s, _ in wheels) + LAGS_S[-1]
    end_s = min(float(times_s[-1]) for times_s, _ in wheels) - SPAN_S
    during = (told_s >= begin_s) & (told_s <= end_s) & (told_mps > LEAST_MPS) & (rolling_mps(told_s) > LEAST_MPS)
    time_s, speed_mps = told_s[during], told_mps[during]
    change_mps2 = np.abs(rolling_mps(time_s + SPAN_S) - rolling_mps(time_s - SPAN_S)) / (2.0 * SPAN_S)
    steady, changing = change_mps2 < STEADY_MPS2, (change_mps2 > CHANGING_MPS2) & (change_mps2 < SLIDING_MPS2)
    if min(np.count_nonzero(steady), np.count_nonzero(changing)) < LEAST_COUNT:
        return None
    radius_error = np.median(speed_mps[steady] / rolling_mps(time_s[steady]))
    changing_s, changing_mps = time_s[changing], speed_mps[changing] / radius_error
    off_mps = [np.median(np.abs(changing_mps - rolling_mps(changing_s - lag_s))) for lag_s in LAGS_S]
    best = int(np.argmin(off_mps))
    lag_s = float(LAGS_S[best])
    is_one = LEAST_LAG_S <= lag_s < LAGS_S[-1] and off_mps[best] < EXPLAINED * off_mps[0]
    return lag_s if is_one else None
