"""How often each signal was lost within the last minute, for however short a moment."""

from collections import defaultdict, deque
from collections.abc import Mapping
from math import inf

from brake_monitor.monitoring.observation import Observation
from brake_monitor.samples import Measurand

SPAN_S = 60.0


class Losses:
    """Sees every observation; knows which signals come and go."""

    def __init__(self, often: int) -> None:
        """A signal is told of from `often` losses within the span on, until there are less than half as many."""
        self._often = often
        self._restless: Mapping[Measurand, int] = {}  # what is told of, and how often it was lost at the most
        self._told: dict[Measurand, int] = {}  # how often it was lost since the start, as told last
        self._lost_s: defaultdict[Measurand, deque[float]] = defaultdict(deque)

    def see(self, seen: Observation, quiet_since_s: Mapping[str, float]) -> Mapping[Measurand, int]:
        """Which signals are lost so often, and how often they were; `quiet_since_s`: of each bus that is silent now.

        What is lost with all others on its bus is not counted.
        """
        restless = {}
        for report in seen.inputs:
            if not report.losses:
                continue
            measurand, lost_s = report.measurand, self._lost_s[report.measurand]
            lost_s.extend([seen.time_s] * (report.losses - self._told.get(measurand, 0)))
            self._told[measurand] = report.losses
            while lost_s and lost_s[-1] > quiet_since_s.get(report.channel.bus, inf):
                lost_s.pop()
            while lost_s and not 0.0 <= seen.time_s - lost_s[0] <= SPAN_S:
                lost_s.popleft()
            if len(lost_s) >= (self._often / 2 if measurand in self._restless else self._often):
                restless[measurand] = max(len(lost_s), self._restless.get(measurand, 0))
        self._restless = restless
        return restless
