"""What an alarm is: one statement about the vehicle, from raised to cleared."""

from enum import StrEnum

from msgspec import Struct

Values = dict[str, float | str | None]  # measured or estimated values, units in the names


TELL_OF_SLIDES = {"slide", "low_adhesion", "wheelset_not_rotating"}  # the kinds that do


class Severity(StrEnum):
    """Ordered by what a person should do: look, plan, act."""

    INFO = "info"
    WARNING = "warning"
    ALARM = "alarm"

    @property
    def rank(self) -> int:
        """Greater is graver."""
        return list(Severity).index(self)


def number_in(evidence: Values, name: str, otherwise: float = 0.0) -> float:
    """A number of an earlier run's evidence; `otherwise` where there is none."""
    value = evidence.get(name)
    return value if isinstance(value, int | float) else otherwise


def signals_in(evidence: Values) -> list[tuple[str, str]]:
    """The signals that it tells of, as in the DBC, and what was wrong with each."""
    signals, conditions = (str(evidence.get(name, "")).split(", ") for name in ("signals", "conditions"))
    return list(zip(signals, conditions, strict=False))


class Alarm(Struct, frozen=True):
    """One alarm as it stands now; given out anew at each change (raised, updated, acknowledged, cleared)."""

    id: str  # "<kind>[-<wheelset>]-<raised time in ms>", unique per vehicle
    kind: str  # "low_adhesion", ...
    wheelset: int | None  # from 1; None when it concerns the wagon
    severity: Severity  # the gravest it has been
    raised_time_s: float
    updated_time_s: float
    acknowledged_time_s: float | None
    cleared_time_s: float | None  # None while open
    message: str  # one sentence for a person
    evidence: Values  # the values that raised it
