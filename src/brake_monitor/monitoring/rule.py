"""What a rule is: it judges what it sees. The life of the alarm that comes of it is not its business."""

from abc import ABC, abstractmethod
from enum import Enum
from typing import Any, Generic, TypeVar

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


Settings = TypeVar("Settings", bound=RuleSettings)


class Rule(ABC, Generic[Settings]):
    """One kind of alarm, of each wheelset or of the wagon."""

    kind: str  # as in `Alarm`
    is_event = False  # each of its alarms is an event of its own, however soon it follows the one before

    def __init__(self, settings: Settings, wheelset_count: int = 0) -> None:
        """With thresholds and timing; 0: it judges the wagon."""
        self.settings = settings
        self.wheelsets: tuple[int | None, ...] = tuple(range(1, wheelset_count + 1)) or (None,)

    @abstractmethod
    def judge(self, seen: Observation) -> tuple[Verdict, ...]:
        """One verdict for each of `wheelsets`, at each observation, in order of time, also while its alarm is open."""

    def resume(self, i: int, evidence: Values) -> MisledBy | None:
        """Go on with an open alarm of an earlier run, of the wheelset in place i, where no observation shows it anew.

        It had this evidence; why estimates err, as in `Finding`.
        """

    def closing_evidence(self, i: int) -> Values:
        """What is worth keeping of an alarm that shows its extent as it is cleared; the rule forgets it."""
        return {}


AnyRule = Rule[Any]
