"""The report in words: what a person reads first, and how times and values are written."""

from collections import Counter
from collections.abc import Iterator
from datetime import UTC, datetime
from math import isfinite
from typing import Any

import numpy as np

from brake_monitor.estimation.estimate import Status
from brake_monitor.inspection.traffic import SignalLine
from brake_monitor.monitoring.alarm import Alarm, Severity
from brake_monitor.publishing.payload_schemas import UNITS
from brake_monitor.report.recording import Recording

LEAST_UNIX_S = 1e8  # what is smaller is no date but seconds from some beginning
LOUD_GAP_S = 1.0
SHARES = {"apart", "change", "creep", "slip"}  # words of names whose values are shares of something
PREFIXES = dict.fromkeys(("J", "N", "N m"), ((1e6, "M"), (1e3, "k")))  # from which factor on
STANDING_MPS = 1.0  # a stop ends a little before standstill


def number(value: float | None, decimals: int) -> str:
    """Fixed-point with a proper minus sign; a dash when there is no number."""
    if value is None or not isfinite(value):
        return "–"
    text = f"{value:.{decimals}f}"
    return text.replace("-", "") if float(text) == 0.0 else text.replace("-", "−")


def count(value: float, word: str) -> str:
    """`1 alarm`, `3 alarms`, `no alarms`."""
    return f"{'no' if value == 0 else grouped(value)} {word}{'' if value == 1 else 's'}"


def elapsed(seconds: float) -> str:
    """`1:02:03.4`, or `2:03.4` below an hour."""
    tenths = round(abs(seconds) * 10)
    minutes, rest = divmod(tenths, 600)
    hours, minutes = divmod(minutes, 60)
    shown = f"{hours}:{minutes:02}:{rest / 10:04.1f}" if hours else f"{minutes}:{rest / 10:04.1f}"
    return f"−{shown}" if seconds < 0 and tenths else shown


def duration(seconds: float) -> str:
    """`42 s`, `1 min 57 s`, `1 h 2 min`."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    return f"{whole // 60} min {whole % 60} s" if whole < 3600 else f"{whole // 3600} h {whole % 3600 // 60} min"


def present(line: SignalLine) -> str:
    """`from 376 to 387 s`; nothing where a signal is there in all of the recording."""
    return "" if line.present_only_s is None else "from {:.0f} to {:.0f} s".format(*line.present_only_s)


def grouped(value: float) -> str:
    """A whole number with thin groups of three digits: `12 345`."""
    return f"{value:,.0f}".replace(",", " ")


def date(time_s: float) -> str:
    """Date and time, UTC; seconds where the recording has no date."""
    if time_s < LEAST_UNIX_S:
        return f"{time_s:.1f} s"
    return datetime.fromtimestamp(time_s, UTC).strftime("%Y-%m-%d %H:%M:%S UTC")


def described(name: str, value: Any) -> tuple[str, str]:
    """A value of an alarm's evidence in words with its unit: `speed_start_mps`, 21.3 → `speed start`, `21.3 m/s`."""
    parts = name.split("_")
    place = next((k for k in (len(parts) - 1, len(parts) - 2) if k > 0 and parts[k] in UNITS), None)
    unit = "" if place is None else UNITS[parts.pop(place)]
    words = " ".join(parts)
    if not isinstance(value, int | float) or isinstance(value, bool):
        return words, "–" if value is None else str(value)
    if unit == "s" and value > LEAST_UNIX_S:
        return words, date(value)
    if unit == "°":
        return words, f"{number(value, 6)} °"
    if not unit and not SHARES.isdisjoint(parts):
        value, unit = 100.0 * value, "%"
    for factor, prefix in PREFIXES.get(unit, ()):
        if abs(value) >= factor:
            value, unit = value / factor, prefix + unit
            break
    decimals = 0 if float(value).is_integer() or abs(value) >= 100 else 1 if abs(value) >= 10 else 3
    return words, f"{number(value, decimals)} {unit}".strip()


def title(alarm: Alarm) -> str:
    """`Low adhesion`, `Hot disc, wheelset 2`."""
    words = alarm.kind.replace("_", " ").capitalize()
    return words if alarm.wheelset is None else f"{words}, wheelset {alarm.wheelset}"


def summary(recording: Recording) -> Iterator[str]:
    """What a person wants to know first, a sentence or two each."""
    columns = recording.curves.columns(recording.curves.table())
    if not np.isfinite(columns["speed_mps"]).any():
        yield "Nothing could be estimated from this recording."
        yield _quality(recording)
        return
    yield _journey(recording, columns)
    yield _brakings(recording)
    yield _rail(recording, columns)
    yield _frictions(recording)
    yield _alarms(recording)
    yield _quality(recording)


def _journey(recording: Recording, columns: dict[str, Any]) -> str:
    times_s, speeds = columns["time_s"], columns["speed_mps"]
    top_mps = float(np.nanmax(speeds))
    km = (columns["distance_m"][-1] - columns["distance_m"][0]) / 1000.0
    return (
        f"{duration(times_s[-1] - times_s[0])} of {recording.settings.vehicle.id}, "
        f"{number(km, 1)} km, top speed {number(top_mps * 3.6, 0)} km/h."
    )


