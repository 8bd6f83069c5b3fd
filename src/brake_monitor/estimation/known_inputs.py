"""What acts on the wagon and is told rather than estimated, where it is not told in the ordinary way."""

from brake_monitor.estimation.core import Core
from brake_monitor.samples import Quantity, Sample


class KnownInputs:
    """The inputs of one wagon beyond those that act within a step: sand and place, and what was lost or may be."""

    def __init__(self, core: Core) -> None:
        self._core = core
        self.sanding = False
        self.place_deg: dict[Quantity, float] = {}

    def take(self, channel: int, sample: Sample) -> bool:
        """Take a sample that is no measurement of the state; True when it told a pressing force to be believed."""
        i = sample.wheelset
        match sample.quantity:
            case Quantity.PRESSING_FORCE:
                return self._take_force(i, sample.time_s, max(sample.value, 0.0))
            case Quantity.SANDING:
                self.sanding = sample.value != 0.0
            case Quantity.LATITUDE | Quantity.LONGITUDE:
                self.place_deg[sample.quantity] = sample.value
            case _:
                self._core.take_told(channel, sample.time_s, sample.value)
        return False

    def lose(self, sample: Sample) -> None:
        """Nothing is told any more: what was told last is not so for ever. Pressing forces and load are held.

        A brake that holds its air and a wagon that is not loaded on the way stay as they are; without the forces no
        estimate is valid anyway.
        """
        core, i = self._core, sample.wheelset
        match sample.quantity:
            case Quantity.WHEEL_TORQUE:
                core.wheels[i].torque_is_told &= core.wheels[i].torque.value == 0.0
                core.wheels[i].torque.sample(sample.time_s, 0.0, longest_gap_s=0.0)
            case Quantity.WSP_ACTIVE:
                core.set_flag(i, False)
            case Quantity.SANDING:
                self.sanding = False
            case Quantity.LATITUDE | Quantity.LONGITUDE:
                self.place_deg.pop(sample.quantity, None)
            case Quantity.GRADIENT:
                core.now.gradient = 0.0

    def _take_force(self, i: int, time_s: float, pressing_force_n: float) -> bool:
        believed = self._core.wheels[i].gate.pass_on(time_s, pressing_force_n)
        for then_s, force_n in believed:
            self._core.believe_force(i, then_s, force_n)
        return bool(believed)

    def follow(self, i: int) -> None:
        """The pressing force is told anew: what mu_w,i did meanwhile, the speeds have told."""
        wheel = self._core.wheels[i]
        wheel.end_n = wheel.force.value

    def restart(self, time_s: float) -> None:
        """The next step begins at time_s with the values told last."""
        for wheel in self._core.wheels:
            wheel.force.restart(time_s)
            wheel.torque.restart(time_s)
            wheel.contact.restart(time_s)
