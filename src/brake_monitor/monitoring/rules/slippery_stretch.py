"""A stretch of slippery rail, and what the rail gives on it."""

from collections import deque
from dataclasses import dataclass, field
from statistics import median
from typing import Self

from brake_monitor.estimation.estimate import Estimate
from brake_monitor.monitoring.alarm import Values, number_in
from brake_monitor.monitoring.rules.event_end import End

GIVEN = 3000  # values are kept, those of five minutes; the median is theirs


@dataclass(slots=True)
class SlipperyStretch:
    """From the first wheelset that slid on it to the last."""

    began: End
    ended: End
    greatest_slip: list[float]
    is_sure: bool = False  # it has been told by estimates that are valid: then by no other
    least: float = 1.0
    least_speed_mps: float = 0.0  # at which that was
    given: deque[float] = field(default_factory=lambda: deque(maxlen=GIVEN))  # what the rail had to give
    sanded: bool = False

    @classmethod
    def of(cls, evidence: Values, wheelset_count: int) -> Self:
        """The one that an earlier run has told of: its way and time add up, and what was told of the rail holds."""
        least = number_in(evidence, "least_adhesion", 1.0)
        stretch = cls(
            *End.both_of(evidence),
            greatest_slip=[number_in(evidence, f"greatest_slip_{i}") for i in range(1, wheelset_count + 1)],
            is_sure=True,
            least=least,
            least_speed_mps=number_in(evidence, "least_adhesion_speed_mps"),
            sanded=evidence.get("sanding") == "yes",
        )
        stretch.given.append(number_in(evidence, "median_adhesion", least))
        return stretch

    def see(self, now: Estimate, adhesion: float, *, is_sure: bool) -> None:
        """Take what the rail gives where the wagon is, and whether valid estimates say so."""
        self.ended = End.at(now, wsp_actions_of(now))
        if is_sure and not self.is_sure:
            self.is_sure, self.least = True, 1.0
            self.given.clear()
        if is_sure or not self.is_sure:
            self.given.append(adhesion)
            if adhesion < self.least:
                self.least, self.least_speed_mps = adhesion, now.speed_mps
        self.greatest_slip = [max(s, w.slip) for s, w in zip(self.greatest_slip, now.wheelsets, strict=True)]
        self.sanded |= now.sanding

    def evidence(self) -> Values:
        """All that is told of it."""
        began, ended = self.began, self.ended
        values: Values = {
            "started_time_s": began.clock_s,
            "ended_time_s": ended.clock_s,
            "distance_m": ended.distance_m - began.distance_m,
            "speed_start_mps": began.speed_mps,
            "speed_end_mps": ended.speed_mps,
            "least_adhesion": self.least,
            "least_adhesion_speed_mps": self.least_speed_mps,
            "median_adhesion": median(self.given),
            **{f"greatest_slip_{i}": slip for i, slip in enumerate(self.greatest_slip, 1)},
            "wsp_actions": ended.wsp_actions - began.wsp_actions,
            "sanding": "yes" if self.sanded else "no",
        }
        for name, end in (("start", began), ("end", ended)):
            values |= {f"{key}_{name}": value for key, value in end.position.items()}
        return values


def wsp_actions_of(now: Estimate) -> int:
    """How often slide protections have acted, all of them together."""
    return sum([wheelset.work.wsp_actions for wheelset in now.wheelsets])
