"""Low adhesion: the rail gives less than it should, and the wheels have asked for more."""

from collections import deque
from math import inf
from typing import NamedTuple

from brake_monitor.estimation.estimate import INTERVAL_SIGMAS, Estimate, Status, WheelsetEstimate
from brake_monitor.monitoring.alarm import Severity, Values
from brake_monitor.monitoring.inputs.wheel_state import UNTOLD, WheelState
from brake_monitor.monitoring.observation import OBSERVATION_PERIOD_S, Observation
from brake_monitor.monitoring.rule import FINE, UNKNOWN, Finding, Rule, Verdict
from brake_monitor.monitoring.rules.earlier_count import EarlierCount
from brake_monitor.monitoring.rules.event_end import End
from brake_monitor.monitoring.rules.slippery_stretch import SlipperyStretch, wsp_actions_of
from brake_monitor.samples import ESSENTIAL, Quantity
from brake_monitor.settings.alarm_settings import LowAdhesionRule, level_of

STOPPED, BLOCKED, SLIDING, PROTECTED = WheelState.STOPPED, WheelState.BLOCKED, WheelState.SLIDING, WheelState.PROTECTED
SEVERITIES = {"low": Severity.INFO, "very_low": Severity.WARNING, "extremely_low": Severity.ALARM}
MAY_SLIDE = {STOPPED, SLIDING, PROTECTED}
HELD_S = 0.45  # a wheelset that its protection has just released still tells of the rail
PROTECTED_S = 1.5  # ... and where protection keeps it from sliding far, until it tries again
PEAK_SLIP = 0.015  # beyond it a protected wheelset takes about what the rail gives


class _Asked(NamedTuple):
    """What the rail gave to wheelsets that asked it for more."""

    time_s: float
    adhesion: float  # at the most
    estimated: float
    is_valid: bool  # the estimate that says so


