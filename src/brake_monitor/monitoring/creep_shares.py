"""Which wheelset bears how much of the brake torque, by how far each creeps.

Brakes that press alike cannot be told apart by speeds and forces: the estimator spreads over all of them what one of
them does not give. Their wheelsets, however, creep as much as their own brakes ask for.
"""

from collections.abc import Sequence
from statistics import mean

from msgspec.structs import replace

from brake_monitor.monitoring.stops import StopRecord, WheelsetStop

LEAST_CREEP = 4e-4  # on average; less than what curves do to rolling radii says nothing
OFF = 0.15  # of nominal: the wagon's friction is off by more than weather does, so that something is wrong with a brake
CULPRIT, INNOCENT = 0.40, 0.10  # of nominal
SURE_SIGMAS = 1.96
APART = 0.20  # of an equal share
AGREEING_STOPS = 4  # a curve may fake a share in one or two


def told_apart(stops: Sequence[StopRecord], nominal: float) -> StopRecord:
    """The last of these brake applications, friction and torque being shared out by creep where that may be believed.

    Where it was too light for it, by that of the last one that was not. It may be believed when the wagon's friction
    is off and a wheelset stands apart, when sharing it out leaves all wheelsets but one with nominal friction, or when
    the last applications agree that one wheelset stands apart.
    """
    last, lately = stops[-1], [shares for stop in stops if (shares := creep_shares(stop)) is not None]
    if not lately:
        return last
    mean_nm = mean(own.torque_nm or 0.0 for own in last.wheelsets)
    shared = replace(
        last,
        wheelsets=tuple(
            _with_torque(own, mean_nm * share) for own, share in zip(last.wheelsets, lately[-1], strict=True)
        ),
    )
    is_apart = any(abs(share - 1.0) > APART for share in lately[-1])
    believed = (
        (_is_off(last, nominal) and is_apart) or _has_one_culprit(shared, nominal) or _agree(lately[-AGREEING_STOPS:])
    )
    return shared if believed else last


def creep_shares(stop: StopRecord) -> list[float] | None:
    """Each wheelset's creep over the mean of all; None where creep says nothing."""
    creep = [own.creep for own in stop.wheelsets if own.creep is not None and own.torque_nm]
    if len(creep) < max(len(stop.wheelsets), 2) or mean(creep) < LEAST_CREEP:
        return None
    return [max(own, 0.0) / mean(creep) for own in creep]


def _with_torque(own: WheelsetStop, torque_nm: float) -> WheelsetStop:
    if not own.torque_nm:
        return own
    friction = None if own.friction is None else own.friction * torque_nm / own.torque_nm
    return replace(own, torque_nm=torque_nm, friction=friction)


def _is_off(stop: StopRecord, nominal: float) -> bool:
    known = [(own.friction, own.friction_std or 0.0) for own in stop.wheelsets if own.friction is not None]
    if not known:
        return False
    friction, std = mean(friction for friction, _ in known), mean(std for _, std in known)
    return abs(friction - nominal) - SURE_SIGMAS * std > OFF * nominal


def _has_one_culprit(stop: StopRecord, nominal: float) -> bool:
    """Whether one wheelset's friction is far below nominal, and that of all others close to it.

    A curve that makes one wheelset creep less makes others creep more.
    """
    off = sorted(own.friction / nominal - 1.0 for own in stop.wheelsets if own.friction is not None)
    return len(off) == len(stop.wheelsets) and off[0] < -CULPRIT and all(abs(other) < INNOCENT for other in off[1:])


def _agree(shares: Sequence[Sequence[float]]) -> bool:
    """Whether in all of these applications the same wheelset stands apart in the same direction."""
    if len(shares) < AGREEING_STOPS:
        return False
    return any(min(of_one) > 1.0 + APART or max(of_one) < 1.0 - APART for of_one in zip(*shares, strict=True))
