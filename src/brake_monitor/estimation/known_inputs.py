"""What acts on the wagon and is told rather than estimated, where it is not told in the ordinary way."""

from math import isfinite

from brake_monitor.estimation.core.core import Core
from brake_monitor.samples import InputCondition, Quantity, Sample

RELEASED_N = 1000.0  # what is left of a force then does not matter
STILL_PRESSES = 0.5  # of another brake's force, or its own of lately: a brake with so much has not been released


class KnownInputs:
    """The inputs of one wagon that the core leaves: sand and position, forces to be doubted, and whatever is lost."""

    def __init__(self, core: Core) -> None:
        self._core = core
        self.sanding = False
        self.position_deg: dict[Quantity, float] = {}

    def take(self, channel: int, sample: Sample) -> bool:
        """Take a sample that is no measurement of the state; True when it told a pressing force to be believed."""
        i = sample.wheelset
        match sample.quantity:
            case Quantity.PRESSING_FORCE:
                return self._take_force(i, sample.time_s, max(sample.value, 0.0))
            case Quantity.SANDING:
                self.sanding = sample.value != 0.0
            case Quantity.LATITUDE | Quantity.LONGITUDE:
                if isfinite(sample.value):  # else the position told before is as good as any
                    self.position_deg[sample.quantity] = sample.value
            case _:
                self._core.take_told(channel, sample.time_s, sample.value)
        return False

    def lose(self, sample: Sample) -> None:
        """Take back what a lost signal told last; pressing forces and load are held.

        A brake that holds its air, and a wagon that is not loaded on the way, stay as they are; and without its forces
        no estimate is valid anyway.
        """
        core, i = self._core, sample.wheelset
        match sample.quantity:
            case Quantity.WHEEL_TORQUE:
                core.wheels[i].motor_torque_known &= not core.wheels[i].motor_has_acted
                core.wheels[i].torque.sample(sample.time_s, 0.0, longest_gap_s=0.0)
            case Quantity.WSP_ACTIVE:
                core.set_flag(i, False)
            case Quantity.SANDING:
                self.sanding = False
            case Quantity.LATITUDE | Quantity.LONGITUDE:
                self.position_deg.pop(sample.quantity, None)
            case Quantity.GRADIENT:
                core.now.gradient = 0.0

    def _take_force(self, i: int, time_s: float, pressing_force_n: float) -> bool:
        wheel = self._core.wheels[i]
        if pressing_force_n > wheel.force.value:
            unlikely = self._rises_too_far(i, pressing_force_n)
        else:
            unlikely = self._falls_alone(i, time_s) or self._falls_unnoticed(i)
        believed = wheel.gate.pass_on(time_s, pressing_force_n, wheel.unsettled == 0.0, unlikely)
        for then_s, force_n in believed:
            self._core.believe_force(i, then_s, force_n)
        return bool(believed)

    def _rises_too_far(self, i: int, pressing_force_n: float) -> bool:
        """Whether a brake presses so much more than lately that it cannot just have been filled again."""
        return STILL_PRESSES * pressing_force_n > self._core.wheels[i].force.most_lately

    def _falls_alone(self, i: int, time_s: float) -> bool:
        """Whether another brake presses on about as this one did, by a sensor that is alive.

        A brake whose sensor died is released with the others, however slowly that goes: down to RELEASED_N.
        """
        wheel = self._core.wheels[i]
        least_n = RELEASED_N if wheel.gate.is_dead else STILL_PRESSES * wheel.force.value
        for k, other in enumerate(self._core.wheels):
            presses = other.contact.pressed or wheel.gate.is_dead
            if k != i and presses and other.force.value >= least_n and other.gate.is_alive(time_s):
                return True
        return False

    def _falls_unnoticed(self, i: int) -> bool:
        """Whether a wheelset still uses what its brake asked for before its force fell, by a sensor that was alive."""
        core, wheel = self._core, self._core.wheels[i]
        asked = core.adhesion_demand(i)
        return wheel.gate.fell_alive and core.filter.x[core.adhesion_place + i] >= STILL_PRESSES * asked > 0.0

    def condition(self, sample: Sample) -> InputCondition:
        """What a signal is like by what it told.

        A pressing force that fell as no brake does and stands still ever since is impossible, and a load that is none.
        A force that trembled and does no longer is frozen; a parked wagon's may sleep.
        """
        core = self._core
        if sample.quantity is Quantity.PRESSING_FORCE:
            wheel = core.wheels[sample.wheelset]
            if wheel.gate.is_dead:
                return InputCondition.IMPOSSIBLE
            if wheel.checks.dead.is_dead and (wheel.force_lost or not core.now.near_standstill):
                return InputCondition.FROZEN
        elif sample.quantity is Quantity.LOAD_FORCE and not core.can_weigh(sample.value):
            return InputCondition.IMPOSSIBLE
        return InputCondition.GOOD

    def follow(self, i: int) -> None:
        """Begin the next step at a force that is told again: mu_w,i, told by the speeds, must not follow the jump."""
        wheel = self._core.wheels[i]
        wheel.end_force_n = wheel.force.value