class LowAdhesion(Rule[LowAdhesionRule]):
    """Judges the most that the rail gave to its sliding wheelsets while they slid for the debounce time.

    The utilised adhesion dips towards zero whenever the WSP releases the brake, and a wheelset that is braked anew does
    not take yet what the rail has to give: the greatest of so much sliding is, above walking pace. An event ends when
    the rail gives more than level + margin for `clear_s`, or when nothing more was asked for during the merging gap.
    How low it is valid estimates tell, and others only until there are any: what an input that fails makes of the rail
    is no news of the rail. Those in doubt tell by the upper end of their interval, and so do all of a wheelset that
    stands: no speed of its own tells whether its pressing force is all that holds it.
    """

    kind = "low_adhesion"
    is_event = True

    def __init__(self, settings: LowAdhesionRule, wheelset_count: int) -> None:
        super().__init__(settings)
        self._count = wheelset_count
        observations = max(round(max(settings.debounce_s, HELD_S) / OBSERVATION_PERIOD_S), 1)
        self._asked: deque[_Asked] = deque(maxlen=observations)  # lately
        self._event: SlipperyStretch | None = None
        self._earlier_acts: EarlierCount[int] = EarlierCount(settings.merge_gap_s)  # of slide protection
        self._acts_before = 0
        self._seen_s = -inf

    def judge(self, seen: Observation) -> tuple[Verdict]:
        """Judge the wagon."""
        return (self._judge(seen),)

    def resume(self, _: int, evidence: Values) -> None:
        """Go on with an event."""
        self._event = SlipperyStretch.of(evidence, self._count)

    def closing_evidence(self, _: int) -> Values:
        """The whole event."""
        event, self._event = self._event, None
        return event.evidence() if event else {}

    def _judge(self, seen: Observation) -> Verdict:
        now = seen.estimate
        if self._seen_s > now.time_s:  # the clock was set back
            self._asked.clear()
            if self._event:  # it goes on
                self._event.ended = self._event.ended._replace(time_s=now.time_s, clock_s=now.clock_s)
        self._seen_s = now.time_s
        self._acts_before = self._earlier_acts.see(now.time_s, wsp_actions_of(now))
        given = self._given(seen)
        if given is not None:
            self._asked.append(_Asked(now.time_s, *given, now.status is Status.VALID))
        if not self._asked:  # of an event that an earlier run has told of nothing is known before the wheelsets are
            return UNKNOWN if self._event and UNTOLD.issuperset(seen.wheels) else FINE
        asked_s = self._asked[-1].time_s
        held_s = PROTECTED_S if PROTECTED in seen.wheels else HELD_S
        if now.time_s - asked_s > held_s:
            return UNKNOWN if UNTOLD.issuperset(seen.wheels) else self._nothing_asked(now.time_s, asked_s)
        while asked_s - self._asked[0].time_s > self.settings.merge_gap_s:
            self._asked.popleft()
        best = max(asked.adhesion for asked in self._asked)
        if best >= self.settings.low:
            estimated = max(asked.estimated for asked in self._asked)
            if estimated < self.settings.low and (event := self._running(now.time_s)):  # it may go on
                event.ended = End.at(now, wsp_actions_of(now))
            return FINE if estimated > self.settings.low + self.settings.clear_margin else UNKNOWN
        return self._finding(self._note(now, best, is_sure=self._is_sure()), now, best)

    def _is_sure(self) -> bool:
        """Whether valid estimates tell of enough sliding: a brake that is only coming on does not ask for all."""
        return len(self._asked) == self._asked.maxlen and all(asked.is_valid for asked in self._asked)

    def _given(self, seen: Observation) -> tuple[float, float] | None:
        """What the rail gives to the wheelsets that slide on it, at the most and as it is estimated.

        None when none does or it cannot be told.
        """
        now = seen.estimate
        if MAY_SLIDE.isdisjoint(seen.wheels):
            return None
        if now.speed_mps <= self.settings.min_speed_mps or now.status is Status.HELD:
            return None
        if now.status is Status.INVALID and self._running(now.time_s) is None and not _miss_their_own(seen):
            return None  # it begins nothing
        is_unsure = now.status is Status.CONVERGING
        states = seen.wheels
        if BLOCKED in states:  # how much of what retards the wagon is its, and how much those that stand, is unknown
            states = tuple([BLOCKED if state is STOPPED else state for state in states])
        sliding = [
            (own.adhesion, INTERVAL_SIGMAS * own.adhesion_std if is_unsure or state is STOPPED else 0.0)
            for own, state in zip(now.wheelsets, states, strict=True)
            if _slides(own, state)
        ]
        if not sliding:
            return None
        estimated, unsure = (sum(values) / len(sliding) for values in zip(*sliding, strict=True))
        if estimated + unsure < 0.0:  # a rail that pushes on is an estimate that errs
            return None
        return estimated + unsure, estimated

    def _nothing_asked(self, time_s: float, asked_s: float) -> Verdict:
        """Gaps shorter than the merging gap belong to the event, whose end then waits for no `clear_s` of its own."""
        gap_s = time_s - asked_s
        if gap_s >= self.settings.merge_gap_s:
            self._asked.clear()
            return FINE
        return UNKNOWN if gap_s < self.settings.merge_gap_s - self.settings.clear_s else FINE

    def _running(self, time_s: float) -> SlipperyStretch | None:
        """The event that what is seen now belongs to."""
        event, merges_s = self._event, self.settings.merge_gap_s + self.settings.clear_s
        return event if event is not None and 0.0 <= time_s - event.ended.time_s <= merges_s else None

    def _note(self, now: Estimate, best: float, *, is_sure: bool) -> SlipperyStretch:
        event = self._running(now.time_s)
        if event is None:
            began = End.at(now, self._acts_before)
            event = self._event = SlipperyStretch(began, began, greatest_slip=[0.0] * self._count)
        event.see(now, best, is_sure=is_sure)
        return event

    def _finding(self, event: SlipperyStretch, now: Estimate, best: float) -> Finding:
        least, speed_mps = event.least, event.least_speed_mps
        levels = self.settings.levels
        level = level_of(least, levels)
        if level not in levels:  # of an event told by an earlier run with other limits
            level = "low"
        name = level.replace("_", " ")
        return Finding(
            SEVERITIES[level],
            f"Adhesion is {name}: the rail gave no more than {least:z.3f} (limit {levels[level]:g}) "
            f"at {speed_mps * 3.6:.0f} km/h while the brake asked for more.",
            {
                "level": name,
                "adhesion": best,
                "adhesion_std": now.adhesion_std,
                "speed_mps": now.speed_mps,
                **event.evidence(),
            },
        )


def _miss_their_own(seen: Observation) -> bool:
    """Whether an estimate is invalid for inputs of single wheelsets alone: the others still tell of the rail."""
    missed = [report.channel.quantity for report in seen.inputs.not_good if report.channel.quantity in ESSENTIAL]
    return bool(missed) and Quantity.SPEED not in missed


def _slides(own: WheelsetEstimate, state: WheelState) -> bool:
    """Whether it takes what the rail gives."""
    if own.friction_status is Status.INVALID:  # an input of its own is; what others miss does not matter
        return False
    return state is SLIDING or state is STOPPED or (state is PROTECTED and own.slip > PEAK_SLIP)
