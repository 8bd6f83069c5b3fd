"""What is to be thought of each mapped signal by itself."""

from collections.abc import Callable, Sequence

from msgspec.structs import replace

from brake_monitor.monitoring.inputs.refusals import Refusals
from brake_monitor.monitoring.inputs.wheel_watch import WheelWatch
from brake_monitor.monitoring.reports import InputReport, InputReports
from brake_monitor.samples import Channel, InputCondition, Measurand, Quantity

AWAITED, LOST, IMPOSSIBLE = InputCondition.AWAITED, InputCondition.LOST, InputCondition.IMPOSSIBLE
SPEED, AXLE_SPEED, PRESSING_FORCE = Quantity.SPEED, Quantity.AXLE_SPEED, Quantity.PRESSING_FORCE


class LoneInputs:
    """Keeps the reports of all signals, and for each wheelset what of it is good."""

    def __init__(self, channels: Sequence[Channel], refusals: Refusals, wheels: WheelWatch) -> None:
        """`refusals` and `wheels` know how often signals were lost."""
        self._refusals = refusals
        self._wheels = wheels
        self._count = len(wheels.wheels)
        self._changes = -1  # as `judge` was told last
        self.reports = InputReports(InputReport(channel, AWAITED) for channel in channels)
        self.measured: list[bool] = []  # whether of each wheelset are good: its own speed and the vehicle's ...
        self.arriving: list[bool] = []  # ... its pressing force
        self.told: list[bool] = []  # ... all of these
        self.impossible: list[int] = []  # whose pressing forces said what no brake does

    def judge(self, time_s: float, condition: Callable[[Measurand], InputCondition], changes: int) -> None:
        """Bring them up to date; `condition` is what the estimator thinks of a signal.

        It thinks the same as long as its `changes` are as many.
        """
        changes += self._wheels.drops
        if not self.reports.not_good and changes == self._changes:
            return
        self._changes = changes
        self.reports = reports = InputReports(self._report(before, time_s, condition) for before in self.reports)
        (has_speed,) = reports.are_good(SPEED, 1)
        self.measured = [has_speed and own for own in reports.are_good(AXLE_SPEED, self._count)]
        self.arriving = reports.are_good(PRESSING_FORCE, self._count)
        self.told = [speed and force for speed, force in zip(self.measured, self.arriving, strict=True)]
        self.impossible = [
            report.channel.wheelset
            for report in reports.not_good
            if report.channel.quantity is PRESSING_FORCE and report.condition is IMPOSSIBLE
        ]

    def _report(
        self, before: InputReport, time_s: float, condition: Callable[[Measurand], InputCondition]
    ) -> InputReport:
        """That of one signal, the very same as before in most cases."""
        now = condition(before.measurand)
        if now is LOST:
            now = self._refusals.why_lost(before.measurand, time_s)
        losses = self._refusals.losses[before.measurand]
        if before.channel.quantity is AXLE_SPEED:
            losses += self._wheels.wheels[before.channel.wheelset].drops
        is_same = now is before.condition and losses == before.losses
        return before if is_same else replace(before, condition=now, losses=losses)
