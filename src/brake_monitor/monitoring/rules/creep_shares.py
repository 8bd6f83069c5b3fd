"""Which share of the brake torque each wheelset bears in a brake application, by how far each creeps."""

from statistics import mean
from typing import NamedTuple

from brake_monitor.monitoring.brake_units.application_record import ApplicationRecord, WheelsetRecord

LEAST_CREEP = 4e-4  # on average; curves change rolling radii by as much, so that less says nothing
CLEAR_SIGMAS = 3.0  # of the noise; wheel speeds in coarse steps tell brakes apart only where they differ much
APART = 0.20  # of an equal share
AHEAD = 2e-4  # no brake makes a wheelset run ahead of free rolling: it is, or was, in a curve


class Share(NamedTuple):
    """One wheelset's creep over the mean of all."""

    value: float
    std: float
    by_force: float  # what its pressing force makes of it

    @property
    def off(self) -> float:
        """By how much it is neither an equal share nor what the pressing forces tell already."""
        return min(abs(self.value - 1.0), abs(self.value - self.by_force))

    @property
    def is_apart(self) -> bool:
        """Whether it is so, beyond doubt."""
        return self.off > max(APART, CLEAR_SIGMAS * self.std)


def creep_shares(record: ApplicationRecord) -> list[Share] | None:
    """Each wheelset's; None where creep says nothing."""
    whole = mean_creep(record)
    if whole is None or whole < LEAST_CREEP or any(_runs_ahead(own) for own in record.wheelsets):
        return None
    whole_nm = mean(own.torque_nm or 0.0 for own in record.wheelsets)
    return [
        Share(max(own.creep or 0.0, 0.0) / whole, (own.creep_std or 0.0) / whole, (own.torque_nm or 0.0) / whole_nm)
        for own in record.wheelsets
    ]


def are_known(record: ApplicationRecord, within: float = APART) -> bool:
    """Whether creep tells every share so well; by the default it shows that one brake does a different one."""
    shares = creep_shares(record)
    return shares is not None and all(CLEAR_SIGMAS * share.std <= within for share in shares)


def mean_creep(record: ApplicationRecord) -> float | None:
    """Of all wheelsets; None where that of any is not known, or there is but one."""
    creeps = [own.creep for own in record.wheelsets if own.creep is not None and own.torque_nm]
    return mean(creeps) if len(creeps) >= max(len(record.wheelsets), 2) else None


def _runs_ahead(own: WheelsetRecord) -> bool:
    return own.creep is not None and own.creep < -max(AHEAD, CLEAR_SIGMAS * (own.creep_std or 0.0))
