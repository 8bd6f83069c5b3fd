"""Wheel-slide protection: one controller per wagon, sampled, working only from the wheel speeds it measures."""

from collections import deque
from dataclasses import dataclass, field
from enum import Enum, auto

from brake_monitor.simulator.physics.pneumatics import Valve

SAMPLE_S = 0.01
SWITCH_OFF_MPS = 4.0 / 3.6
ACCELERATION_WINDOW = 6  # samples
TRIP_DECELERATION_MPS2 = 2.5
TRIP_SLIP = 0.16
LEAST_TRIP_SLIP = 0.06
RECOVERED_SLIP = 0.04
FALLING_BACK_MPS2 = 1.0
RECOVERING_MPS2 = 1.0
STRONG_RECOVERY_MPS2 = 4.0
SETTLED_MPS2 = 0.3
EMPTY_AFTER_S = 0.5  # of dumping; then no brake holds the wheelset back
RELEASE_AFTER_S = 3.0  # of sliding together, one wheelset is let go to find the true speed again
MAX_HOLD_S = 0.6
FIRST_FILL_S = 0.12
STEP_FILL_S = 0.05
STEP_HOLD_S = 0.12
STEPS_UNTIL_FREE_S = 2.5
FREE_REFERENCE_FALL_MPS2 = 1.6
SLIDING_REFERENCE_FALL_MPS2 = (0.15, 1.0)


class Phase(Enum):
    """What the controller does with one wheelset."""

    FREE = auto()
    DUMP = auto()
    HOLD = auto()
    STEP = auto()
    RELEASE = auto()


@dataclass(slots=True)
class _Axle:
    """Controller state of one wheelset."""

    phase: Phase = Phase.FREE
    phase_s: float = 0.0
    speeds: deque[float] = field(default_factory=lambda: deque(maxlen=ACCELERATION_WINDOW))

    def enter(self, phase: Phase) -> None:
        self.phase, self.phase_s = phase, 0.0

    def acceleration_mps2(self) -> float:
        if len(self.speeds) < 2:
            return 0.0
        return (self.speeds[-1] - self.speeds[0]) / (SAMPLE_S * (len(self.speeds) - 1))

    def runs_free(self) -> bool:
        """Its brake is empty and it no longer accelerates: it rolls at the wagon's speed."""
        emptied = self.phase in (Phase.DUMP, Phase.RELEASE) and self.phase_s > EMPTY_AFTER_S
        return emptied and abs(self.acceleration_mps2()) < SETTLED_MPS2

    def slides(self, slip: float) -> bool:
        """It lags far behind, or a little and falls back fast."""
        return slip > TRIP_SLIP or (slip > LEAST_TRIP_SLIP and self.acceleration_mps2() < -TRIP_DECELERATION_MPS2)

    def decide(self, slip: float) -> None:
        if self.phase in (Phase.FREE, Phase.STEP):
            if self.slides(slip):
                self.enter(Phase.DUMP)
            elif self.phase is Phase.STEP and self.phase_s > STEPS_UNTIL_FREE_S:
                self.enter(Phase.FREE)
        elif self.runs_free():
            self.enter(Phase.STEP)
        elif self.phase is Phase.DUMP:
            if slip < RECOVERED_SLIP or self.acceleration_mps2() > RECOVERING_MPS2:
                self.enter(Phase.HOLD)
        elif self.phase is Phase.HOLD:
            self._end_hold(slip, self.acceleration_mps2())

    def _end_hold(self, slip: float, acceleration: float) -> None:
        if slip < RECOVERED_SLIP or (acceleration > STRONG_RECOVERY_MPS2 and slip < TRIP_SLIP):
            self.enter(Phase.STEP)
        elif acceleration < -FALLING_BACK_MPS2 or (self.phase_s > MAX_HOLD_S and acceleration < RECOVERING_MPS2):
            self.enter(Phase.DUMP)

    def valve(self) -> Valve:
        if self.phase in (Phase.DUMP, Phase.RELEASE):
            return Valve.DUMP
        if self.phase is Phase.HOLD:
            return Valve.HOLD
        if self.phase is Phase.STEP and self.phase_s > FIRST_FILL_S:
            since_fill_s = (self.phase_s - FIRST_FILL_S) % (STEP_HOLD_S + STEP_FILL_S)
            return Valve.HOLD if since_fill_s < STEP_HOLD_S else Valve.FILL
        return Valve.FILL


class WheelSlideProtection:
    """Reads all wheel speeds, keeps its own reference speed, commands one valve per wheelset."""

    def __init__(self, wheelset_count: int) -> None:
        self._axles = [_Axle() for _ in range(wheelset_count)]
        self._reference_mps = 0.0
        self._slide_fall_mps2 = 0.4  # how fast the reference falls while every wheelset slides; learned
        self._sighted_mps = 0.0
        self._since_sighting_s = 0.0

    def active(self, wheelset: int) -> bool:
        """Whether the controller now takes pressure from this wheelset or rations it."""
        return self._axles[wheelset].phase is not Phase.FREE

    def step(self, wheel_speeds_mps: list[float]) -> list[Valve]:
        """One sampling interval: measured circumferential speeds in, valve commands out."""
        for axle, speed in zip(self._axles, wheel_speeds_mps, strict=True):
            axle.speeds.append(speed)
            axle.phase_s += SAMPLE_S
        self._update_reference(max(wheel_speeds_mps))
        for axle, speed in zip(self._axles, wheel_speeds_mps, strict=True):
            if self._reference_mps < SWITCH_OFF_MPS:
                axle.enter(Phase.FREE)
            else:
                axle.decide((self._reference_mps - speed) / self._reference_mps)
        return [axle.valve() for axle in self._axles]

    def _update_reference(self, fastest_mps: float) -> None:
        """Follow the fastest wheel; while all slide, fall as fast as between the last two true sightings."""
        everyone_slides = all(axle.phase is not Phase.FREE for axle in self._axles)
        self._since_sighting_s += SAMPLE_S
        fall = self._slide_fall_mps2 if everyone_slides else FREE_REFERENCE_FALL_MPS2
        self._reference_mps = max(self._reference_mps - fall * SAMPLE_S, fastest_mps)
        if not everyone_slides:
            self._sight(fastest_mps)
        elif any(axle.runs_free() for axle in self._axles):
            self._learn_fall(fastest_mps)
            self._reference_mps = fastest_mps
            self._sight(fastest_mps)
        elif self._since_sighting_s > RELEASE_AFTER_S and not self._releasing():
            max(self._axles, key=lambda axle: axle.speeds[-1]).enter(Phase.RELEASE)

    def _sight(self, speed_mps: float) -> None:
        self._sighted_mps, self._since_sighting_s = speed_mps, 0.0

    def _learn_fall(self, sighted_mps: float) -> None:
        if self._since_sighting_s > SAMPLE_S:
            low, high = SLIDING_REFERENCE_FALL_MPS2
            seen = (self._sighted_mps - sighted_mps) / self._since_sighting_s
            self._slide_fall_mps2 = min(max(seen, low), high)

    def _releasing(self) -> bool:
        return any(axle.phase is Phase.RELEASE for axle in self._axles)
