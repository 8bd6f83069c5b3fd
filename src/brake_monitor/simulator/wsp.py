"""Wheel-slide protection: one controller per wagon, sampled, working only from the wheel speeds it measures."""

from collections import deque
from dataclasses import dataclass, field
from enum import Enum, auto

from brake_monitor.simulator.pneumatics import Valve

SAMPLE_S = 0.01
SWITCH_OFF_MPS = 4.0 / 3.6
ACCELERATION_WINDOW = 6  # samples
TRIP_DECELERATION_MPS2 = 2.5
TRIP_SLIP = 0.10
RECOVERED_SLIP = 0.04
FALLING_BACK_MPS2 = 1.0
RECOVERING_MPS2 = 0.3
STRONG_RECOVERY_MPS2 = 4.0
RECOVERED_AFTER_MPS2 = 1.5
MAX_HOLD_S = 0.6
STEP_FILL_S = 0.05
STEP_HOLD_S = 0.15
STEPS_UNTIL_FREE_S = 2.5
FREE_REFERENCE_FALL_MPS2 = 1.6
SLIDING_REFERENCE_FALL_MPS2 = (0.15, 1.0)


class Phase(Enum):
    """What the controller does with one wheelset."""

    FREE = auto()
    DUMP = auto()
    HOLD = auto()
    STEP = auto()


@dataclass(slots=True)
class _Axle:
    """Controller state of one wheelset."""

    phase: Phase = Phase.FREE
    phase_s: float = 0.0
    strongest_recovery_mps2: float = 0.0  # since the phase began
    speeds: deque[float] = field(default_factory=lambda: deque(maxlen=ACCELERATION_WINDOW))

    def enter(self, phase: Phase) -> None:
        self.phase, self.phase_s, self.strongest_recovery_mps2 = phase, 0.0, 0.0

    def acceleration_mps2(self) -> float:
        if len(self.speeds) < 2:
            return 0.0
        return (self.speeds[-1] - self.speeds[0]) / (SAMPLE_S * (len(self.speeds) - 1))

    def decide(self, slip: float) -> None:
        acceleration = self.acceleration_mps2()
        self.strongest_recovery_mps2 = max(self.strongest_recovery_mps2, acceleration)
        sliding = slip > TRIP_SLIP or (acceleration < -TRIP_DECELERATION_MPS2 and slip > 0.02)
        if self.phase in (Phase.FREE, Phase.STEP):
            if sliding:
                self.enter(Phase.DUMP)
            elif self.phase is Phase.STEP and self.phase_s > STEPS_UNTIL_FREE_S:
                self.enter(Phase.FREE)
        elif self.phase is Phase.DUMP:
            if acceleration > RECOVERING_MPS2 or slip < RECOVERED_SLIP:
                self.enter(Phase.HOLD)
        elif slip < RECOVERED_SLIP or (acceleration > STRONG_RECOVERY_MPS2 and slip < TRIP_SLIP):
            self.enter(Phase.STEP)
        elif acceleration < -FALLING_BACK_MPS2 or (self.phase_s > MAX_HOLD_S and acceleration < RECOVERING_MPS2):
            self.enter(Phase.DUMP)

    def valve(self) -> Valve:
        if self.phase is Phase.DUMP:
            return Valve.DUMP
        if self.phase is Phase.HOLD:
            return Valve.HOLD
        if self.phase is Phase.STEP and self.phase_s % (STEP_FILL_S + STEP_HOLD_S) >= STEP_FILL_S:
            return Valve.HOLD
        return Valve.FILL


class WheelSlideProtection:
    """Reads all wheel speeds, keeps its own reference speed, commands one valve per wheelset."""

    def __init__(self, wheelset_count: int) -> None:
        self._axles = [_Axle() for _ in range(wheelset_count)]
        self._reference_mps = 0.0
        self._slide_fall_mps2 = 0.4  # how fast the reference falls while every wheelset slides; learned
        self._touch_mps: float | None = None
        self._since_touch_s = 0.0

    @property
    def reference_mps(self) -> float:
        """The controller's idea of the wagon's speed."""
        return self._reference_mps

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
        """Follow the fastest wheel; while all slide, fall as fast as between the last two touches of the true speed."""
        everyone_slides = all(axle.phase is not Phase.FREE for axle in self._axles)
        fall = self._slide_fall_mps2 if everyone_slides else FREE_REFERENCE_FALL_MPS2
        self._reference_mps -= fall * SAMPLE_S
        self._since_touch_s += SAMPLE_S
        if fastest_mps < self._reference_mps and not self._someone_ran_free():
            return
        self._reference_mps = fastest_mps
        if everyone_slides and self._touch_mps is not None and self._since_touch_s > 0.5:
            low, high = SLIDING_REFERENCE_FALL_MPS2
            seen = min(max((self._touch_mps - fastest_mps) / self._since_touch_s, low), high)
            self._slide_fall_mps2 += 0.5 * (seen - self._slide_fall_mps2)
        if self._touch_mps is None or self._since_touch_s > 0.5:
            self._touch_mps, self._since_touch_s = fastest_mps, 0.0

    def _someone_ran_free(self) -> bool:
        """A wheelset whose brake is off and which no longer accelerates rolls at the wagon's speed."""
        return any(
            axle.phase is Phase.HOLD
            and axle.strongest_recovery_mps2 > RECOVERED_AFTER_MPS2
            and abs(axle.acceleration_mps2()) < RECOVERING_MPS2
            for axle in self._axles
        )
