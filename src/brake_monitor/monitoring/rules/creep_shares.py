"""Which wheelset bears how much of the brake torque, by how far each creeps.

Brakes that press alike cannot be told apart by speeds and forces: the estimator spreads over all of them what one of
them fails to give. Their wheelsets, however, creep as much as their own brakes ask for.
"""

from collections.abc import Sequence
from math import hypot, inf, sqrt
from statistics import mean, median
from typing import NamedTuple

from msgspec.structs import replace

from brake_monitor.estimation.estimate import INTERVAL_SIGMAS
from brake_monitor.monitoring.brake_units.application_record import ApplicationRecord, WheelsetRecord
from brake_monitor.monitoring.contact_stiffness import SOFT

LEAST_CREEP = 4e-4  # on average; curves change rolling radii by as much, so that less says nothing
ALIKE_SIGMAS = 2.0  # of the noise
CLEAR_SIGMAS = 3.0  # ...; wheel speeds in coarse steps tell brakes apart only where they differ much
OFF = 0.15  # of nominal: more than weather changes friction, so that something is wrong with a brake
CULPRIT = 0.40  # of nominal
LEAST_SHARE = 1e-6  # none, or all that is borne
APART = 0.20  # of an equal share
SURELY_APART = 0.28  # of what the others bear, time and again: 0.20 may be its load, its profile, or a better rail
STEEP = 1.5  # times the creep that others show under the same torque: towards the peak that grows faster than adhesion
AHEAD = 2e-4  # no brake makes a wheelset run ahead of free rolling: it is, or was, in a curve
LAGS = 0.20  # of the others' creep on a soft contact: more than what unlike wheelsets creep apart there
STIFF = 60.0  # adhesion over creep: below that it may be the rail that gives no more
BY_ITS_FORCE = 0.9  # a share that is less by its pressing force is that force's
AGREEING_APPLICATIONS = 4  # at least: in one or two a curve may make a share look unequal
# Student's t by which a share in 4, 5, … applications is sure to 99.9 %: nobody knows how much curves do, and every
# wheelset is looked at after every application.
SURE_T = (12.92, 8.61, 6.87, 5.96, 5.41, 5.04, 4.78, 4.59, 4.44, 4.32, 4.22, 4.14, 4.07, 4.02, 3.97, 3.92, 3.88)
ELSEWHERE_S = 60.0  # one application after another is no longer in the same curve, nor told against the same


class Share(NamedTuple):
    """One wheelset's creep over the mean of all."""

    value: float
    std: float
    by_force: float  # what its pressing force makes of it

    @property
    def is_apart(self) -> bool:
        """Whether it is neither an equal share nor what the pressing forces tell already, beyond doubt."""
        off = min(abs(self.value - 1.0), abs(self.value - self.by_force))
        return off > max(APART, CLEAR_SIGMAS * self.std)


def told_apart(applications: Sequence[ApplicationRecord], nominal: float) -> ApplicationRecord:
    """The last of these brake applications, with friction and torque shared out by creep where that may be believed.

    Where it was too light to show creep, the last one that did show it counts. Creep may be believed when the wagon's
    friction is off and a wheelset stands apart, or when sharing it out leaves all wheelsets but one with nominal
    friction. Or the last applications, each elsewhere, agree that one wheelset stands apart, or that it lags behind the
    others by more than it could if it bore as much; then all of them count.
    """
    last, proportional = applications[-1], _with_proportional_creep(applications)
    lately = _last_shares(proportional)
    agreed = None
    if lately is not None:
        shared = _shared_out(last, lately)
        is_apart = any(share.is_apart for share in lately)
        if is_apart and (_is_off(last, nominal) or _has_one_culprit(shared, nominal)):
            return shared
        agreed = _agreed(_in_different_places(proportional), lately)
    agreed = agreed or _lagging(_in_different_places(applications))
    return last if agreed is None else _shared_out(last, agreed)


def is_set_apart(i: int, applications: Sequence[ApplicationRecord]) -> bool:
    """Whether, by the last creep that says anything, wheelset i does not bear the same as the others.

    That is not always believed, as a curve may cause it; but then it is not known to be equal, either.
    """
    lately = _last_shares(applications)
    return lately is not None and lately[i].is_apart