def _brakings(recording: Recording) -> str:
    stops = recording.stops
    if not stops:
        return "No brake application was found from its beginning to its end."
    standing = sum(stop.end_speed_mps < STANDING_MPS for stop in stops)
    hardest = max(stop.greatest_deceleration_mps2 for stop in stops)
    energy_mj = sum(own.energy_j for stop in stops for own in stop.wheelsets) / 1e6
    return (
        f"{count(len(stops), 'brake application').capitalize()}, {standing} of them to standstill; hardest "
        f"{number(hardest, 2)} m/s² over a second; {number(energy_mj, 1)} MJ went through the pads."
    )


def _rail(recording: Recording, columns: dict[str, Any]) -> str:
    rule = recording.settings.alarms.low_adhesion
    with np.errstate(invalid="ignore"):
        told = (columns["saturated"] == 1.0) & (columns["speed_mps"] > rule.min_speed_mps) & (columns["adhesion"] > 0.0)
    asked, period_s = columns["adhesion"][told], float(np.median(np.diff(columns["time_s"]))) if len(told) > 1 else 0.0
    if len(asked) == 0 or len(asked) * period_s < rule.debounce_s:  # what is shorter is a bump
        return "The wheels never asked for more than the rail gave; how much it would have given is not known."
    least, middle = float(asked.min()), float(np.median(asked))
    levels = ((rule.extremely_low, "extremely low"), (rule.very_low, "very low"), (rule.low, "low"))
    level = next((name for limit, name in levels if middle < limit), "normal")
    return (
        f"Where the wheels asked for more than the rail gave, it gave {number(middle, 3)} (median; {level}), "
        f"at least {number(least, 3)}."
    )


def _frictions(recording: Recording) -> str:
    told, means = [], []
    for i in range(recording.settings.vehicle.wheelset_count):
        known = [
            (own.friction, own.friction_energy_j)
            for stop in recording.stops
            if (own := stop.wheelsets[i]).friction is not None and own.friction_energy_j > 0.0
        ]
        if known:
            mean = sum(friction * energy_j for friction, energy_j in known) / sum(energy_j for _, energy_j in known)
            told.append(f"{number(mean, 3)} on wheelset {i + 1}")
            means.append(mean)
    nominal = recording.settings.estimator.friction_nominal
    if not told:
        return "Pad friction was nowhere known well enough to be told."
    hint = _shared_hint(recording, means)
    return f"Pad friction, weighted by energy, was {', '.join(told)}; nominal is {nominal:g}.{hint}"


def _shared_hint(recording: Recording, frictions: list[float]) -> str:
    """What to think of frictions that are alike while an alarm says that the brakes are not."""
    uneven = sorted({one.wheelset or 0 for one in recording.alarms if one.kind == "uneven_braking" and _alike(one)})
    least_apart = recording.settings.alarms.uneven_braking.warning
    if not uneven or len(frictions) < 2 or max(frictions) > (1.0 + least_apart) * min(frictions):
        return ""
    which = f"wheelset{'s' if len(uneven) > 1 else ''} {', '.join(map(str, uneven))}"
    return (
        " Brakes that press alike share what friction is missing or too much: only how far their wheelsets creep tells "
        f"whose it is, see the alarm “Uneven braking” of {which}."
    )


def _alike(uneven: Alarm) -> bool:
    """Whether the brakes pressed alike, so that it is not the force that an uneven torque comes from."""
    force, torque = (uneven.evidence.get(f"{name}_apart") for name in ("pressing_force", "torque"))
    return not (isinstance(force, float) and isinstance(torque, float) and abs(force) > 0.5 * abs(torque))


def _alarms(recording: Recording) -> str:
    if not recording.alarms:
        return "No alarms."
    by = Counter(alarm.severity for alarm in recording.alarms)
    parts = [f"{by[severity]} {severity}" for severity in reversed(Severity) if by[severity]]
    kinds = Counter(alarm.kind.replace("_", " ") for alarm in recording.alarms).most_common(4)
    still = sum(alarm.cleared_time_s is None for alarm in recording.alarms)
    open_ = f"; {still} still open at the end" if still else ""
    shown = ", ".join(f"{kind} {times}×" if times > 1 else kind for kind, times in kinds)
    return f"{count(len(recording.alarms), 'alarm').capitalize()} ({', '.join(parts)}): {shown}{open_}."


def _quality(recording: Recording) -> str:
    faults = []
    for line in recording.traffic.lines(recording.decoder):
        name = line.channel.source
        if line.least is None:
            faults.append(f"{name} has no good value")
        elif line.present_only_s is not None:
            faults.append(f"{name} is there only {present(line)}")
        elif line.longest_gap_s is not None and line.longest_gap_s > max(LOUD_GAP_S, line.channel.timeout_s):
            faults.append(f"{name} was silent for {number(line.longest_gap_s, 1)} s")
    counts = recording.decoder.counts
    for value, words in (
        (counts.lost_frames, "frame lost by its counter"),
        (counts.error_frames, "error frame"),
        (counts.short_frames, "frame too short"),
        (counts.out_of_range, "value out of range"),
    ):
        if value:
            faults.append(count(value, words) if "by" not in words else f"{value} frames lost by their counters")
    every = sum(recording.statuses.values())
    share = recording.statuses[Status.VALID] / every if every else 0.0
    first = f"{number(share * 100, 1)} % of {grouped(every)} estimates are valid"
    return f"{first}; the data are without fault." if not faults else f"{first}. In the data: {'; '.join(faults)}."
