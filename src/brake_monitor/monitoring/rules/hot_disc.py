"""Hot discs: by the heat that the pads made, since no sensor measures the temperature."""

from math import inf

from brake_monitor.monitoring.alarm import Severity, Values, number_in
from brake_monitor.monitoring.observation import Observation
from brake_monitor.monitoring.rule import FINE, UNKNOWN, Finding, Rule, Verdict
from brake_monitor.settings.alarm_settings import HotDiscRule


class HotDisc(Rule[HotDiscRule]):
    """Judges the estimated temperature of each wheelset's discs."""

    kind = "hot_disc"

    def __init__(self, settings: HotDiscRule, wheelset_count: int) -> None:
        super().__init__(settings, wheelset_count)
        self._peaks_c = [-inf] * wheelset_count  # since they were last fine

    def judge(self, seen: Observation) -> tuple[Verdict, ...]:
        """One verdict per wheelset."""
        return tuple([self._judge(i, unit.disc_temperature_c) for i, unit in enumerate(seen.brakes.units)])

    def resume(self, i: int, evidence: Values) -> None:
        """Go on with discs that were hot."""
        self._peaks_c[i] = number_in(evidence, "peak_disc_temperature_c")

    def _judge(self, i: int, temperature_c: float) -> Verdict:
        settings = self.settings
        if temperature_c < settings.warning_c - settings.clear_margin_k:
            self._peaks_c[i] = -inf
            return FINE
        if temperature_c < settings.warning_c:
            return UNKNOWN
        peak_c = self._peaks_c[i] = max(self._peaks_c[i], temperature_c)
        is_alarm = temperature_c >= settings.alarm_c
        limit_c = settings.alarm_c if is_alarm else settings.warning_c
        return Finding(
            Severity.ALARM if is_alarm else Severity.WARNING,
            f"The discs of wheelset {i + 1} had up to about {peak_c:.0f} °C (limit {limit_c:g} °C): "
            "the pads begin to fade.",
            {"disc_temperature_c": temperature_c, "peak_disc_temperature_c": peak_c},
        )
