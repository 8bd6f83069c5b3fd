"""Shares of the brake torque on which several brake applications agree, each elsewhere: what a curve does, they do not.

In one or two a curve may make a share look unequal.
"""

from collections.abc import Sequence
from math import hypot, sqrt
from operator import mul
from statistics import mean, median

from brake_monitor.monitoring.brake_units.application_record import ApplicationRecord
from brake_monitor.monitoring.contact_stiffness import SOFT
from brake_monitor.monitoring.rules.creep_shares import CLEAR_SIGMAS, LEAST_CREEP, Share, mean_creep

LEAST_SHARE = 1e-6  # none, or all that is borne
SURELY_APART = 0.28  # of what the others bear, time and again: 0.20 may be its load, its profile, or a better rail
LAGS = 0.20  # of the others' creep on a soft contact: more than what unlike wheelsets creep apart there
STIFF = 60.0  # adhesion over creep: below that it may be the rail that gives no more
BY_ITS_FORCE = 0.9  # a share that is less by its pressing force is that force's
AGREEING_APPLICATIONS = 4  # at least
# Student's t by which a share in 4, 5, … applications is sure to 99.9 %: nobody knows how much curves do, and every
# wheelset is looked at after every application.
SURE_T = (12.92, 8.61, 6.87, 5.96, 5.41, 5.04, 4.78, 4.59, 4.44, 4.32, 4.22, 4.14, 4.07, 4.02, 3.97, 3.92, 3.88)


def agreed_shares(newest_first: Sequence[ApplicationRecord], lately: Sequence[Share]) -> list[Share] | None:
    """The shares in as few of these applications as agree that a wheelset stands apart; None if they do not.

    It has to stand apart `lately` as well, in the same direction.
    """
    for count, sure_t in enumerate(SURE_T, AGREEING_APPLICATIONS):
        if len(newest_first) < count:
            break
        fits = [_fit(i, newest_first[:count]) for i in range(len(lately))]
        if any(
            abs(share.value - 1.0) > sure_t * scatter and _stands_apart(share, now, len(fits))
            for (share, scatter), now in zip(fits, lately, strict=True)
        ):
            return [share._replace(value=max(share.value, 0.0)) for share, _ in fits]
    return None


def _fit(i: int, records: Sequence[ApplicationRecord]) -> tuple[Share, float]:
    """Wheelset i's share of the creep of all by least squares, and the standard deviation of that by the scatter.

    A curve shifts creep by as much under any brake: the harder one brakes, the more it says.
    """
    wholes = [mean_creep(record) or 0.0 for record in records]
    own = [record.wheelsets[i] for record in records]
    values = [(one.creep or 0.0) / whole for whole, one in zip(wholes, own, strict=True)]
    stds = [(one.creep_std or 0.0) / whole for whole, one in zip(wholes, own, strict=True)]
    value, std, scatter = _weighted(values, stds, [whole * whole for whole in wholes])
    means_nm = [mean(one.torque_nm or 0.0 for one in record.wheelsets) for record in records]
    by_force = mean((one.torque_nm or 0.0) / mean_nm for one, mean_nm in zip(own, means_nm, strict=True))
    return Share(value, std, by_force), scatter


def _weighted(values: Sequence[float], stds: Sequence[float], weights: Sequence[float]) -> tuple[float, float, float]:
    """The mean of values, its deviation by theirs, and that by their scatter."""
    whole = sum(weights)
    value = sum(map(mul, weights, values)) / whole
    off = sum(weight * (own - value) ** 2 for weight, own in zip(weights, values, strict=True))
    return value, hypot(*map(mul, weights, stds)) / whole, sqrt(off / (len(values) - 1) / whole)


def _stands_apart(share: Share, now: Share, count: int) -> bool:
    """Whether a wheelset bears so much less or more than the others, and than the forces make of it, as it does `now`.

    One of two that bears 30 % less than the other bears but 18 % less than an equal share.
    """
    goes_on = (now.value - 1.0) * (share.value - 1.0) > 0.0 and _off(now.value, 1.0, count) > SURELY_APART
    is_apart = min(_off(share.value, 1.0, count), _off(share.value, share.by_force, count)) > SURELY_APART
    return is_apart and share.off > CLEAR_SIGMAS * share.std and goes_on


def _off(value: float, expected: float, count: int) -> float:
    """By how much a share is off an expected one, in what the others bear; where that is less, in its own."""
    own, expects = _to_others(value, count), _to_others(expected, count)
    return abs(own - expects) if own < 1.0 else abs(1.0 / own - 1.0 / expects)


def _to_others(value: float, count: int) -> float:
    """A share over the mean share of the others."""
    return max(value, LEAST_SHARE) * (count - 1) / max(count - value, LEAST_SHARE)


def lagging_shares(newest_first: Sequence[ApplicationRecord]) -> list[Share] | None:
    """The shares by which one wheelset bears less than the others on a soft contact; None if none surely does.

    What the vehicle's speed errs by is in the creep of all alike. Where it hides how much they creep, it still shows
    that one creeps less than the others.
    """
    stiff = [record for record in newest_first if _is_stiff(record)]
    for count, sure_t in enumerate(SURE_T, AGREEING_APPLICATIONS):
        if len(stiff) < count:
            break
        for i in range(len(stiff[0].wheelsets)):
            lacks, noise_std, scatter = _lack(i, stiff[:count])
            is_sure = lacks > max(sure_t * scatter, CLEAR_SIGMAS * noise_std)
            if is_sure and min(lacks, _lack_in(i, stiff[0])) > LAGS:
                others = len(stiff[0].wheelsets) - 1
                whole = (others + max(1.0 - lacks, 0.0)) / (others + 1)
                own = max(1.0 - lacks, 0.0) / whole
                return [Share(own if k == i else 1.0 / whole, 0.0, 1.0) for k in range(others + 1)]
    return None


def _is_stiff(record: ApplicationRecord) -> bool:
    """Whether adhesion and creep of all are known, enough to tell, and the rail gave far more than they crept for."""
    whole, known = mean_creep(record), [own.adhesion for own in record.wheelsets if own.adhesion is not None]
    if whole is None or len(known) < len(record.wheelsets):
        return False
    return mean(known) > max(SOFT * LEAST_CREEP, STIFF * whole)


def _lack(i: int, records: Sequence[ApplicationRecord]) -> tuple[float, float, float]:
    """By how much of the others' creep wheelset i lags in these, on a soft contact; its deviations as in `_weighted`.

    As in `_fit`, the harder one brakes, the more it says.
    """
    adhesions = [_others_adhesion(record) for record in records]
    stds = [SOFT * (own.wheelsets[i].creep_std or 0.0) / most for own, most in zip(records, adhesions, strict=True)]
    return _weighted([_lack_in(i, record) for record in records], stds, [most * most for most in adhesions])


def _lack_in(i: int, record: ApplicationRecord) -> float:
    """The same in one application; 0 where its pressing force says as much."""
    torques_nm = [own.torque_nm or 0.0 for own in record.wheelsets]
    if torques_nm[i] < BY_ITS_FORCE * median(torques_nm):
        return 0.0
    others = median([own.creep or 0.0 for k, own in enumerate(record.wheelsets) if k != i])
    return SOFT * (others - (record.wheelsets[i].creep or 0.0)) / _others_adhesion(record)


def _others_adhesion(record: ApplicationRecord) -> float:
    """At the most: if the one that lags bears nothing, the others bear what the estimator spreads over all."""
    count = len(record.wheelsets)
    return mean(own.adhesion or 0.0 for own in record.wheelsets) * count / (count - 1)
