"""What is thought of each mapped signal and of each bus."""

from collections.abc import Iterable, Sequence

from msgspec import Struct

from brake_monitor.samples import ESSENTIAL, Channel, InputCondition, Place, Quantity

GOOD = InputCondition.GOOD


class InputReport(Struct, frozen=True):
    """One mapped signal."""

    channel: Channel
    condition: InputCondition
    losses: int = 0  # how often it was lost since the start

    @property
    def place(self) -> Place:
        """Which quantity of which wheelset it is."""
        return self.channel.place


class BusReport(Struct, frozen=True):
    """One CAN bus."""

    name: str
    silent_s: float  # since its last frame; 0 before the first one had time to come
    error_frames: int  # since the start
    is_off: bool  # the interface says bus-off, or is down
    expected_within_s: float = 0.0  # a frame comes at least so often, by the time-outs of what is mapped


def not_good(inputs: Iterable[InputReport]) -> list[InputReport]:
    """Those that are not: nearly always none, so that asking these is quicker than asking all."""
    return [report for report in inputs if report.condition is not GOOD]


def good(bad: Sequence[InputReport], quantity: Quantity, wheelset_count: int) -> list[bool]:
    """Whether each wheelset's signal of this quantity is good, by those that are not."""
    if not bad:
        return [True] * wheelset_count
    missed = [report.channel.wheelset for report in bad if report.channel.quantity is quantity]
    return [i not in missed for i in range(wheelset_count)]


def all_good(bad: Sequence[InputReport]) -> bool:
    """Whether every signal that the estimate stands on is good, by those that are not."""
    return not bad or not any(report.channel.quantity in ESSENTIAL for report in bad)
