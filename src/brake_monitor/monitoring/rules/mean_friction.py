"""The friction of pads in several brake applications: its mean, and how well that is known."""

from collections.abc import Sequence
from math import hypot, sqrt

from msgspec.structs import replace

from brake_monitor.monitoring.brake_units.application_record import ApplicationRecord, WheelsetRecord

# How much gradients may change is said before any stop was seen. It weighs as much as what so many stops show of it.
GUESS_STOPS = 3.0


def pooled(records: Sequence[ApplicationRecord], alike_std: float | None) -> ApplicationRecord:
    """The last of these applications, with each wheelset's friction averaged over all of them.

    `alike_std`: of what friction errs by in all applications alike; None: all of it, as in a train.
    """
    wheelsets = zip(*(one.wheelsets for one in records), strict=True)
    return replace(records[-1], wheelsets=tuple(_mean(own, alike_std) for own in wheelsets))


def _mean(records: Sequence[WheelsetRecord], alike_std: float | None) -> WheelsetRecord:
    """Of one wheelset, weighted by certainty. Errors by gradients differ from stop to stop; other errors do not.

    Stops that agree by more than gradients were taken to let them show that gradients change less there, and stops
    that scatter by more, that they change more.
    """
    known = [own for own in records if own.friction is not None and own.friction_std]
    if not known:
        return records[-1]
    weights = [1.0 / (own.friction_std or 1.0) ** 2 for own in known]
    shares = [weight / sum(weights) for weight in weights]
    friction = sum(share * (own.friction or 0.0) for share, own in zip(shares, known, strict=True))
    scatter = sum(weight * ((own.friction or 0.0) - friction) ** 2 for weight, own in zip(weights, known, strict=True))
    shown = sqrt((GUESS_STOPS + scatter) / (GUESS_STOPS + len(known) - 1))
    guessed = hypot(*(share * (own.friction_gradient_std or 0.0) for share, own in zip(shares, known, strict=True)))
    apart = shown * guessed
    common = _std_of_mean(known, shares, alike_std)
    return replace(
        records[-1],
        friction=friction,
        friction_std=hypot(common, apart),
        friction_gradient_std=apart,
        friction_energy_j=sum(own.friction_energy_j for own in known),
    )


def _std_of_mean(records: Sequence[WheelsetRecord], shares: Sequence[float], alike_std: float | None) -> float:
    """Of what friction itself is off by on average, gradients apart.

    `alike_std` of it is the same in all applications. The rest, which line and noise have left, goes on from one to the
    next as far as that has not learned friction anew: by its variance over what that was as the application began.
    """
    if alike_std is None:
        return sum(share * own.own_friction_std for share, own in zip(shares, records, strict=True))
    alike = min(alike_std**2, *(own.own_friction_std**2 for own in records))
    variance, carried = alike, 0.0  # `carried`: of the mean so far with the error of the last application
    for share, own in zip(shares, records, strict=True):
        rest = own.own_friction_std**2 - alike
        before = rest if own.friction_prior_std is None else max(own.friction_prior_std**2 - alike, rest)
        carried *= rest / before if before else 0.0
        variance += share * (share * rest + 2.0 * carried)
        carried += share * rest
    return sqrt(variance)
