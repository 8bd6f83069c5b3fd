"""Whether a speed of a recording comes in steps that its configured noise does not contain.

The steps of the DBC are added to `noise_std`. A sender that rounds more coarsely than its DBC says, as a display's
kilometres per hour, makes errors that nothing tells the estimator of.
"""

from collections.abc import Iterator
from math import sqrt

import numpy as np

from brake_monitor.inspection.first_hour import FirstHour
from brake_monitor.samples import Quantity

LEAST_COUNT = 20  # changes
FEW = 0.05  # of the changes may be smaller: spikes, and a sender that rounds otherwise for a while
ALIKE = 0.8  # length of the mean phase within a step: 1 where all readings are whole steps apart, 0 where none is
CLEARLY = 1.5  # times the configured noise


def rounding_std(first_hour: FirstHour, quantity: Quantity, wheelset: int) -> float:
    """One sigma of what rounding to the steps it comes in leaves, SI; 0 where it comes in none."""
    told = first_hour.readings(quantity, wheelset)
    if told is None:
        return 0.0
    changes = np.abs(np.diff(told.values))
    changes = changes[changes > 0.0]
    if len(changes) < LEAST_COUNT:
        return 0.0
    about = float(np.quantile(changes, FEW))
    step = float(changes.sum() / np.rint(changes / about).sum())
    phase = abs(np.exp(2j * np.pi * told.values / step).mean())
    return step / sqrt(12.0) if phase > ALIKE else 0.0


def remarks_on_steps(first_hour: FirstHour) -> Iterator[str]:
    """What to do about each speed that is rounded so."""
    for name, measurand in first_hour.speeds.items():
        coarse, configured = rounding_std(first_hour, *measurand), first_hour.noise_std(*measurand)
        if coarse > CLEARLY * configured:
            yield (
                f"{name} comes in coarser steps than the DBC says, which alone err by {coarse / configured:.1f} times "
                "its noise: multiply its noise_std by that, or map a finer one if there is any"
            )
