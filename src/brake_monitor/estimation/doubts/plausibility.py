"""Whether a reading that arrived whole may be believed, judged before the filter sees it."""

from collections.abc import Mapping
from math import inf

from brake_monitor.samples import Quantity, Sample

# Nothing on rails exceeds these (SI, absolute); they keep a sensor's nonsense out of the arithmetic.
LARGEST: Mapping[Quantity, float] = {
    Quantity.SPEED: 200.0,
    Quantity.AXLE_SPEED: 1000.0,
    Quantity.PRESSING_FORCE: 1e6,
    Quantity.LOAD_FORCE: 5e6,
    Quantity.WHEEL_TORQUE: 1e6,
    Quantity.GRADIENT: 0.5,
}


def is_possible(sample: Sample) -> bool:
    """Whether time and value are finite and of a size that occurs."""
    return abs(sample.time_s) < inf and abs(sample.value) <= LARGEST.get(sample.quantity, inf)
