"""Estimates as rows of numbers for people and other tools (CSV)."""

from collections.abc import Iterator

from brake_monitor.estimator import Estimate

WAGON_COLUMNS = ("time_s", "speed_mps", "adhesion", "adhesion_std", "saturated")
WHEELSET_COLUMNS = ("omega_{}_radps", "slip_{}", "friction_{}", "friction_{}_std", "friction_{}_status")
EXTRA_WHEELSET_COLUMNS = ("adhesion_{}", "adhesion_{}_std", "pressing_force_{}_n", "wsp_{}")
EXTRA_WAGON_COLUMNS = ("deceleration_mps2", "deceleration_std_mps2", "nis", "reset_count", "reasons")


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


def row(estimate: Estimate) -> list[str]:
    """One estimate in the order of the header; seven significant digits, time to the microsecond."""
    return list(_cells(estimate))


def _cells(estimate: Estimate) -> Iterator[str]:
    yield f"{estimate.time_s:.6f}"
    yield _number(estimate.speed_mps)
    yield _number(estimate.adhesion)
    yield _number(estimate.adhesion_std)
    yield str(int(estimate.saturated))
    for wheelset in estimate.wheelsets:
        yield _number(wheelset.omega_radps)
        yield _number(wheelset.slip)
        yield _number(wheelset.friction)
        yield _number(wheelset.friction_std)
        yield wheelset.friction_status.value
    yield estimate.status.value
    for wheelset in estimate.wheelsets:
        yield _number(wheelset.adhesion)
        yield _number(wheelset.adhesion_std)
        yield _number(wheelset.pressing_force_n)
        yield str(int(wheelset.wsp_active))
    yield _number(estimate.deceleration_mps2)
    yield _number(estimate.deceleration_std_mps2)
    yield _number(estimate.nis)
    yield str(estimate.reset_count)
    yield "; ".join(estimate.reasons)


def _number(value: float) -> str:
    return f"{value:.7g}"
