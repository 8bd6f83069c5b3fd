"""What the rules see: an estimate, and the state of the inputs and buses that it was made from."""

from collections.abc import Sequence

from msgspec import Struct

from brake_monitor.estimate import Estimate
from brake_monitor.monitoring.brakes import NO_BRAKES, Brakes
from brake_monitor.monitoring.wheel_watch import WheelState
from brake_monitor.samples import ESSENTIAL, InputCondition, Quantity

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


class Observation(Struct, frozen=True):
    """What is known of the wagon at one instant."""

    estimate: Estimate
    inputs: tuple[InputReport, ...]
    buses: tuple[BusReport, ...]
    brakes: Brakes = NO_BRAKES
    wheels: tuple[WheelState, ...] = ()  # one per wheelset
    memory_failure: str = ""  # why what is to outlive the program cannot be written; empty when it can

    @property
    def time_s(self) -> float:
        """When, by the frames' time."""
        return self.estimate.time_s


def position(estimate: Estimate) -> dict[str, float | str | None]:
    """The place on earth; empty when it is not known."""
    if estimate.latitude_deg is None or estimate.longitude_deg is None:
        return {}
    return {"latitude_deg": estimate.latitude_deg, "longitude_deg": estimate.longitude_deg}


def good(inputs: Sequence[InputReport], quantity: Quantity, wheelset_count: int) -> list[bool]:
    """Whether each wheelset's signal of this quantity is good; one that is not mapped is not missed."""
    bad = {
        report.wheelset
        for report in inputs
        if report.condition is not InputCondition.GOOD and report.quantity is quantity
    }
    return [i not in bad for i in range(wheelset_count)]


def all_good(inputs: Sequence[InputReport]) -> bool:
    """Whether every signal that the estimate stands on is good."""
    return all(report.condition is InputCondition.GOOD or report.quantity not in ESSENTIAL for report in inputs)
