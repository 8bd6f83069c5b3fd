"""Verdicts that stand from the end of one brake application to the end of the next."""

from abc import abstractmethod
from itertools import takewhile

from brake_monitor.monitoring.brake_units.application_record import ApplicationRecord
from brake_monitor.monitoring.brake_units.wear import PadWear
from brake_monitor.monitoring.observation import Observation
from brake_monitor.monitoring.rule import FINE, UNKNOWN, Rule, Settings, Verdict

Applications = tuple[ApplicationRecord, ...]


class PerApplication(Rule[Settings]):
    """Judges each wheelset only when a brake application has ended, or pads were fitted.

    Before the first application nothing is known.
    """

    of_pads = True  # what those before them rubbed says nothing of pads

    def __init__(self, settings: Settings, friction_nominal: float, wheelset_count: int) -> None:
        super().__init__(settings, wheelset_count)
        self._nominal = friction_nominal
        self._last: ApplicationRecord | None = None
        self._fitted_s: list[float | None] = []  # when each wheelset's pads were
        self._verdicts: tuple[Verdict, ...] = (UNKNOWN,) * wheelset_count

    def judge(self, seen: Observation) -> tuple[Verdict, ...]:
        """One verdict per wheelset."""
        applications, pads = seen.brakes.applications, [unit.pads for unit in seen.brakes.units]
        fitted_s = [own.fitted_time_s for own in pads]
        if applications and (applications[-1] is not self._last or fitted_s != self._fitted_s):
            self._last, self._fitted_s = applications[-1], fitted_s
            comparable = _comparable(applications)
            self._verdicts = tuple([self._judge_of(i, comparable, pads[i]) for i in range(len(self.wheelsets))])
        return self._verdicts

    def _judge_of(self, i: int, applications: Applications, pads: PadWear) -> Verdict:
        if not self.of_pads or pads.fitted_time_s is None:  # since the monitor was installed
            return self._judge_applications(i, applications)
        own = round(pads.since_fitted.stops)  # the clock may have been wrong then, or since
        return self._judge_applications(i, applications[-own:]) if own else FINE  # nothing speaks against them yet

    @abstractmethod
    def _judge_applications(self, i: int, applications: Applications) -> Verdict:
        """Judge wheelset i, from 0, by these applications, oldest first."""


def _comparable(applications: Applications) -> Applications:
    """Those since the last one whose friction was told by another mass, force or brake radius."""
    alike = takewhile(lambda record: record.calibration in (None, applications[-1].calibration), reversed(applications))
    return tuple(alike)[::-1]
