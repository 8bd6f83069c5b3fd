"""Estimates → alarms: rules with hysteresis and debounce."""

from enum import StrEnum

from msgspec import Struct


class Severity(StrEnum):
    """Ordered by what a person should do: look, plan, act."""

    INFO = "info"
    WARNING = "warning"
    ALARM = "alarm"


class Alarm(Struct, frozen=True):
    """One alarm as it stands now; published anew at each change (raised, updated, cleared)."""

    id: str  # unique per vehicle and start: "<kind>[-<wheelset>]-<raised time in ms>"
    kind: str  # "low_adhesion", ...
    wheelset: int | None  # from 1; None when it concerns the wagon
    severity: Severity
    raised_time_s: float
    updated_time_s: float
    cleared_time_s: float | None  # None while open
    message: str  # one sentence for a person
    evidence: dict[str, float | str | None]  # the values that raised it, units in the names
