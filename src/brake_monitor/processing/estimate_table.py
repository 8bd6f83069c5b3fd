"""Estimates as rows for people and other tools (CSV, Parquet)."""

from enum import StrEnum
from functools import cache

from brake_monitor.estimation.estimate import Estimate
from brake_monitor.samples import Quantity

Value = float | int | bool | str


class Form(StrEnum):
    """How the values of a column are written as text."""

    TIME = "%.6f"  # to the microsecond
    NUMBER = "%.7g"
    COUNT = "%i"
    FLAG = "%d"
    WORD = "%s"


WAGON_COLUMNS = {
    "time_s": Form.TIME,
    "speed_mps": Form.NUMBER,
    "adhesion": Form.NUMBER,
    "adhesion_std": Form.NUMBER,
    "saturated": Form.FLAG,
}
WHEELSET_COLUMNS = {
    "omega_{}_radps": Form.NUMBER,
    "slip_{}": Form.NUMBER,
    "friction_{}": Form.NUMBER,
    "friction_{}_std": Form.NUMBER,
    "friction_{}_status": Form.WORD,
}
EXTRA_WHEELSET_COLUMNS = {
    "adhesion_{}": Form.NUMBER,
    "adhesion_{}_std": Form.NUMBER,
    "pressing_force_{}_n": Form.NUMBER,
    "wsp_{}": Form.FLAG,
}
EXTRA_WAGON_COLUMNS = {
    "deceleration_mps2": Form.NUMBER,
    "deceleration_std_mps2": Form.NUMBER,
    "nis": Form.NUMBER,
    "reset_count": Form.COUNT,
    "reasons": Form.WORD,
}


@cache
def columns(wheelset_count: int) -> dict[str, Form]:
    """Names and forms; the columns after `status` may grow in number, those up to it are agreed for good."""
    numbers = range(1, wheelset_count + 1)
    return {
        **WAGON_COLUMNS,
        **{name.format(i): form for i in numbers for name, form in WHEELSET_COLUMNS.items()},
        "status": Form.WORD,
        **{name.format(i): form for i in numbers for name, form in EXTRA_WHEELSET_COLUMNS.items()},
        **EXTRA_WAGON_COLUMNS,
    }


def header(wheelset_count: int) -> list[str]:
    """The names."""
    return list(columns(wheelset_count))


def line(estimate: Estimate) -> str:
    """One estimate as text with commas between."""
    return _form(len(estimate.wheelsets)) % values(estimate)


@cache
def _form(wheelset_count: int) -> str:
    return ",".join(columns(wheelset_count).values())


def values(estimate: Estimate) -> tuple[Value, ...]:
    """One estimate in the order of the columns."""
    found: list[Value] = [
        estimate.time_s,
        estimate.speed_mps,
        estimate.adhesion,
        estimate.adhesion_std,
        estimate.saturated,
    ]
    for i, own in enumerate(estimate.wheelsets):
        omega_radps = own.omega_radps if estimate.knows(Quantity.AXLE_SPEED, i) else 0.0
        found += (omega_radps, own.slip, own.friction, own.friction_std, str(own.friction_status))
    found.append(str(estimate.status))
    for own in estimate.wheelsets:
        found += (own.adhesion, own.adhesion_std, own.pressing_force_n, own.wsp_active)
    found += (estimate.deceleration_mps2, estimate.deceleration_std_mps2, estimate.nis, estimate.reset_count)
    found.append("; ".join(estimate.reasons))
    return tuple(found)
