"""Whether a wagon with the preset for a single wagon is pulled by others: none gets to speed on its own."""

from collections.abc import Iterator

import numpy as np

from brake_monitor.inspection.first_hour import FirstHour
from brake_monitor.samples import Quantity
from brake_monitor.settings.config import Settings

STANDING_MPS = 0.5
FAST_MPS = 10.0  # no hump of a marshalling yard makes a wagon this fast
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
        yield (
            f"the wagon goes from standstill to {FAST_MPS * 3.6:.0f} km/h, and no wheel_torque says by what: in a "
            'train say preset = "train", and map motors of its own; with "wagon" what others do to it while its brake '
            "is on is read as friction"
        )
