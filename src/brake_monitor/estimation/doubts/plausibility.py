"""Whether a reading that arrived whole may be believed, judged before the filter sees it."""

from math import inf

from brake_monitor.samples import TRAITS, Sample


def is_possible(sample: Sample) -> bool:
    """Whether time and value are finite and of a size that occurs."""
    return abs(sample.time_s) < inf and abs(sample.value) <= TRAITS[sample.quantity].largest
