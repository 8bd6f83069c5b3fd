"""Readings of a recording that come later than others of the same moment: speeds, and forces as slides show."""

from collections.abc import Iterator

from brake_monitor.estimation.doubts.force_timing import EARLY_S
from brake_monitor.inspection.first_hour import FirstHour
from brake_monitor.inspection.force_lag import obeyed_forces
from brake_monitor.inspection.speed_lag import LEAST_LAG_S, UNSURE, speed_lag_s
from brake_monitor.settings.config import Settings, Signals


def remarks_on_lags(first_hour: FirstHour, settings: Settings) -> Iterator[str]:
    """What to do about each: which delay_s should be what."""
    lag_s = speed_lag_s(first_hour, settings.vehicle.wheel_radius_m)
    if lag_s is not None:
        way, unsure_s = "later" if lag_s > 0.0 else "earlier", max(LEAST_LAG_S, UNSURE * abs(lag_s))
        yield (
            f"speed comes about {abs(lag_s):.2f} s {way} than the axle speeds: "
            f"its {_should_be(settings.signals.speed.delay_s, lag_s, unsure_s)}"
        )
    for place, obeyed in enumerate(obeyed_forces(first_hour, settings.vehicle.wheel_radius_m)):
        if obeyed is None:
            continue
        if obeyed.place != place:
            yield (
                f"axle_speed {place + 1} does what pressing_force {obeyed.place + 1} says, not {place + 1}, as "
                "slides show: look at the order in both lists"
            )
        elif obeyed.lag_s != 0.0:
            yield _force_lag(place, obeyed.lag_s, settings.signals)


def _force_lag(place: int, lag_s: float, signals: Signals) -> str:
    """Which of a wheelset's two signals comes late, or is said to come later than it does."""
    force = f"pressing_force {place + 1}", signals.pressing_force[place].delay_s
    wheel = f"axle_speed {place + 1}", signals.axle_speed[place].delay_s
    (late, late_s), (early, early_s) = (force, wheel) if lag_s > 0.0 else (wheel, force)
    shown = f"{late} comes about {abs(lag_s):.2f} s later than {early}, as slides show: "
    if early_s >= abs(lag_s) - EARLY_S:  # that one is said to come late by more than it does
        return f"{shown}of {early} the {_should_be(early_s, -abs(lag_s), EARLY_S)}"
    or_pads = "" if lag_s > 0.0 else ", unless it is the pads that press as much later than told"
    return f"{shown}its {_should_be(late_s, abs(lag_s), EARLY_S)}{or_pads}"


def _should_be(told_s: float, lag_s: float, unsure_s: float) -> str:
    """What to make of a delay that is told, where the reading still lags, or comes early (negative)."""
    delay_s = told_s + lag_s
    better = f"about {delay_s:.2f}" if delay_s > unsure_s else "about 0 (leave it out)"
    return f"delay_s should be {better}, not {told_s:g}"
