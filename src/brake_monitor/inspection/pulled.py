"""Whether a wagon with the preset for a single wagon is pulled by others: none gets to speed on its own."""

from collections.abc import Iterator

import numpy as np

from brake_monitor.arrays import Floats
from brake_monitor.inspection.first_hour import FirstHour
from brake_monitor.samples import Quantity
from brake_monitor.settings.config import Settings

STANDING_MPS = 0.5
FAST_MPS = 10.0  # no hump of a marshalling yard makes a wagon this fast
STEEPEST_MPS2 = 0.35  # no line lets a wagon gain as much by itself: 35 per mille
QUICKEST_MPS2 = 1.2  # no train gains more
ROLLING_MPS = 3.0  # sensors that say 0 when they should not do so below
LEAST_S = 10.0  # a start takes longer; a speed that gets there sooner is that of a sensor that has said 0


def remarks_on_pull(first_hour: FirstHour, settings: Settings) -> Iterator[str]:
    """What to do about it; nothing where preset or motors account for it."""
    told = first_hour.readings(Quantity.SPEED)
    if told is None or settings.estimator.preset != "wagon" or settings.signals.wheel_torque:
        return
    times_s, speeds_mps = told.times_s, np.abs(told.values)
    stood_s = np.maximum.accumulate(np.where(speeds_mps < STANDING_MPS, times_s, -np.inf))
    taken_s = (times_s - stood_s)[speeds_mps > FAST_MPS]
    if np.isfinite(taken_s).any() and taken_s.min() > LEAST_S:
        done = f"goes from standstill to {FAST_MPS * 3.6:.0f} km/h"
    elif _gains(times_s, speeds_mps):
        done = f"gains {STEEPEST_MPS2} m/s² and more for {LEAST_S:.0f} s"
    else:
        return
    yield (
        f"the wagon {done}, and no wheel_torque says by what: in a "
        'train say preset = "train", and map motors of its own; with "wagon" what others do to it while its brake '
        "is on is read as friction"
    )


def _gains(times_s: Floats, speeds_mps: Floats) -> bool:
    """Whether it gets faster than downhill; in either half of the time, since a sensor may begin to tell at once."""
    if np.any(np.diff(times_s) < 0.0):  # a clock was set back
        return False
    ends_s = times_s[times_s >= times_s[0] + LEAST_S]
    begun, halfway, ended = (np.interp(ends_s - ago_s, times_s, speeds_mps) for ago_s in (LEAST_S, LEAST_S / 2, 0.0))
    gains_mps = np.stack((halfway - begun, ended - halfway))
    least_mps, most_mps = (rate * LEAST_S / 2 for rate in (STEEPEST_MPS2, QUICKEST_MPS2))
    is_pulled = ((gains_mps > least_mps) & (gains_mps < most_mps)).all(axis=0)
    return bool(np.any(is_pulled & (begun > ROLLING_MPS)))
