"""How much later than the wheel speeds the vehicle speed of a recording comes, as satellite receivers and filters do.

To the estimator a speed that lags by tau is a slip of tau times the deceleration on all wheelsets, and it takes what is
missing of the deceleration for d: beyond the lag L that it learns nothing gives it away live. Over a recording it does.
While the wagon brakes or pulls and its wheels roll, the speed repeats what the wheels did before; while they slide it
does not, and nothing is said.
A speed that is said to lag more than it does comes early: that is looked for as far as it is said to lag.
Creep looks like a lag of up to a tenth of a second, and where it is some per cent like any, until the brake changes.
"""

from collections.abc import Callable, Sequence

import numpy as np

from brake_monitor.arrays import Floats
from brake_monitor.inspection.first_hour import CHANGE_SPAN_S, LEAST_MPS, FirstHour, Readings, change_per_s
from brake_monitor.samples import Quantity

LONGEST_LAG_S, STEP_S = 5.0, 0.05  # so much may be any beyond
LEAST_LAG_S = 0.15  # more than creep looks like
UNSURE = 0.15  # of what is found
EXPLAINED = 0.25  # of the difference between speed and wheels, what a lag may leave of it
REPEATED = 0.3  # of the difference between their accelerations, as brakes are put on, what it may leave
JUMP_MPS2 = 0.3  # of the acceleration, within CHANGE_SPAN_S to both sides
STEADY_MPS2, CHANGING_MPS2, SLIDING_MPS2 = 0.15, 0.3, 2.0
LEAST_COUNT = 40  # speeds while it brakes or pulls, and while it does neither
LEAST_JUMPING = 10


def speed_lag_s(first_hour: FirstHour, wheel_radius_m: Sequence[float]) -> float | None:
    """By how many seconds the speed comes late, negative: early; None when it is in time or nothing can be told."""
    speeds = first_hour.speeds_mps(wheel_radius_m)
    if speeds is None:
        return None
    (told_s, told_mps), *wheels = speeds
    steps_early = round(first_hour.delay_s(Quantity.SPEED) / STEP_S)
    lags_s = STEP_S * np.arange(-steps_early, round(LONGEST_LAG_S / STEP_S) + 1)

    def rolling_mps(at_s: Floats) -> Floats:
        """The speed of the wheelset that slides least."""
        fastest: Floats = np.array([wheel.at(at_s) for wheel in wheels]).max(axis=0)
        return fastest

    begin_s = max(float(times_s[0]) for times_s, _ in wheels) + LONGEST_LAG_S
    end_s = min(float(times_s[-1]) for times_s, _ in wheels) - 2.0 * CHANGE_SPAN_S + lags_s[0]
    during = (told_s >= begin_s) & (told_s <= end_s) & (told_mps > LEAST_MPS) & (rolling_mps(told_s) > LEAST_MPS)
    time_s, speed_mps = told_s[during], told_mps[during]
    change_mps2 = np.abs(change_per_s(rolling_mps, time_s))
    steady, changing = change_mps2 < STEADY_MPS2, (change_mps2 > CHANGING_MPS2) & (change_mps2 < SLIDING_MPS2)
    if min(np.count_nonzero(steady), np.count_nonzero(changing)) < LEAST_COUNT:
        return None
    radius_error = np.median(speed_mps[steady] / rolling_mps(time_s[steady]))
    changing_s, changing_mps = time_s[changing], speed_mps[changing] / radius_error
    off_mps = [np.median(np.abs(changing_mps - rolling_mps(changing_s - lag_s))) for lag_s in lags_s]
    best = int(np.argmin(off_mps))
    lag_s = float(lags_s[best])
    is_one = abs(lag_s) >= LEAST_LAG_S and lag_s < lags_s[-1] and off_mps[best] < EXPLAINED * off_mps[steps_early]
    vehicle = Readings(told_s, told_mps / radius_error)
    return lag_s if is_one and _repeats(vehicle, rolling_mps, time_s, lag_s) else None


def _repeats(vehicle: Readings, rolling_mps: Callable[[Floats], Floats], time_s: Floats, lag_s: float) -> bool:
    """Whether as the brake is put on or let go the vehicle does so much later, or earlier, what the wheels do.

    Where all wheelsets creep by some per cent their speeds lie apart as with a lag, but change together.
    """
    before_s, after_s = time_s - CHANGE_SPAN_S, time_s + CHANGE_SPAN_S
    jump_mps2 = np.abs(change_per_s(rolling_mps, after_s) - change_per_s(rolling_mps, before_s))
    changes_s = time_s[jump_mps2 > JUMP_MPS2]
    at_s = np.concatenate((changes_s, changes_s + lag_s))
    at_s = at_s[(at_s >= time_s[0]) & (at_s <= time_s[-1])]
    if len(at_s) < LEAST_JUMPING:
        return False
    vehicle_mps2 = change_per_s(vehicle.at, at_s)
    later, at_once = [
        float(np.median(np.abs(vehicle_mps2 - change_per_s(rolling_mps, at_s - by_s)))) for by_s in (lag_s, 0.0)
    ]
    return later < REPEATED * at_once
