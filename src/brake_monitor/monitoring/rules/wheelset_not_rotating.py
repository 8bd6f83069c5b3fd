"""Wheelset not rotating: it is dragged along the rail. It may derail the wagon."""

from dataclasses import dataclass
from math import inf

from brake_monitor.estimation.estimate import Estimate
from brake_monitor.monitoring.alarm import Severity, Values, number_in
from brake_monitor.monitoring.inputs.wheel_state import WheelState
from brake_monitor.monitoring.observation import Observation, position
from brake_monitor.monitoring.rule import FINE, UNKNOWN, Finding, Rule, Verdict
from brake_monitor.settings.alarm_settings import WheelsetNotRotatingRule

TURNS = {WheelState.ROLLING, WheelState.SLIDING, WheelState.PROTECTED}
STANDS = {WheelState.STOPPED, WheelState.BLOCKED}


@dataclass(slots=True)
class _Dragging:
    """What one alarm is about: a wheelset that stood once, or again before the alarm was cleared."""

    began_clock_s: float
    speed_start_mps: float
    stands_from_m: float | None  # where it came to stand; None: it turns again
    since_s: float  # since when it has been found without a break; inf: it is not
    earlier_m: float = 0.0  # dragged before it came to stand the last time
    dragged_m: float = 0.0
    is_told: bool = False  # it has lasted for the debounce time


class WheelsetNotRotating(Rule[WheelsetNotRotatingRule]):
    """Judges what `WheelWatch` believes of each wheelset, and adds up how far each was dragged until all is cleared."""

    kind = "wheelset_not_rotating"

    def __init__(self, settings: WheelsetNotRotatingRule, wheelset_count: int) -> None:
        super().__init__(settings, wheelset_count)
        self._dragging: list[_Dragging | None] = [None] * wheelset_count

    def judge(self, seen: Observation) -> tuple[Verdict, ...]:
        """One verdict per wheelset."""
        if seen.all_roll and not any(self._dragging):  # the usual case
            return (FINE,) * len(self.wheelsets)
        return tuple([self._judge(i, state, seen.estimate) for i, state in enumerate(seen.wheels)])

    def resume(self, i: int, evidence: Values) -> None:
        """Go on with a wheelset that was dragged: it adds up."""
        began_s, speed_mps = number_in(evidence, "started_time_s"), number_in(evidence, "speed_start_mps")
        dragged_m = number_in(evidence, "dragged_m")
        self._dragging[i] = _Dragging(
            began_s, speed_mps, stands_from_m=None, since_s=inf, earlier_m=dragged_m, dragged_m=dragged_m, is_told=True
        )

    def closing_evidence(self, i: int) -> Values:
        """How far it was dragged."""
        dragging, self._dragging[i] = self._dragging[i], None
        return {"dragged_m": dragging.dragged_m} if dragging else {}

    def _judge(self, i: int, state: WheelState, now: Estimate) -> Verdict:
        dragging = self._dragging[i]
        if state in TURNS:
            if dragging and dragging.is_told:
                dragging.stands_from_m, dragging.since_s, dragging.earlier_m = None, inf, dragging.dragged_m
            else:  # a slide protection let it stand for a moment
                self._dragging[i] = None
            return FINE
        if state not in STANDS or now.speed_mps <= self.settings.min_speed_mps:
            if dragging:
                dragging.since_s = inf
            return UNKNOWN
        if dragging is None:
            dragging = self._dragging[i] = _Dragging(now.clock_s, now.speed_mps, now.distance_m, now.time_s)
        if dragging.stands_from_m is None:
            dragging.stands_from_m = now.distance_m
        dragging.dragged_m = dragging.earlier_m + now.distance_m - dragging.stands_from_m
        dragging.since_s = min(dragging.since_s, now.time_s)
        dragging.is_told |= now.time_s - dragging.since_s >= self.settings.debounce_s
        return self._finding(i, dragging, now)

    def _finding(self, i: int, dragging: _Dragging, now: Estimate) -> Finding:
        from_kmh, now_kmh = dragging.speed_start_mps * 3.6, now.speed_mps * 3.6
        way = f"{dragging.dragged_m:.0f} m from {from_kmh:.0f} km/h on"
        if dragging.earlier_m > 0.0:  # it has turned meanwhile, or the program was started anew
            way = f"{dragging.dragged_m:.0f} m in all, the first time from {from_kmh:.0f} km/h on"
        return Finding(
            Severity.ALARM,
            f"Wheelset {i + 1} does not rotate while the wagon runs at {now_kmh:.0f} km/h, and has been dragged {way}: "
            "stop the train and look at it.",
            {
                "speed_mps": now.speed_mps,
                "speed_start_mps": dragging.speed_start_mps,
                "started_time_s": dragging.began_clock_s,
                "dragged_m": dragging.dragged_m,
                "omega_radps": now.wheelsets[i].omega_radps,
                "pressing_force_n": now.wheelsets[i].pressing_force_n,
                **position(now),
            },
        )
