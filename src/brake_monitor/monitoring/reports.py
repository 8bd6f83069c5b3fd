"""What is thought of each mapped signal and of each bus."""

from functools import cached_property

from msgspec import Struct

from brake_monitor.samples import ESSENTIAL, Channel, InputCondition, Measurand, Quantity

GOOD = InputCondition.GOOD


class InputReport(Struct, frozen=True):
    """One mapped signal."""

    channel: Channel
    condition: InputCondition
    losses: int = 0  # how often it was lost since the start

    @property
    def measurand(self) -> Measurand:
        """Which quantity of which wheelset it is."""
        return self.channel.measurand


class InputReports(tuple[InputReport, ...]):
    """All mapped signals. They stay the very same until something changes, so that nothing is worked out twice."""

    @cached_property
    def not_good(self) -> list[InputReport]:
        """Those that are not: nearly always none, so that asking these is quicker than asking all."""
        return [report for report in self if report.condition is not GOOD]

    @cached_property
    def all_good(self) -> bool:
        """Whether every signal that the estimate stands on is good."""
        return not any(report.channel.quantity in ESSENTIAL for report in self.not_good)

    @cached_property
    def gradient_is_known(self) -> bool:
        """Whether a gradient is mapped, and good."""
        conditions = [report.condition for report in self if report.channel.quantity is Quantity.GRADIENT]
        return bool(conditions) and all(condition is GOOD for condition in conditions)

    @cached_property
    def disbelieved(self) -> frozenset[Measurand]:
        """What the estimator is not to believe, and does not know by itself: some of those that are not good."""
        return frozenset(
            [
                report.measurand
                for report in self.not_good
                if report.condition is InputCondition.CONTRADICTED
                or (report.condition is InputCondition.FROZEN and report.channel.quantity is Quantity.PRESSING_FORCE)
            ]
        )

    def are_good(self, quantity: Quantity, wheelset_count: int) -> list[bool]:
        """Whether each wheelset's signal of this quantity is good."""
        if not self.not_good:
            return [True] * wheelset_count
        missed = [report.channel.wheelset for report in self.not_good if report.channel.quantity is quantity]
        return [i not in missed for i in range(wheelset_count)]


class BusReport(Struct, frozen=True):
    """One CAN bus."""

    name: str
    silent_s: float  # since its last frame; 0 before the first one had time to come
    error_frames: int  # since the start
    is_off: bool  # the interface says bus-off, or is down
    expected_within_s: float = 0.0  # a frame comes at least so often, by the time-outs of what is mapped
