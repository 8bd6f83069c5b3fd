"""How often each signal was lost within the last minute, for however short a moment."""

from collections import defaultdict, deque
from collections.abc import Mapping
from math import inf

from brake_monitor.monitoring.observation import Observation
from brake_monitor.samples import Place

SPAN_S = 60.0


class Losses:
    """Sees every observation; knows which signals come and go."""

    def __init__(self, often: int) -> None:
        """A signal is told of from `often` losses within the span on, until there are less than half as many."""
        self._often = often
        self._restless: Mapping[Place, int] = {}  # what is told of, and how often it was lost at the most
        self._told: dict[Place, int] = {}  # how often it was lost since the start, as told last
        self._lost_s: defaultdict[Place, deque[float]] = defaultdict(deque)

    def see(self, seen: Observation, quiet_since_s: Mapping[str, float]) -> Mapping[Place, int]:
        """Which signals are lost so often, and how often they were; `quiet_since_s`: of each bus that is silent now.

        What is lost with all others on its bus is not counted.
        """
        restless = {}
        for report in seen.inputs:
            if not report.losses:
                continue
            place, lost_s = report.place, self._lost_s[report.place]
            lost_s.extend([seen.time_s] * (report.losses - self._told.get(place, 0)))
            self._told[place] = report.losses
            while lost_s and lost_s[-1] > quiet_since_s.get(report.channel.bus, inf):
                lost_s.pop()
            while lost_s and not 0.0 <= seen.time_s - lost_s[0] <= SPAN_S:
                lost_s.popleft()
            if len(lost_s) >= (self._often / 2 if place in self._restless else self._often):
                restless[place] = max(len(lost_s), self._restless.get(place, 0))
        self._restless = restless
        return restless
