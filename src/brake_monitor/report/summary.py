"""A recording in words: what a person wants to know first."""

from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np

from brake_monitor.estimation.estimate import Status
from brake_monitor.monitoring.alarm import TELL_OF_SLIDES, Alarm, Severity, signals_in
from brake_monitor.report.recording import Recording
from brake_monitor.report.words import count, duration, number
from brake_monitor.settings.alarm_settings import level_of

LOUD_GAP_S = 1.0
STANDING_MPS = 1.0  # an application ends a little before standstill
NEARLY_ALL = 0.9  # of the estimates: the others are those of the beginning, and of standstill


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
        f"{duration(np.ptp(times_s))} of {recording.settings.vehicle.id}, "
        f"{number(km, 1)} km, top speed {number(top_mps * 3.6, 0)} km/h."
    )


def _brakings(recording: Recording) -> str:
    applications = recording.applications
    if not applications:
        return "No brake application was found from its beginning to its end."
    standing = sum(record.end_speed_mps < STANDING_MPS for record in applications)
    hardest = max(record.greatest_deceleration_mps2 for record in applications)
    energy_mj = sum(own.energy_j for record in applications for own in record.wheelsets) / 1e6
    return (
        f"{count(len(applications), 'brake application').capitalize()}, {standing} of them to standstill; hardest "
        f"{number(hardest, 2)} m/s² over a second; {number(energy_mj, 1)} MJ went through the pads."
    )


def _rail(recording: Recording, columns: dict[str, Any]) -> str:
    rule = recording.settings.alarms.low_adhesion
    with np.errstate(invalid="ignore"):
        told = (columns["adhesion_available"] > 0.0) & (columns["speed_mps"] > rule.min_speed_mps)
    asked = columns["adhesion_available"][told]
    period_s = float(np.median(np.diff(columns["time_s"]))) if len(told) > 1 else 0.0
    if not _slid(recording) or len(asked) == 0 or len(asked) * period_s < rule.debounce_s:  # what is shorter is a bump
        return _unasked(recording)
    least, middle = float(asked.min()), float(np.median(asked))
    level = level_of(middle, rule.levels).replace("_", " ")
    return (
        f"Where the wheels asked for more than the rail gave, it gave {number(middle, 3)} (median; {level}), "
        f"at least {number(least, 3)}."
    )


def _unasked(recording: Recording) -> str:
    """Of a recording whose estimates tell of no slide, which says nothing of the time without any."""
    if _slid(recording):
        return "Wheelsets slid, as the alarms say; what the rail gave is not known."
    if _valid_share(recording) < NEARLY_ALL:
        return (
            "While estimates were valid the wheels asked for no more than the rail gave; of the rest nothing is known."
        )
    return "The wheels never asked for more than the rail gave; how much it would have given is not known."


def _slid(recording: Recording) -> bool:
    """Whether any alarm says so: a vehicle speed that jumps makes slip for a moment, too."""
    return any(alarm.kind in TELL_OF_SLIDES for alarm in recording.alarms)


def _valid_share(recording: Recording) -> float:
    every = sum(recording.statuses.values())
    return recording.statuses[Status.VALID] / every if every else 0.0


def _frictions(recording: Recording) -> str:
    told, means = [], []
    for i in range(recording.settings.vehicle.wheelset_count):
        known = [
            (own.friction, 1.0 / own.friction_std**2)
            for record in recording.applications
            if (own := record.wheelsets[i]).friction is not None and own.friction_std
        ]
        if known:
            mean = sum(friction * weight for friction, weight in known) / sum(weight for _, weight in known)
            told.append(f"{number(mean, 3)} on wheelset {i + 1}")
            means.append(mean)
    nominal = recording.settings.estimator.friction_nominal
    if not told:
        return "Pad friction was nowhere known well enough to be told."
    hint = _shared_hint(recording, means)
    return (
        f"Pad friction was {', '.join(told)}, where what each brake application tells counts by how sure it is; "
        f"nominal is {nominal:g}.{hint}"
    )


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
        elif line.presence:
            faults.append(f"{name} is there only {line.presence}")
        elif line.longest_gap_s is not None and line.longest_gap_s > max(LOUD_GAP_S, line.channel.timeout_s):
            faults.append(f"{name} was silent for {number(line.longest_gap_s, 1)} s")
    counts = recording.decoder.counts
    for value, thing, what in (
        (counts.lost_frames, "frame", " lost, by the counter in it"),
        (counts.error_frames, "error frame", ""),
        (counts.short_frames, "frame", " too short"),
        (counts.unknown_multiplexer, "frame", " on a multiplexer page that the DBC does not describe"),
        (counts.out_of_range, "value", " out of range"),
        (counts.bad_counter, "value", " with a counter that did not advance"),
        (counts.not_available, "value", " that its sender did not have"),
    ):
        if value:
            faults.append(count(value, thing) + what)
    faults += _told_by_alarms(recording, faults)
    every = count(sum(recording.statuses.values()), "estimate")
    first = f"{number(_valid_share(recording) * 100, 1)} % of {every} are valid"
    if faults:
        return f"{first}. In the data: {'; '.join(faults)}."
    return f"{first}; {'see the remarks on the data' if recording.remarks else 'the data are without fault'}."


def _told_by_alarms(recording: Recording, faults: list[str]) -> list[str]:
    """What came and could not be used, or did not come, of signals that the faults found so far do not name."""
    told: dict[str, None] = {}
    for alarm in recording.alarms:
        for signal, condition in signals_in(alarm.evidence):
            if condition and not any(fault.startswith(f"{signal} ") for fault in faults):
                told[f"{signal} was {condition}"] = None
    return list(told)
