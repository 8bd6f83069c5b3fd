"""Whether a speed of a recording is told more often than it is measured, as by a gateway that repeats it.

Each repetition counts as a measurement of its own. A speed that changes by more than its own steps from one reading to
the next is not the same twice by chance.
"""

from collections.abc import Iterator
from math import sqrt

import numpy as np

from brake_monitor.inspection.first_hour import FirstHour, change_per_s
from brake_monitor.samples import Quantity

CLEARLY = 3.0  # steps of the signal from one reading to the next
LEAST_COUNT = 100  # readings that change so
REPEATED = 0.4  # of these, as many say the same as the one before


def times_repeated(first_hour: FirstHour, quantity: Quantity, wheelset: int = 0) -> int:
    """How many times each measurement is sent on average; 1 when nothing shows that any is repeated."""
    told = first_hour.readings(quantity, wheelset)
    if told is None:
        return 1
    times_s, values = told
    changes = np.abs(np.diff(values))
    moves = changes > 0.0
    if not moves.any():
        return 1
    step = changes[moves].min()
    clear = np.abs(change_per_s(told.at, times_s[1:])) * np.diff(times_s) > CLEARLY * step
    if np.count_nonzero(clear) < LEAST_COUNT:
        return 1
    same = 1.0 - float(moves[clear].mean())
    return round(1.0 / (1.0 - same)) if REPEATED < same < 1.0 else 1


def remarks_on_repetitions(first_hour: FirstHour) -> Iterator[str]:
    """What to do about each speed that is told again."""
    for name, measurand in first_hour.speeds.items():
        times = times_repeated(first_hour, *measurand)
        if times > 1:
            yield (
                f"{name} is told {times} times before it is measured anew, and each counts as a measurement: "
                f"have it sent as it is measured, or multiply its noise_std by {sqrt(times):.1f}"
            )
