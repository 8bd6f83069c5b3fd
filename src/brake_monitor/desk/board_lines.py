"""The board in plain text, where there is no terminal to draw on. A ± is one standard deviation."""

from brake_monitor.desk.board import Board, alarm_name, force_kn_of, slip_of, speed_kmh, status_words, wheel_kmh, wsp_of
from brake_monitor.desk.text_marks import number, plus_minus
from brake_monitor.monitoring.alarm import Alarm


def plain_line(board: Board) -> str:
    """One line of everything that is known now."""
    estimate = board.estimate
    if estimate is None:
        return "nothing received yet"
    state = "saturated" if estimate.saturated else "used"
    parts = [
        f"{number(estimate.time_s - board.begun_s, 1, 7)} s  {number(speed_kmh(estimate), 1, 5)} km/h  "
        f"adhesion {plus_minus(estimate.adhesion, estimate.adhesion_std)} {state:9} {status_words(estimate)}"
    ]
    for place, wheelset in enumerate(estimate.wheelsets):
        parts.append(
            f"{place + 1}: {number(wheel_kmh(board, estimate, place), 1, 5)} km/h"
            f"  slip {number(slip_of(estimate, place) * 100, 1, 5)} %"
            f"  force {number(force_kn_of(estimate, place), 1, 5)} kN"
            f"  friction {plus_minus(wheelset.friction, wheelset.friction_std)} {wheelset.friction_status}"
            + f"  {wsp_of(estimate, place)}".rstrip()
        )
    return " | ".join(parts)


def plain_alarm(alarm: Alarm) -> str:
    """One line of a change of an alarm."""
    state = "open" if alarm.cleared_time_s is None else "cleared"
    return f"  {alarm.severity.upper()} {alarm_name(alarm)} {state}: {alarm.message}"
