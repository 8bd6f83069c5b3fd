"""Brakes that press alike, told apart by how far their wheelsets creep, where that may be believed.

Speeds and forces cannot tell them apart: the estimator spreads over all of them what one of them fails to give. Their
wheelsets, however, creep as much as their own brakes ask for.
"""

from collections.abc import Sequence
from math import inf
from statistics import mean

from msgspec.structs import replace

from brake_monitor.estimation.estimate import INTERVAL_SIGMAS
from brake_monitor.monitoring.brake_units.application_record import ApplicationRecord, WheelsetRecord
from brake_monitor.monitoring.rules.agreed_shares import agreed_shares, lagging_shares
from brake_monitor.monitoring.rules.creep_shares import Share, are_known, creep_shares, mean_creep

OFF = 0.15  # of nominal: more than weather changes friction, so that something is wrong with a brake
CULPRIT = 0.40  # of nominal
STEEP = 1.5  # times the creep that others show under the same torque: towards the peak that grows faster than adhesion
ELSEWHERE_S = 60.0  # one application after another is no longer in the same curve, nor told against the same


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
        agreed = agreed_shares(_in_different_places(proportional), lately)
    agreed = agreed or lagging_shares(_in_different_places(applications))
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
    known = sorted(compliance for record, compliance in pairs if compliance and are_known(record, 1.0))
    if not known:
        return list(applications)
    most = STEEP * known[len(known) // 4]
    pairs = zip(applications, compliances, strict=True)
    return [record for record, compliance in pairs if compliance is not None and compliance <= most]


def _compliance(record: ApplicationRecord) -> float | None:
    """Creep over the torque that makes it, 1/Nm; None where either is not known."""
    whole = mean_creep(record)
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
    """Whether what stood apart before shows lately at least by half of it."""
    pairs = zip(lately, before, strict=True)
    return all((now.value - 1.0) / (then.value - 1.0) > 0.5 for now, then in pairs if then.is_apart)


def _in_different_places(applications: Sequence[ApplicationRecord]) -> list[ApplicationRecord]:
    """The last application in which creep was known, and earlier ones at other places, the newest first.

    Light ones are among them, and those in which a curve shows: they tell how much curves do on this line.
    """
    found: list[ApplicationRecord] = []
    before_s = inf
    for record in reversed(applications):
        if mean_creep(record) and record.start_time_s <= before_s - ELSEWHERE_S:  # of none at all there is no share
            found.append(record)
            before_s = record.start_time_s
    return found


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
