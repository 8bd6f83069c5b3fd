"""Worn pads: near their limit, and at it."""

from brake_monitor.monitoring.alarm import Severity, Values
from brake_monitor.monitoring.observation import Observation
from brake_monitor.monitoring.rule import FINE, UNKNOWN, Finding, NoFinding, Verdict
from brake_monitor.monitoring.wear import PadWear, expected_thickness_mm, pad_life
from brake_monitor.settings.alarm_settings import PadAtLimitRule, PadNearLimitRule
from brake_monitor.settings.wear_settings import WearSettings


class PadNearLimit:
    """Judges the expected thickness of each wheelset's pads, by energy."""

    kind = "pad_near_limit"

    def __init__(self, settings: PadNearLimitRule, wear: WearSettings, wheelset_count: int) -> None:
        self.settings = settings
        self.places = tuple(range(1, wheelset_count + 1))
        self._wear = wear

    def judge(self, seen: Observation) -> tuple[Verdict, ...]:
        """One verdict per wheelset."""
        return tuple([self._judge(i, unit.pads) for i, unit in enumerate(seen.brakes.units, start=1)])

    def closing_evidence(self, _: int | None) -> Values:
        """Nothing more than raised it."""
        return {}

    def _judge(self, i: int, pads: PadWear) -> Verdict:
        wear, margin_mm = self._wear, self.settings.clear_margin_mm
        if no_finding := _judge(pads, wear, wear.pad_limit_mm + self.settings.margin_mm, margin_mm):
            return no_finding
        what = f"The pads of wheelset {i} come near their limit of {wear.pad_limit_mm:g} mm"
        return _finding(pads, wear, Severity.WARNING, what)


class PadAtLimit:
    """Judges as PadNearLimit, against the limit itself."""

    kind = "pad_at_limit"

    def __init__(self, settings: PadAtLimitRule, wear: WearSettings, wheelset_count: int) -> None:
        self.settings = settings
        self.places = tuple(range(1, wheelset_count + 1))
        self._wear = wear

    def judge(self, seen: Observation) -> tuple[Verdict, ...]:
        """One verdict per wheelset."""
        return tuple([self._judge(i, unit.pads) for i, unit in enumerate(seen.brakes.units, start=1)])

    def closing_evidence(self, _: int | None) -> Values:
        """Nothing more than raised it."""
        return {}

    def _judge(self, i: int, pads: PadWear) -> Verdict:
        wear, margin_mm = self._wear, self.settings.clear_margin_mm
        if no_finding := _judge(pads, wear, wear.pad_limit_mm, margin_mm):
            return no_finding
        what = f"The pads of wheelset {i} are at their limit of {wear.pad_limit_mm:g} mm"
        return _finding(pads, wear, Severity.ALARM, what)


def _judge(pads: PadWear, wear: WearSettings, limit_mm: float, clear_margin_mm: float) -> NoFinding | None:
    """None: they are that thin."""
    thickness_mm = expected_thickness_mm(pads, wear)
    if thickness_mm > limit_mm:
        return FINE if thickness_mm > limit_mm + clear_margin_mm else UNKNOWN
    return None


def _finding(pads: PadWear, wear: WearSettings, severity: Severity, what: str) -> Finding:
    life = pad_life(pads, wear)
    now = life.by_energy
    return Finding(
        severity,
        f"{what}: expected {now.value_mm:.1f} mm ({now.low_mm:.1f} to {now.high_mm:.1f} mm); gauge them.",
        {
            "thickness_mm": now.value_mm,
            "thickness_low_mm": now.low_mm,
            "thickness_high_mm": now.high_mm,
            "thickness_by_archard_mm": life.by_archard.value_mm,
            "remaining_stops": life.remaining_stops,
            "remaining_km": life.remaining_km,
        },
    )
