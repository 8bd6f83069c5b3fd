"""Estimates as rows for people and other tools (CSV, Parquet)."""

from functools import cache

from brake_monitor.estimation.estimate import Estimate
from brake_monitor.samples import Quantity

WAGON_COLUMNS = ("time_s", "speed_mps", "adhesion", "adhesion_std", "saturated")
WHEELSET_COLUMNS = ("omega_{}_radps", "slip_{}", "friction_{}", "friction_{}_std", "friction_{}_status")
EXTRA_WHEELSET_COLUMNS = ("adhesion_{}", "adhesion_{}_std", "pressing_force_{}_n", "wsp_{}")
EXTRA_WAGON_COLUMNS = ("deceleration_mps2", "deceleration_std_mps2", "nis", "reset_count", "reasons")

Value = float | int | bool | str


def header(wheelset_count: int) -> list[str]:
    """Column names; the columns after `status` may grow in number, those up to it are agreed for good."""
    numbers = range(1, wheelset_count + 1)
    return [
        *WAGON_COLUMNS,
        *(column.format(i) for i in numbers for column in WHEELSET_COLUMNS),
        "status",
        *(column.format(i) for i in numbers for column in EXTRA_WHEELSET_COLUMNS),
        *EXTRA_WAGON_COLUMNS,
    ]


def line(estimate: Estimate) -> str:
    """One estimate as text with commas between; seven significant digits, time to the microsecond."""
    return _form(len(estimate.wheelsets)) % values(estimate)


@cache
def _form(wheelset_count: int) -> str:
    """How the values are written, in the order of the header."""
    number, flag, word = "%.7g", "%d", "%s"
    return ",".join(
        [
            *("%.6f", number, number, number, flag),
            *(number, number, number, number, word) * wheelset_count,
            word,
            *(number, number, number, flag) * wheelset_count,
            *(number, number, number, flag, word),
        ]
    )


def values(estimate: Estimate) -> tuple[Value, ...]:
    """One estimate in the order of the header."""
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
