"""Slide: a wheelset slides across the rail. Where it stands meanwhile, a flat is ground into its treads."""

from dataclasses import dataclass

from brake_monitor.monitoring.alarm import Severity, Values, number_in
from brake_monitor.monitoring.inputs.watched_wheelset import STANDSTILL_MPS
from brake_monitor.monitoring.inputs.wheel_state import UNTOLD, WheelState
from brake_monitor.monitoring.observation import Observation
from brake_monitor.monitoring.passing_time import Steps
from brake_monitor.monitoring.rule import FINE, UNKNOWN, Finding, Rule, Verdict
from brake_monitor.monitoring.rules.earlier_count import EarlierCount
from brake_monitor.monitoring.rules.event_end import End
from brake_monitor.settings.alarm_settings import SlideRule

NEARLY_STOPPED_SLIP = 0.8  # the same part of the tread stays on the rail for metres
DOUBTFUL = WheelState.DOUBTFUL
ROLLS = {WheelState.ROLLING, WheelState.PROTECTED}


@dataclass(slots=True)
class _Slide:
    """One slide so far."""

    began: End
    ended: End
    sliding_m: float = 0.0  # way of the treads across the rail
    stopped_m: float = 0.0  # of that nearly stopped
    greatest_slip: float = 0.0
    is_over: bool = False  # kept for who is told of it as its alarm ends


class Slide(Rule[SlideRule]):
    """Adds up, per wheelset, the way of its treads across the rail; gaps shorter than `clear_s` belong to the slide."""

    kind = "slide"
    is_event = True

    def __init__(self, settings: SlideRule, wheelset_count: int) -> None:
        super().__init__(settings, wheelset_count)
        self._slides: list[_Slide | None] = [None] * wheelset_count
        self._earlier_acts: EarlierCount[tuple[int, ...]] = EarlierCount(settings.clear_s)  # of slide protection
        self._steps = Steps()

    def judge(self, seen: Observation) -> tuple[Verdict, ...]:
        """One verdict per wheelset."""
        step_s = self._steps.until(seen.time_s)
        acts = tuple([wheelset.work.wsp_actions for wheelset in seen.estimate.wheelsets])
        acts_before = self._earlier_acts.see(seen.time_s, acts)
        if seen.all_roll and not any(self._slides):  # the usual case
            return (FINE,) * len(self.wheelsets)
        return tuple([self._judge(i, state, seen, step_s, acts_before[i]) for i, state in enumerate(seen.wheels)])

    def resume(self, i: int, evidence: Values) -> None:
        """Go on with a slide: it adds up."""
        self._slides[i] = _Slide(
            *End.both_of(evidence),
            sliding_m=number_in(evidence, "sliding_distance_m"),
            stopped_m=number_in(evidence, "nearly_stopped_distance_m"),
            greatest_slip=number_in(evidence, "greatest_slip"),
        )

    def closing_evidence(self, i: int) -> Values:
        """The whole slide."""
        slide, self._slides[i] = self._slides[i], None
        return _evidence(slide) if slide else {}

    def _judge(self, i: int, state: WheelState, seen: Observation, step_s: float, acts_before: int) -> Verdict:
        now, own, slide = seen.estimate, seen.estimate.wheelsets[i], self._slides[i]
        if slide and slide.sliding_m < self.settings.min_distance_m and self._ended_before(slide, now.time_s):
            slide = self._slides[i] = None  # too short to be told of
        if state in UNTOLD:
            return UNKNOWN
        stands = now.speed_mps < STANDSTILL_MPS  # nothing slides any more, whatever the wheelset did before
        if state is DOUBTFUL and not stands:
            return UNKNOWN
        if stands or state in ROLLS:
            if slide is None:
                return FINE
            slide.is_over = self._ended_before(slide, now.time_s)
            return UNKNOWN if slide.sliding_m < self.settings.min_distance_m else FINE
        if slide is None or slide.is_over:
            began = End.at(now, acts_before)
            slide = self._slides[i] = _Slide(began, began)
        slide.sliding_m += max(own.slip, 0.0) * now.speed_mps * step_s
        if own.slip > NEARLY_STOPPED_SLIP:
            slide.stopped_m += own.slip * now.speed_mps * step_s
        slide.greatest_slip = max(slide.greatest_slip, own.slip)
        slide.ended = End.at(now, own.work.wsp_actions)
        if slide.sliding_m < self.settings.min_distance_m:
            return UNKNOWN
        return self._finding(i, slide)

    def _ended_before(self, slide: _Slide, time_s: float) -> bool:
        """Whether it is too long ago for what comes now to go on with it."""
        return not 0.0 <= time_s - slide.ended.time_s < self.settings.clear_s

    def _finding(self, i: int, slide: _Slide) -> Finding:
        settings = self.settings
        severity, flat = Severity.INFO, "no flat is to be expected"
        if slide.stopped_m >= settings.flat_likely_m:
            severity, flat = Severity.ALARM, "a flat is likely: have its treads looked at"
        elif slide.stopped_m >= settings.flat_possible_m:
            severity, flat = Severity.WARNING, "a flat is possible"
        return Finding(
            severity,
            f"Wheelset {i + 1} slid {slide.sliding_m:.0f} m across the rail, {slide.stopped_m:.0f} m of that nearly "
            f"stopped, from {slide.began.speed_mps * 3.6:.0f} to {slide.ended.speed_mps * 3.6:.0f} km/h; {flat}.",
            _evidence(slide),
        )


def _evidence(slide: _Slide) -> Values:
    return {
        "started_time_s": slide.began.clock_s,
        "ended_time_s": slide.ended.clock_s,
        "sliding_distance_m": slide.sliding_m,
        "nearly_stopped_distance_m": slide.stopped_m,
        "greatest_slip": slide.greatest_slip,
        "speed_start_mps": slide.began.speed_mps,
        "speed_end_mps": slide.ended.speed_mps,
        "wsp_actions": slide.ended.wsp_actions - slide.began.wsp_actions,
    }
