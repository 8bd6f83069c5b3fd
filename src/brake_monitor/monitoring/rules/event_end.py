"""Where and when an event begins and ends."""

from typing import NamedTuple, Self

from brake_monitor.estimation.estimate import Estimate
from brake_monitor.monitoring.alarm import Values, number_in
from brake_monitor.monitoring.observation import position


class End(NamedTuple):
    """One of its two ends."""

    time_s: float
    clock_s: float  # as in `Estimate`
    distance_m: float
    speed_mps: float
    wsp_actions: int  # so far
    position: Values

    @classmethod
    def at(cls, now: Estimate, wsp_actions: int) -> Self:
        """Where the wagon is."""
        return cls(now.time_s, now.clock_s, now.distance_m, now.speed_mps, wsp_actions, position(now))

    @classmethod
    def both_of(cls, evidence: Values) -> tuple[Self, Self]:
        """Those of an event that an earlier run has told of, by what this run counts from 0."""
        way_m, wsp_actions = number_in(evidence, "distance_m"), round(number_in(evidence, "wsp_actions"))
        return cls._of(evidence, "start", -way_m, -wsp_actions), cls._of(evidence, "end", 0.0, 0)

    @classmethod
    def _of(cls, evidence: Values, end: str, distance_m: float, wsp_actions: int) -> Self:
        time_s, speed_mps = number_in(evidence, f"{end}ed_time_s"), number_in(evidence, f"speed_{end}_mps")
        keys = [key for key in ("latitude_deg", "longitude_deg") if f"{key}_{end}" in evidence]
        where = {key: evidence[f"{key}_{end}"] for key in keys}
        return cls(time_s, time_s, distance_m, speed_mps, wsp_actions, where)
