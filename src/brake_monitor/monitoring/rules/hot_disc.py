"""Hot discs: by the heat that the pads made, since no sensor measures the temperature."""

from dataclasses import dataclass
from math import inf

from brake_monitor.monitoring.alarm import Severity, Values, number_in
from brake_monitor.monitoring.observation import Observation
from brake_monitor.monitoring.rule import FINE, UNKNOWN, Finding, Verdict
from brake_monitor.settings.alarm_settings import HotDiscRule


@dataclass(slots=True)
class _Heat:
    """The discs of one wheelset, from when they are hot until that is over."""

    since_s: float
    peak_c: float
    is_told: bool = False  # it has lasted for the debounce time


class HotDisc:
    """Judges the estimated temperature of each wheelset's discs."""

    kind = "hot_disc"

    def __init__(self, settings: HotDiscRule, wheelset_count: int) -> None:
        self.settings = settings
        self.wheelsets = tuple(range(1, wheelset_count + 1))
        self._heats: list[_Heat | None] = [None] * wheelset_count

    def judge(self, seen: Observation) -> tuple[Verdict, ...]:
        """One verdict per wheelset."""
        return tuple([self._judge(i, seen.time_s, unit.disc_temperature_c) for i, unit in enumerate(seen.brakes.units)])

    def resume(self, i: int, evidence: Values) -> None:
        """Go on with discs that were hot."""
        self._heats[i] = _Heat(-inf, number_in(evidence, "peak_disc_temperature_c"), is_told=True)

    def closing_evidence(self, i: int) -> Values:
        """How hot it became."""
        heat, self._heats[i] = self._heats[i], None
        return {"peak_disc_temperature_c": heat.peak_c} if heat else {}

    def _judge(self, i: int, time_s: float, temperature_c: float) -> Verdict:
        settings, heat = self.settings, self._heats[i]
        if temperature_c < settings.warning_c:
            if heat and not heat.is_told:  # no alarm came of it
                self._heats[i] = None
            return FINE if temperature_c < settings.warning_c - settings.clear_margin_k else UNKNOWN
        if heat is None:
            heat = self._heats[i] = _Heat(time_s, temperature_c)
        heat.since_s = min(heat.since_s, time_s)  # the clock may be set back
        heat.peak_c = max(heat.peak_c, temperature_c)
        heat.is_told |= time_s - heat.since_s >= settings.debounce_s
        is_alarm = temperature_c >= settings.alarm_c
        limit_c = settings.alarm_c if is_alarm else settings.warning_c
        return Finding(
            Severity.ALARM if is_alarm else Severity.WARNING,
            f"The discs of wheelset {i + 1} had up to about {heat.peak_c:.0f} °C (limit {limit_c:g} °C): "
            "the pads begin to fade.",
            {"disc_temperature_c": temperature_c, "peak_disc_temperature_c": heat.peak_c},
        )
