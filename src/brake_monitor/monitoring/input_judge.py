"""What is to be thought of each mapped signal, in view of itself and of all the others."""

from collections.abc import Callable, Sequence

from msgspec.structs import replace

from brake_monitor.config import Settings
from brake_monitor.estimate import Estimate
from brake_monitor.monitoring.force_watch import ForceState, ForceWatch
from brake_monitor.monitoring.input_watch import InputWatch
from brake_monitor.monitoring.observation import InputReport, good
from brake_monitor.monitoring.wheel_watch import WheelState, WheelWatch
from brake_monitor.samples import ESSENTIAL, Channel, InputCondition, Quantity, Sample


class InputJudge:
    """Watches the signals one by one, the speeds beside each other, and the forces beside what their brakes do."""

    def __init__(self, settings: Settings, channels: Sequence[Channel]) -> None:
        contact_force_n, friction_nominal = settings.estimator.contact_force_n, settings.estimator.friction_nominal
        is_in_train = settings.estimator.preset == "train"
        self._channels = channels
        self._inputs = InputWatch(channels)
        self._wheels = WheelWatch(settings.vehicle, contact_force_n)
        self._forces = ForceWatch(settings.vehicle, contact_force_n, friction_nominal, is_in_train=is_in_train)

    def see(self, sample: Sample) -> None:
        """Take a sample as it was decoded."""
        self._inputs.see(sample)
        self._wheels.see(sample)

    def judge(
        self, estimate: Estimate, condition: Callable[[Quantity, int], InputCondition]
    ) -> tuple[tuple[InputReport, ...], tuple[WheelState, ...]]:
        """One report per signal and one state per wheelset; `condition` is what the estimator thinks of a signal."""
        alone = tuple(self._alone(channel, estimate.time_s, condition) for channel in self._channels)
        has_speed = good(alone, Quantity.SPEED, 1)[0]
        measured = [has_speed and own for own in good(alone, Quantity.AXLE_SPEED, len(estimate.wheelsets))]
        wheels = self._wheels.judge(estimate, measured)
        speeds_are_good = all(measured) and WheelState.CONTRADICTED not in wheels
        forces = self._forces.judge(estimate, _arriving(alone, len(wheels)), speeds_are_good=speeds_are_good)
        return tuple(self._beside_others(report, wheels, forces) for report in alone), wheels

    def _alone(
        self, channel: Channel, time_s: float, condition: Callable[[Quantity, int], InputCondition]
    ) -> InputReport:
        place = (channel.quantity, channel.wheelset)
        judged = self._inputs.condition(place, time_s, condition(*place))
        return InputReport(*place, channel.message, channel.signal, judged, channel.bus)

    def _beside_others(
        self, report: InputReport, wheels: tuple[WheelState, ...], forces: tuple[ForceState, ...]
    ) -> InputReport:
        condition = report.condition
        if condition is InputCondition.GOOD:
            is_wheel = report.quantity is Quantity.AXLE_SPEED and wheels[report.wheelset] is WheelState.CONTRADICTED
            is_speed = report.quantity is Quantity.SPEED and self._wheels.speed_is_contradicted
            is_force = report.quantity is Quantity.PRESSING_FORCE and forces[report.wheelset] is ForceState.CONTRADICTED
            condition = InputCondition.CONTRADICTED if is_wheel or is_speed or is_force else condition
        elif report.quantity is Quantity.PRESSING_FORCE and condition is InputCondition.FROZEN:
            condition = InputCondition.GOOD if forces[report.wheelset] is ForceState.BORNE_OUT else condition
        return report if condition is report.condition else replace(report, condition=condition)


def disbelieved(inputs: tuple[InputReport, ...]) -> frozenset[tuple[Quantity, int]]:
    """What the estimator is not to believe, and does not know by itself."""
    return frozenset(
        (report.quantity, report.wheelset)
        for report in inputs
        if (report.condition is InputCondition.CONTRADICTED and report.quantity in ESSENTIAL)
        or (report.condition is InputCondition.FROZEN and report.quantity is Quantity.PRESSING_FORCE)
    )


def _arriving(inputs: tuple[InputReport, ...], wheelset_count: int) -> list[bool]:
    """Whether each pressing force arrives, believable by itself or standing still."""
    bad = {
        report.wheelset
        for report in inputs
        if report.quantity is Quantity.PRESSING_FORCE
        and report.condition not in {InputCondition.GOOD, InputCondition.FROZEN}
    }
    return [i not in bad for i in range(wheelset_count)]
