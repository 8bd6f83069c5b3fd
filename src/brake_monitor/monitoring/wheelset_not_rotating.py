"""Wheelset not rotating: it is dragged along the rail. It may derail the wagon."""

from brake_monitor.alarm_settings import WheelsetNotRotatingRule
from brake_monitor.monitoring.alarm import Severity, Values
from brake_monitor.monitoring.observation import Observation, position
from brake_monitor.monitoring.rule import FINE, UNKNOWN, Finding, Verdict
from brake_monitor.monitoring.wheel_watch import WheelState


class WheelsetNotRotating:
    """Judges what `WheelWatch` believes of each wheelset."""

    kind = "wheelset_not_rotating"

    def __init__(self, settings: WheelsetNotRotatingRule, wheelset_count: int) -> None:
        self.settings = settings
        self.places = tuple(range(1, wheelset_count + 1))
        self._from: list[tuple[float, float, float] | None] = [None] * wheelset_count  # (time, distance, speed)
        self._dragged_m = [0.0] * wheelset_count

    def judge(self, seen: Observation) -> tuple[Verdict, ...]:
        """One verdict per wheelset."""
        return tuple(self._judge(i, state, seen) for i, state in enumerate(seen.wheels))

    def closing_evidence(self, place: int | None) -> Values:
        """How far it was dragged."""
        return {"dragged_m": self._dragged_m[(place or 1) - 1]}

    def _judge(self, i: int, state: WheelState, seen: Observation) -> Verdict:
        now = seen.estimate
        if state in {WheelState.ROLLING, WheelState.SLIDING, WheelState.PROTECTED}:
            self._from[i] = None
            return FINE
        if state is not WheelState.STOPPED or now.speed_mps <= self.settings.min_speed_mps:
            return UNKNOWN
        since = self._from[i]
        if since is None:
            since = self._from[i] = (now.time_s, now.distance_m, now.speed_mps)
        self._dragged_m[i] = now.distance_m - since[1]
        return Finding(
            Severity.ALARM,
            f"Wheelset {i + 1} does not rotate while the wagon runs at {now.speed_mps * 3.6:.0f} km/h: "
            "stop the train and look at it.",
            {
                "speed_mps": now.speed_mps,
                "speed_start_mps": since[2],
                "started_time_s": since[0],
                "dragged_m": self._dragged_m[i],
                "omega_radps": now.wheelsets[i].omega_radps,
                "pressing_force_n": now.wheelsets[i].pressing_force_n,
                **position(now),
            },
        )
