"""What may be wrong with a brake, as mechanics."""

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

    def set(self, time_s: float, wheels: Wheelsets, sound_quality: list[float]) -> None:
        """Let the fault act at `time_s`."""
        acts = time_s >= self.from_s
        for i, sound in enumerate(sound_quality):
            if self.wheelset in (None, i):
                self._set_one(i, time_s, acts, sound, wheels)

    def _set_one(self, i: int, time_s: float, acts: bool, sound: float, wheels: Wheelsets) -> None:
        wheels.inlet[i] = 0.0 if acts and self.isolated else 1.0
        wheels.least_bar[i] = self.residual_bar if acts else 0.0
        wheels.stuck_n[i] = self.stuck_force_n if acts else 0.0
        wheels.rigging[i] = self.rigging if acts else 1.0
        wheels.quality[i] = sound * (self.friction.at(time_s) if acts else 1.0)
