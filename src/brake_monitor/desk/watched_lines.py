"""A watched wagon in words, and in plain lines where there is no terminal to draw on."""

from math import nan

from brake_monitor.desk.text_marks import number, plus_minus
from brake_monitor.desk.watched import Wagon
from brake_monitor.plural import plural
from brake_monitor.publishing.payloads import AlarmMessage


def plain_line(wagon: Wagon, now_s: float) -> str:
    """One line of what is known of a wagon."""
    message = wagon.adhesion
    if message is None:
        return f"{wagon.name}: {life(wagon, now_s)}"
    still = len(wagon.open_alarms())
    frictions = " ".join(f"{i}:{number(f.friction, 3)}" for i, f in sorted(wagon.friction.items()))
    return (
        f"{wagon.name}: {life(wagon, now_s)}  {last_said(wagon, now_s)}"
        f"{number(value_of(message.speed_mps) * 3.6, 1)} km/h  "
        f"adhesion {plus_minus(message.adhesion, message.adhesion_std).strip()}"
        f"{' saturated' if message.saturated else ''}  {message.status}  friction {frictions}  "
        f"{plural(still, 'alarm')}"
    )


def plain_alarm(wagon: str, alarm: AlarmMessage) -> str:
    """One line of a change of an alarm."""
    seen = ", acknowledged" if alarm.acknowledged_time_s is not None else ""
    return f"{wagon}: {alarm.severity.upper()} {alarm_name(alarm)} {alarm.state}{seen}: {alarm.message}"


def alarm_name(alarm: AlarmMessage) -> str:
    """What it is and where."""
    return alarm.kind.replace("_", " ") + ("" if alarm.wheelset is None else f" wheelset {alarm.wheelset}")


def value_of(number: float | None) -> float:
    """The number to reckon with: NaN where there is none."""
    return nan if number is None else number


def life(wagon: Wagon, now_s: float) -> str:
    """Whether its daemon lives and tells anything new."""
    match state := wagon.state(now_s):
        case "silent":
            return "no estimate yet"
        case "frozen":
            return f"frozen {wagon.age_s(now_s):.0f} s"
    return state


def not_heard(only: str | None) -> str:
    """What is said while no wagon is heard, or not the one that was asked for."""
    return f"{only} is not heard yet" if only else "nobody is heard yet"


def last_said(wagon: Wagon, now_s: float) -> str:
    """What stands before values that may no longer be so."""
    return "" if wagon.is_live(now_s) else "last: "
