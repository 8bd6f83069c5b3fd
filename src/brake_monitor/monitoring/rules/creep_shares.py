"""Which wheelset bears how much of the brake torque, by how far each creeps.

Brakes that press alike cannot be told apart by speeds and forces: the estimator spreads over all of them what one of
them fails to give. Their wheelsets, however, creep as much as their own brakes ask for.
"""

from collections.abc import Sequence
from math import inf, sqrt
from statistics import mean
from typing import NamedTuple

from msgspec.structs import replace

from brake_monitor.monitoring.brake_units.application_record import ApplicationRecord, WheelsetRecord

LEAST_CREEP = 4e-4  # on average; curves change rolling radii by as much, so that less says nothing
CLEAR_SIGMAS = 3.0  # of the noise; wheel speeds in coarse steps tell brakes apart only where they differ much
OFF = 0.15  # of nominal: more than weather changes friction, so that something is wrong with a brake
CULPRIT = 0.40  # of nominal
SURE_SIGMAS = 1.96
APART = 0.20  # of an equal share
AHEAD = 2e-4  # no brake makes a wheelset run ahead of free rolling: it is, or was, in a curve
AGREEING_APPLICATIONS = 4  # in one or two a curve may make a share look unequal
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
    friction is off and a wheelset stands apart, when sharing it out leaves all wheelsets but one with nominal friction,
    or when the last applications, each elsewhere, agree that one wheelset stands apart.
    """
    last = applications[-1]
    telling = [(record, shares) for record in applications if (shares := creep_shares(record)) is not None]
    if not telling:
        return last
    lately = telling[-1][1]
    mean_nm = mean(own.torque_nm or 0.0 for own in last.wheelsets)
    shared = replace(
        last,
        wheelsets=tuple(
            _with_torque(own, mean_nm * share.value) for own, share in zip(last.wheelsets, lately, strict=True)
        ),
    )
    is_apart = any(share.is_apart for share in lately)
    is_believed_alone = is_apart and (_is_off(last, nominal) or _has_one_culprit(shared, nominal))
    believed = is_believed_alone or _agree(_in_different_places(telling)[:AGREEING_APPLICATIONS])
    return shared if believed else last


def is_set_apart(i: int, applications: Sequence[ApplicationRecord]) -> bool:
    """Whether, by the last creep that says anything, wheelset i does not bear the same as the others.

    That is not always believed, as a curve may cause it; but then it is not known to be equal, either.
    """
    telling = [shares for record in applications if (shares := creep_shares(record)) is not None]
    return bool(telling) and telling[-1][i].is_apart


def can_tell_apart(record: ApplicationRecord) -> bool:
    """Whether creep would have shown that one brake does a different share of the work."""
    shares = creep_shares(record)
    return shares is not None and all(CLEAR_SIGMAS * share.std <= APART for share in shares)


def creep_shares(record: ApplicationRecord) -> list[Share] | None:
    """Each wheelset's; None where creep says nothing."""
    told = [
        (own.creep, own.creep_std or 0.0, own.torque_nm)
        for own in record.wheelsets
        if own.creep is not None and own.torque_nm
    ]
    if len(told) < max(len(record.wheelsets), 2):
        return None
    whole, whole_nm = mean(creep for creep, _, _ in told), mean(torque_nm for _, _, torque_nm in told)
    if whole < LEAST_CREEP or any(creep < -max(AHEAD, CLEAR_SIGMAS * std) for creep, std, _ in told):
        return None
    return [Share(max(creep, 0.0) / whole, std / whole, torque_nm / whole_nm) for creep, std, torque_nm in told]


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
    return abs(friction - nominal) - SURE_SIGMAS * std > OFF * nominal


def _has_one_culprit(record: ApplicationRecord, nominal: float) -> bool:
    """Whether one wheelset's friction is far below nominal, and that of all others close to it.

    A curve that makes one wheelset creep less makes others creep more.
    """
    off = sorted(own.friction / nominal - 1.0 for own in record.wheelsets if own.friction is not None)
    return len(off) == len(record.wheelsets) and off[0] < -CULPRIT and all(abs(other) < OFF for other in off[1:])


def _in_different_places(telling: Sequence[tuple[ApplicationRecord, list[Share]]]) -> list[list[Share]]:
    """The shares in the last application, and in earlier ones at other places, the newest first."""
    found: list[list[Share]] = []
    before_s = inf
    for record, shares in reversed(telling):
        if record.start_time_s <= before_s - ELSEWHERE_S:
            found.append(shares)
            before_s = record.start_time_s
    return found


def _agree(shares: Sequence[Sequence[Share]]) -> bool:
    """Whether in all of these applications the same wheelset stands apart in the same direction, and so their mean."""
    if len(shares) < AGREEING_APPLICATIONS:
        return False
    return any(_stands_apart(of_one) for of_one in zip(*shares, strict=True))


def _stands_apart(of_one: Sequence[Share]) -> bool:
    values = [share.value for share in of_one]
    std = sqrt(sum(share.std**2 for share in of_one)) / len(of_one)
    together = Share(mean(values), std, mean(share.by_force for share in of_one))
    return together.is_apart and (min(values) > 1.0 + APART or max(values) < 1.0 - APART)
