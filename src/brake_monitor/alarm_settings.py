"""The [alarms] table of the configuration: one table per rule, named like the alarm's kind."""

from msgspec import Struct, field

from brake_monitor.bounds import NonNegative, Positive


class RuleSettings(Struct, frozen=True, forbid_unknown_fields=True):
    """What every rule has: how long its condition must last, and how long be gone."""

    enabled: bool = True
    debounce_s: NonNegative = 0.5  # the condition lasts this long before the alarm is raised
    clear_s: NonNegative = 2.0  # ... and is gone this long before it is cleared
    latched: bool = False  # once raised it stays until a person has acknowledged it, even if the condition is gone


class LowAdhesionRule(RuleSettings, frozen=True, forbid_unknown_fields=True):
    """The rail gives less than it should, and the wheels have asked for more."""

    low: Positive = 0.10
    very_low: Positive = 0.05
    extremely_low: Positive = 0.02
    clear_margin: NonNegative = 0.02
    merge_gap_s: NonNegative = 3.0
    min_speed_mps: NonNegative = 1.39  # 5 km/h


class AlarmSettings(Struct, frozen=True, forbid_unknown_fields=True):
    """One table per alarm rule."""

    low_adhesion: LowAdhesionRule = field(default_factory=LowAdhesionRule)
