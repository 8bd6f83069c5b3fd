"""What the rules see: an estimate, and the state of the inputs and buses that it was made from."""

from collections.abc import Iterable, Sequence

from msgspec import Struct

from brake_monitor.estimation.estimate import Estimate
from brake_monitor.monitoring.brakes import NO_BRAKES, Brakes
from brake_monitor.monitoring.wheel_state import WheelState
from brake_monitor.samples import ESSENTIAL, InputCondition, Quantity

GOOD = InputCondition.GOOD
ROLLING = WheelState.ROLLING
OBSERVATION_PERIOD_S = 0.1  # the rules see the wagon as often, whatever rate estimates are given out at


class InputReport(Struct, frozen=True):
    """One mapped signal."""

    quantity: Quantity
    wheelset: int  # from 0, as in `Sample`
    message: str  # as mapped
    signal: str
    condition: InputCondition
    bus: str = ""


class BusReport(Struct, frozen=True):
    """One CAN bus."""

    name: str
    silent_s: float  # since its last frame; 0 before the first one had time to come
    error_frames: int  # since the start
    is_off: bool  # the interface says bus-off, or is down
    expected_within_s: float = 0.0  # a frame comes at least so often, by the time-outs of what is mapped


class Observation:
    """What is known of the wagon at one instant, and what several rules ask of it. Nobody changes it."""

    __slots__ = (
        "all_good",
        "all_roll",
        "brakes",
        "buses",
        "estimate",
        "forces_n",
        "inputs",
        "memory_failure",
        "not_good",
        "time_s",
        "wheels",
    )

    def __init__(
        self,
        estimate: Estimate,
        inputs: tuple[InputReport, ...],
        buses: tuple[BusReport, ...],
        brakes: Brakes = NO_BRAKES,
        wheels: tuple[WheelState, ...] = (),
        *,
        memory_failure: str = "",
    ) -> None:
        """`wheels`: one per wheelset; `memory_failure`: why what is to outlive the program cannot be written."""
        self.estimate = estimate
        self.time_s = estimate.time_s  # by the frames' time
        self.forces_n = [wheelset.pressing_force_n for wheelset in estimate.wheelsets]
        self.inputs = inputs
        self.not_good = not_good(inputs)
        self.all_good = all_good(self.not_good)  # every signal that the estimate stands on is
        self.buses = buses
        self.brakes = brakes
        self.wheels = wheels
        self.all_roll = wheels.count(ROLLING) == len(wheels)
        self.memory_failure = memory_failure


def position(estimate: Estimate) -> dict[str, float | str | None]:
    """The place on earth; empty when it is not known."""
    if estimate.latitude_deg is None or estimate.longitude_deg is None:
        return {}
    return {"latitude_deg": estimate.latitude_deg, "longitude_deg": estimate.longitude_deg}


def not_good(inputs: Iterable[InputReport]) -> list[InputReport]:
    """Those that are not: nearly always none, so that asking these is quicker than asking all."""
    return [report for report in inputs if report.condition is not GOOD]


def good(bad: Sequence[InputReport], quantity: Quantity, wheelset_count: int) -> list[bool]:
    """Whether each wheelset's signal of this quantity is good, by those that are not."""
    if not bad:
        return [True] * wheelset_count
    missed = [report.wheelset for report in bad if report.quantity is quantity]
    return [i not in missed for i in range(wheelset_count)]


def all_good(bad: Sequence[InputReport]) -> bool:
    """Whether every signal that the estimate stands on is good, by those that are not."""
    return not bad or not any(report.quantity in ESSENTIAL for report in bad)
