"""Brakes that the model does not know of: estimates go on, are sure of themselves, and err.

The rules find such a brake by other traces, and go on seeing the estimates as they are. What is given out says so.
"""

from collections.abc import Collection
from enum import StrEnum

from msgspec.structs import replace

from brake_monitor.estimation.estimate import Estimate, Status


class MisledBy(StrEnum):
    """What misleads the estimates, in the words in which an estimate gives its reasons."""

    UNEVEN = "brakes that press alike differ"  # what one lacks is told of all; the wagon's adhesion is right
    DRAG = "a brake drags unseen"  # what it does is taken for a gradient's
    SILENT = "a brake may press unseen"  # what it does would be taken for the others'
    IDLE = "a brake may not press though its force says so"  # what it does not do is taken for a descent's
    LOCKED = "a wheelset may not turn"  # what it takes from the speed would be taken for the others' brakes


OF_ADHESION = (MisledBy.DRAG, MisledBy.SILENT, MisledBy.IDLE)  # by these the wagon's adhesion errs as well


def qualified(estimate: Estimate, misled_by: Collection[MisledBy]) -> Estimate:
    """The estimate, in which what is misled is no longer called valid."""
    if not misled_by:
        return estimate
    wheelsets = tuple(
        [
            replace(own, friction_status=_doubted(own.friction_status), adhesion_status=_doubted(own.adhesion_status))
            for own in estimate.wheelsets
        ]
    )
    reasons = tuple([reason for reason in OF_ADHESION if reason in misled_by])
    if not reasons or estimate.status is not Status.VALID:
        return replace(estimate, wheelsets=wheelsets)
    return replace(estimate, wheelsets=wheelsets, status=Status.CONVERGING, reasons=reasons)


def _doubted(status: Status) -> Status:
    return Status.CONVERGING if status is Status.VALID else status
