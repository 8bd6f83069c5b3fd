"""What a rule is: it judges what it sees. The life of the alarm that comes of it is not its business."""

from enum import Enum
from typing import Protocol, runtime_checkable

from msgspec import Struct

from brake_monitor.monitoring.alarm import Severity, Values
from brake_monitor.monitoring.misled import MisledBy
from brake_monitor.monitoring.observation import Observation
from brake_monitor.settings.alarm_settings import RuleSettings


class Finding(Struct, frozen=True):
    """The condition is there."""

    severity: Severity
    message: str
    evidence: Values
    latches: bool = True  # if the rule's alarms do; False: it may yet prove to be nothing, and then clears by itself
    is_all: bool = False  # it lists all that is wrong now: it replaces what was told before, even if that was graver
    misled_by: MisledBy | None = None  # why estimates err meanwhile, which do not know of it
    weighed_by: str = ""  # its number by which, while the condition lasts, the weightiest is told; without: the newest


class Suspicion(Struct, frozen=True):
    """It may be there, which is not enough for an alarm: nothing is raised or cleared, but the estimates may err."""

    misled_by: MisledBy


class NoFinding(Enum):
    """Why nothing was found."""

    FINE = "fine"  # the condition is not there
    UNKNOWN = "unknown"  # it cannot be told now: nothing is raised or cleared meanwhile


FINE, UNKNOWN = NoFinding.FINE, NoFinding.UNKNOWN
Verdict = Finding | Suspicion | NoFinding


class Rule(Protocol):
    """One kind of alarm. `judge` is called at each observation, in order of time, also while the alarm is open."""

    @property
    def kind(self) -> str:
        """As in `Alarm`."""

    @property
    def settings(self) -> RuleSettings:
        """Thresholds and timing."""

    @property
    def wheelsets(self) -> tuple[int | None, ...]:
        """The wheelsets (from 1) that it judges, or (None,) for the wagon; methods get which of them, from 0."""

    def judge(self, seen: Observation) -> tuple[Verdict, ...]:
        """One verdict per wheelset, or the one of the wagon."""


@runtime_checkable
class LastingRule(Rule, Protocol):
    """A rule that must know of its open alarms what no observation shows anew."""

    def resume(self, i: int, evidence: Values) -> MisledBy | None:
        """Go on with what an earlier run of the program has told of wheelset i, with this evidence; as in `Finding`."""


@runtime_checkable
class EventRule(LastingRule, Protocol):
    """A rule whose alarms are events that show their extent as they end."""

    def closing_evidence(self, i: int) -> Values:
        """What is worth keeping of the event of wheelset i that has just ended; the rule forgets it."""