def _with_proportional_creep(applications: Sequence[ApplicationRecord]) -> list[ApplicationRecord]:
    """Those in which creep went with torque as it did at best in the others.

    Towards the peak of what its own rail gives under its own load a wheelset creeps far more than its torque tells.
    """
    compliances = [_compliance(record) for record in applications]
    pairs = zip(applications, compliances, strict=True)
    known = sorted(compliance for record, compliance in pairs if compliance and _is_known(record))
    if not known:
        return list(applications)
    most = STEEP * known[len(known) // 4]
    pairs = zip(applications, compliances, strict=True)
    return [record for record, compliance in pairs if compliance is not None and compliance <= most]


def _is_known(record: ApplicationRecord) -> bool:
    """Whether what all creep is no noise."""
    shares = creep_shares(record)
    return shares is not None and all(CLEAR_SIGMAS * share.std <= 1.0 for share in shares)


def _compliance(record: ApplicationRecord) -> float | None:
    """Creep over the torque that makes it, 1/Nm; None where either is not known."""
    whole = _mean_creep(record)
    return None if whole is None else whole / mean(own.torque_nm or 0.0 for own in record.wheelsets)


def _last_shares(applications: Sequence[ApplicationRecord]) -> list[Share] | None:
    """By the last creep that says anything; where it goes the way of what stood apart before, less clearly, by that."""
    lately = None
    for record in reversed(applications):
        shares = creep_shares(record)
        if shares is None:
            continue
        lately = lately or shares
        if any(share.is_apart for share in shares):
            return shares if _goes_on(lately, shares) else lately
    return lately


def _goes_on(lately: Sequence[Share], before: Sequence[Share]) -> bool:
    """Whether what was lately is as before, for all that its noise lets one see, and shows at least half of it."""
    pairs = list(zip(lately, before, strict=True))
    is_alike = all(abs(now.value - then.value) <= ALIKE_SIGMAS * hypot(now.std, then.std) for now, then in pairs)
    return is_alike and all((now.value - 1.0) / (then.value - 1.0) > 0.5 for now, then in pairs if then.is_apart)


def can_tell_apart(record: ApplicationRecord) -> bool:
    """Whether creep would have shown that one brake does a different share of the work."""
    shares = creep_shares(record)
    return shares is not None and all(CLEAR_SIGMAS * share.std <= APART for share in shares)


def creep_shares(record: ApplicationRecord) -> list[Share] | None:
    """Each wheelset's; None where creep says nothing."""
    whole = _mean_creep(record)
    if whole is None or whole < LEAST_CREEP or any(_runs_ahead(own) for own in record.wheelsets):
        return None
    whole_nm = mean(own.torque_nm or 0.0 for own in record.wheelsets)
    return [
        Share(max(own.creep or 0.0, 0.0) / whole, (own.creep_std or 0.0) / whole, (own.torque_nm or 0.0) / whole_nm)
        for own in record.wheelsets
    ]


def _mean_creep(record: ApplicationRecord) -> float | None:
    """Of all wheelsets; None where that of any is not known, or there is but one."""
    creeps = [own.creep for own in record.wheelsets if own.creep is not None and own.torque_nm]
    return mean(creeps) if len(creeps) >= max(len(record.wheelsets), 2) else None


def _runs_ahead(own: WheelsetRecord) -> bool:
    return own.creep is not None and own.creep < -max(AHEAD, CLEAR_SIGMAS * (own.creep_std or 0.0))


def _shared_out(record: ApplicationRecord, shares: Sequence[Share]) -> ApplicationRecord:
    """The torque of all whose torque is known, shared out like this."""
    known_nm = [own.torque_nm for own in record.wheelsets if own.torque_nm is not None]
    mean_nm = mean(known_nm) if known_nm else 0.0
    own = [_with_torque(one, mean_nm * share.value) for one, share in zip(record.wheelsets, shares, strict=True)]
    return replace(record, wheelsets=tuple(own))


def _with_torque(own: WheelsetRecord, torque_nm: float) -> WheelsetRecord:
    if not own.torque_nm:
        return own
    friction = None if own.friction is None else own.friction * torque_nm / own.torque_nm
    return replace(own, torque_nm=torque_nm, friction=friction)


def _is_off(record: ApplicationRecord, nominal: float) -> bool:
    known = [(own.friction, own.friction_std or 0.0) for own in record.wheelsets if own.friction is not None]
    if not known:
        return False
    friction, std = mean(friction for friction, _ in known), mean(std for _, std in known)
    return abs(friction - nominal) - INTERVAL_SIGMAS * std > OFF * nominal


def _has_one_culprit(record: ApplicationRecord, nominal: float) -> bool:
    """Whether one wheelset's friction is far below nominal, and that of all others close to it.

    A curve that makes one wheelset creep less makes others creep more.
    """
    off = sorted(own.friction / nominal - 1.0 for own in record.wheelsets if own.friction is not None)
    return len(off) == len(record.wheelsets) and off[0] < -CULPRIT and all(abs(other) < OFF for other in off[1:])


def _in_different_places(applications: Sequence[ApplicationRecord]) -> list[ApplicationRecord]:
    """The last application in which creep was known, and earlier ones at other places, the newest first.

    Light ones are among them, and those in which a curve shows: they tell how much curves do on this line.
    """
    found: list[ApplicationRecord] = []
    before_s = inf
    for record in reversed(applications):
        if _mean_creep(record) and record.start_time_s <= before_s - ELSEWHERE_S:  # of none at all there is no share
            found.append(record)
            before_s = record.start_time_s
    return found


def _agreed(newest_first: Sequence[ApplicationRecord], lately: Sequence[Share]) -> list[Share] | None:
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


def _lagging(newest_first: Sequence[ApplicationRecord]) -> list[Share] | None:
    """The shares by which one wheelset bears less than the others on a soft contact; None if none surely does.

    What the vehicle's speed errs by is in the creep of all alike. Where it hides how much they creep, it still shows
    that one creeps less than the others.
    """
    stiff = [record for record in newest_first if _is_stiff(record)]
    for count, sure_t in enumerate(SURE_T, AGREEING_APPLICATIONS):
        if len(stiff) < count:
            break
        for i in range(len(stiff[0].wheelsets)):
            lacks, scatter, noise_std = _lack(i, stiff[:count])
            is_sure = lacks > max(sure_t * scatter, CLEAR_SIGMAS * noise_std)
            if is_sure and min(lacks, _lack_in(i, stiff[0])) > LAGS:
                others = len(stiff[0].wheelsets) - 1
                whole = (others + max(1.0 - lacks, 0.0)) / (others + 1)
                own = max(1.0 - lacks, 0.0) / whole
                return [Share(own if k == i else 1.0 / whole, 0.0, 1.0) for k in range(others + 1)]
    return None


def _is_stiff(record: ApplicationRecord) -> bool:
    """Whether adhesion and creep of all are known, enough to tell, and the rail gave far more than they crept for."""
    whole, known = _mean_creep(record), [own.adhesion for own in record.wheelsets if own.adhesion is not None]
    if whole is None or len(known) < len(record.wheelsets):
        return False
    return mean(known) > max(SOFT * LEAST_CREEP, STIFF * whole)


def _lack(i: int, records: Sequence[ApplicationRecord]) -> tuple[float, float, float]:
    """By how much of the others' creep wheelset i lags in these, on a soft contact; its scatter and its noise.

    As in `_fit`, the harder one brakes, the more it says.
    """
    lacks, weights = [_lack_in(i, record) for record in records], [_others_adhesion(record) ** 2 for record in records]
    whole = sum(weights)
    value = sum(weight * lack for weight, lack in zip(weights, lacks, strict=True)) / whole
    off = sum(weight * (lack - value) ** 2 for weight, lack in zip(weights, lacks, strict=True))
    noise = sum(
        weight * (SOFT * (one.wheelsets[i].creep_std or 0.0)) ** 2 for weight, one in zip(weights, records, strict=True)
    )
    return value, sqrt(off / (len(records) - 1) / whole), sqrt(noise) / whole


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


def _fit(i: int, records: Sequence[ApplicationRecord]) -> tuple[Share, float]:
    """Wheelset i's share of the creep of all by least squares, and the standard deviation of that by the scatter.

    A curve shifts creep by as much under any brake: the harder one brakes, the more it says.
    """
    wholes = [_mean_creep(record) or 0.0 for record in records]
    own = [record.wheelsets[i] for record in records]
    squares = sum(whole * whole for whole in wholes)
    value = sum(whole * (one.creep or 0.0) for whole, one in zip(wholes, own, strict=True)) / squares
    off = sum(((one.creep or 0.0) - value * whole) ** 2 for whole, one in zip(wholes, own, strict=True))
    noise = sum((whole * (one.creep_std or 0.0)) ** 2 for whole, one in zip(wholes, own, strict=True))
    means_nm = [mean(one.torque_nm or 0.0 for one in record.wheelsets) for record in records]
    by_force = mean((one.torque_nm or 0.0) / mean_nm for one, mean_nm in zip(own, means_nm, strict=True))
    return Share(value, sqrt(noise) / squares, by_force), sqrt(off / (len(records) - 1) / squares)


def _stands_apart(share: Share, now: Share, count: int) -> bool:
    """Whether a wheelset bears so much less or more than the others, and than the forces make of it, as it does `now`.

    One of two that bears 30 % less than the other bears but 18 % less than an equal share.
    """
    off = min(abs(share.value - 1.0), abs(share.value - share.by_force))
    goes_on = (now.value - 1.0) * (share.value - 1.0) > 0.0 and _off(now.value, 1.0, count) > SURELY_APART
    is_apart = min(_off(share.value, 1.0, count), _off(share.value, share.by_force, count)) > SURELY_APART
    return is_apart and off > CLEAR_SIGMAS * share.std and goes_on


def _off(value: float, expected: float, count: int) -> float:
    """By how much a share is off an expected one, in what the others bear; where that is less, in its own."""
    own, expects = _to_others(value, count), _to_others(expected, count)
    return abs(own - expects) if own < 1.0 else abs(1.0 / own - 1.0 / expects)


def _to_others(value: float, count: int) -> float:
    """A share over the mean share of the others."""
    return max(value, LEAST_SHARE) * (count - 1) / max(count - value, LEAST_SHARE)
