"""Worn pads: near their limit, and at it."""

from brake_monitor.monitoring.alarm import Severity
from brake_monitor.monitoring.brake_units.wear import PadWear, expected_thickness_mm, pad_life
from brake_monitor.monitoring.observation import Observation
from brake_monitor.monitoring.rule import FINE, UNKNOWN, Finding, Rule, Verdict
from brake_monitor.settings.alarm_settings import PadAtLimitRule, PadNearLimitRule
from brake_monitor.settings.wear_settings import WearSettings


class ThinPads(Rule[PadNearLimitRule | PadAtLimitRule]):
    """Judges the expected thickness of each wheelset's pads, by energy."""

    def __init__(self, settings: PadNearLimitRule | PadAtLimitRule, wear: WearSettings, wheelset_count: int) -> None:
        """`settings` decide whether the alarm comes near the pads' limit, or at it."""
        super().__init__(settings, wheelset_count)
        self._wear = wear
        if isinstance(settings, PadNearLimitRule):
            self.kind, self._severity, self._are = "pad_near_limit", Severity.WARNING, "come near"
            self._limit_mm = wear.pad_limit_mm + settings.margin_mm
        else:
            self.kind, self._severity, self._are = "pad_at_limit", Severity.ALARM, "are at"
            self._limit_mm = wear.pad_limit_mm

    def judge(self, seen: Observation) -> tuple[Verdict, ...]:
        """One verdict per wheelset."""
        return tuple([self._judge(i, unit.pads) for i, unit in enumerate(seen.brakes.units, start=1)])

    def _judge(self, i: int, pads: PadWear) -> Verdict:
        thickness_mm = expected_thickness_mm(pads, self._wear)
        if thickness_mm > self._limit_mm:
            return FINE if thickness_mm > self._limit_mm + self.settings.clear_margin_mm else UNKNOWN
        life = pad_life(pads, self._wear)
        now = life.by_energy
        return Finding(
            self._severity,
            f"The pads of wheelset {i} {self._are} their limit of {self._wear.pad_limit_mm:g} mm: "
            f"expected {now.value_mm:.1f} mm ({now.low_mm:.1f} to {now.high_mm:.1f} mm); gauge them.",
            {
                "thickness_mm": now.value_mm,
                "thickness_low_mm": now.low_mm,
                "thickness_high_mm": now.high_mm,
                "thickness_by_archard_mm": life.by_archard.value_mm,
                "remaining_stops": life.remaining_stops,
                "remaining_km": life.remaining_km,
            },
        )
