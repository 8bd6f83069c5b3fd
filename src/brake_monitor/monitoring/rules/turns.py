"""How fast wheelsets turn against each other: the vehicle's speed, and what acts on all of them, has no part in it."""

from collections.abc import Sequence
from math import log

from brake_monitor.estimation.estimate import Estimate

LEAST_SPEED_MPS = 8.0  # below it the speeds' own noise counts too much


def log_turns(now: Estimate) -> tuple[float, ...]:
    """Of each wheelset, ln omega."""
    return tuple([log(max(own.omega_radps, 1.0)) for own in now.wheelsets])


def turns_apart(log_turns: Sequence[float]) -> tuple[float, ...]:
    """Of each wheelset, ln omega less the others' mean."""
    total, others = sum(log_turns), len(log_turns) - 1
    return tuple([own - (total - own) / others for own in log_turns])
