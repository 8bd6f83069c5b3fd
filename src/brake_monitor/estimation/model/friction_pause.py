"""What pad friction may have done while nothing showed it: variances by the time without contact."""

from math import exp, isfinite

ONSET_STD = 0.02  # how far friction is off at first contact: a force told late spoils what its release has taught
PAUSE_STD = 0.02  # how far friction moves between two stops (cooling, wet discs), at most
PAUSE_TIME_S = 120.0
COMMON_SHARE, OWN_SHARE = 0.8, 0.2  # of the variance at an onset: weather and heat act on all pads alike


def pause_variance(pause_s: float) -> float:
    """The variance of friction while the pad is off: it relaxes to an unknown value as the disc cools."""
    return PAUSE_STD**2 * (1.0 - exp(-pause_s / PAUSE_TIME_S))


def onset_variance(pause_s: float) -> float:
    """The variance of friction as a new brake application begins; 0 at the first: nothing was known before."""
    return pause_variance(pause_s) + ONSET_STD**2 if isfinite(pause_s) else 0.0
