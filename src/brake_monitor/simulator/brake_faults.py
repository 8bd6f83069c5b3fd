"""What may be wrong with a brake, as mechanics."""

from collections.abc import Iterable
from dataclasses import dataclass

from brake_monitor.simulator.physics.motion import Wheelsets
from brake_monitor.simulator.scenarios import Profile

UNCHANGED = Profile(((0.0, 1.0),))


@dataclass(frozen=True, slots=True)
class BrakeFault:
    """A fault of one wheelset's brake, or of all, from `from_s` on."""

    wheelset: int | None = None  # from 0; None: every one
    from_s: float = 0.0
    isolated: bool = False  # no air reaches the cylinder
    residual_bar: float = 0.0  # once filled, the cylinder does not empty below it; the pressure signal shows it
    stuck_force_n: float = 0.0  # once pressed, the pads do not come off below it; the pressure signal does not show it
    rigging: float = 1.0  # share of the cylinder's force that reaches the pads
    friction: Profile = UNCHANGED  # friction over that of sound pads, over time

    def set(self, time_s: float, wheels: Wheelsets) -> None:
        """Let the fault act at `time_s`, beside what others do to the same brake."""
        if time_s < self.from_s:
            return
        for wheel in wheels if self.wheelset is None else (wheels[self.wheelset],):
            wheel.inlet *= 0.0 if self.isolated else 1.0
            wheel.least_bar = max(wheel.least_bar, self.residual_bar)
            wheel.stuck_n = max(wheel.stuck_n, self.stuck_force_n)
            wheel.rigging *= self.rigging
            wheel.friction_factor *= self.friction.at(time_s)


def set_faults(faults: Iterable[BrakeFault], time_s: float, wheels: Wheelsets) -> None:
    """Let faults act at `time_s` on brakes that are sound but for them."""
    for wheel in wheels:
        wheel.inlet, wheel.least_bar, wheel.stuck_n, wheel.rigging, wheel.friction_factor = 1.0, 0.0, 0.0, 1.0, 1.0
    for fault in faults:
        fault.set(time_s, wheels)
