"""The tables of a report, as HTML. Every text that is not ours is escaped here."""

import dataclasses
from collections.abc import Iterable, Sequence
from html import escape
from math import inf, isfinite

import msgspec
from msgspec.structs import asdict

from brake_monitor.digits import significant
from brake_monitor.estimation.estimate import INTERVAL_SIGMAS
from brake_monitor.frame import can_id_text
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.monitoring.brake_units.wear import energy_loss_mm, pad_life
from brake_monitor.report.recording import Recording
from brake_monitor.report.words import count, date, described, elapsed, grouped, number, title
from brake_monitor.settings.units import shown_unit

UNMAPPED_SHOWN = 30
SHAPES = {"info": "M8 1a7 7 0 1 0 .001 0z", "warning": "M8 1l7.500 14H.5z", "alarm": "M5 0h6l5 5v6l-5 5H5l-5-5V5z"}


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]], kind: str = "") -> str:
    """Cells are HTML already; heads are text."""
    head = "".join(f"<th scope=col>{escape(text)}</th>" for text in heads)
    body = "".join(f"<tr>{''.join(f'<td>{cell}</td>' for cell in row)}</tr>" for row in rows)
    table = f'<table class="report {kind}"><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>'
    return f'<div class="wide">{table}</div>'


def _look(from_s: float, to_s: float, begun_s: float, text: str) -> str:
    """A button that shows a stretch of time in the figures."""
    return (
        f'<button type=button data-from="{from_s - begun_s:.1f}" data-to="{to_s - begun_s:.1f}">{escape(text)}</button>'
    )


def applications(recording: Recording) -> str:
    """Every brake application."""
    if not recording.applications:
        return "<p class=muted>None was found from its beginning to its end.</p>"
    numbers = range(1, recording.settings.vehicle.wheelset_count + 1)
    heads = ["from", "lasts, s", "speed, km/h", "way, m", "hardest, m/s²", "adhesion in use, at most"]
    for i in numbers:
        heads += [f"{i}: friction ± (95 %)", f"{i}: energy, MJ", f"{i}: slid, m", f"{i}: WSP actions", f"{i}: disc, °C"]
    rows, begun_s = [], recording.begun_s
    for record in recording.applications:
        row = [
            _look(record.start_time_s - 3.0, record.end_time_s + 3.0, begun_s, elapsed(record.start_time_s - begun_s)),
            number(record.end_time_s - record.start_time_s, 1),
            f"{number(record.start_speed_mps * 3.6, 1)} → {number(record.end_speed_mps * 3.6, 1)}",
            number(record.distance_m, 0),
            number(record.greatest_deceleration_mps2, 2),
            number(record.greatest_adhesion, 3),
        ]
        told = recording.forces_told(record.start_time_s, record.end_time_s)
        for own, force_told in zip(record.wheelsets, told, strict=True):
            doubt = "" if own.friction_std is None else f" ± {number(INTERVAL_SIGMAS * own.friction_std, 3)}"
            row += [
                number(own.friction, 3) + doubt,
                number(own.energy_j / 1e6, 2) if force_told else "–",
                number(own.sliding_distance_m, 1) if force_told else "–",
                str(own.wsp_actions),
                number(own.peak_disc_temperature_c, 0) if force_told else "–",
            ]
        rows.append(row)
    return _table(heads, rows, "numbers")


def alarms(recording: Recording) -> str:
    """Every alarm with its sentence and evidence."""
    if not recording.alarms:
        return "<p class=muted>None.</p>"
    begun_s = recording.begun_s
    return f'<ul class="alarms">{"".join(_alarm(alarm, begun_s) for alarm in recording.alarms)}</ul>'


def _alarm(alarm: Alarm, begun_s: float) -> str:
    shape = f'<svg viewBox="0 0 16 16" aria-hidden=true><path d="{SHAPES[alarm.severity]}"/></svg>'
    end_s = alarm.cleared_time_s
    until = "open at the end" if end_s is None else f"for {number(end_s - alarm.raised_time_s, 1)} s"
    shown_to_s = alarm.raised_time_s + 30.0 if end_s is None else end_s
    look = _look(alarm.raised_time_s - 10.0, shown_to_s + 5.0, begun_s, elapsed(alarm.raised_time_s - begun_s))
    facts = "".join(
        f"<dt>{escape(words)}</dt><dd>{escape(text)}</dd>"
        for words, text in (described(name, value) for name, value in alarm.evidence.items())
    )
    evidence = f"<details><summary>Evidence</summary><dl>{facts}</dl></details>" if facts else ""
    name = f"{escape(title(alarm))}<span class=unseen> ({alarm.severity})</span>"
    first = f'<span class="mark {alarm.severity}">{shape}<span>{name}</span></span>'
    return (
        f'<li><div class="first">{first}<span class="time">{look} {escape(until)}</span></div>'
        f"<p>{escape(alarm.message)}</p>{evidence}</li>"
    )


def wear(recording: Recording) -> str:
    """What the recording cost the pads; thickness as if they were new at its beginning."""
    settings = recording.settings.wear
    told = recording.forces_told(-inf, inf)
    rows = []
    for i, unit in enumerate(recording.pipeline.brake_book.brakes.units, 1):
        if not told[i - 1]:  # an input that was never heard is not zero
            rows.append([str(i), *"–––––––"])
            continue
        pads, life = unit.pads, pad_life(unit.pads, settings)
        lost_mm = energy_loss_mm(pads.since_fitted.energy_j, pads.specific_wear_cm3_per_mj.value, settings)
        peaks_c = [record.wheelsets[i - 1].peak_disc_temperature_c for record in recording.applications]
        hottest = max(peaks_c, default=None)
        stops_left = "–" if life.remaining_stops is None else grouped(life.remaining_stops)
        km_left = "–" if life.remaining_km is None else grouped(life.remaining_km)
        rows.append(
            [
                str(i),
                number(pads.since_fitted.energy_j / 1e6, 2),
                number(lost_mm * 1000.0, 2),
                number((settings.new_pad_thickness_mm - life.by_archard.value_mm) * 1000.0, 2),
                number(pads.since_fitted.sliding_distance_m, 1),
                number(hottest, 0),
                stops_left,
                km_left,
            ]
        )
    heads = [
        "wheelset",
        "pad energy, MJ",
        "lost by energy, µm",
        "lost by Archard's law, µm",
        "slid on the rail, m",
        "hottest disc, °C",
    ]
    return _table([*heads, "new pads last, stops", "new pads last, km"], rows, "numbers")


def signals(recording: Recording) -> str:
    """Rates, gaps and qualities of what is mapped."""
    rows = []
    for line in recording.traffic.lines(recording.decoder):
        channel = line.channel
        bad = ", ".join(f"{escape(quality.replace('_', ' '))} {times}" for quality, times in line.not_good.items())
        unit = shown_unit(channel.quantity)
        gap = "–" if line.longest_gap_s is None else f"{number(line.longest_gap_s, 3)} s"
        if line.presence:
            gap += f", there only {line.presence}"
        rows.append(
            [
                escape(channel.name.replace("_", " ")),
                escape(channel.source),
                grouped(line.values),
                "–" if line.period_s is None else f"{number(line.period_s * 1000.0, 1)} ms",
                f"<b class=bad>{gap}</b>" if line.is_late else gap,
                f"{_short(line.least)} – {_short(line.greatest)} {unit}" if line.least is not None else "–",
                f"<b class=bad>{bad}</b>" if bad else "–",
            ]
        )
    return _table(["quantity", "signal", "values", "period (median)", "longest gap", "range", "not good"], rows)


def _short(value: float | None) -> str:
    return "–" if value is None or not isfinite(value) else significant(value, 5).replace("-", "−")


def frames(recording: Recording) -> str:
    """What was counted of frames, and the ids that nothing is mapped of."""
    counted = "".join(
        f"<dt>{escape(name.replace('_', ' '))}</dt><dd>{grouped(value)}</dd>"
        for name, value in dataclasses.asdict(recording.decoder.counts).items()
    )
    unmapped = recording.traffic.unmapped.most_common()
    shown = [
        [escape(bus), f"<code>{can_id_text(can_id, extended)}</code>", grouped(times)]
        for (bus, extended, can_id), times in unmapped[:UNMAPPED_SHOWN]
    ]
    more = f"<p class=muted>… and {len(unmapped) - UNMAPPED_SHOWN} more.</p>" if len(unmapped) > UNMAPPED_SHOWN else ""
    ids = _table(["bus", "id", "frames"], shown) + more if shown else "<p class=muted>None: every id is mapped.</p>"
    remarks = "".join(f"<li>{escape(remark)}</li>" for remark in recording.remarks)
    said = f"<h3>Remarks</h3><ul class=dots>{remarks}</ul>" if remarks else ""
    return (
        f'<div class=two><div><h3>Frames</h3><dl class="facts">{counted}</dl></div>'
        f"<div><h3>Ids without a mapped value</h3>{ids}</div></div>{said}"
    )


def settings(recording: Recording, source: str) -> str:
    """The configuration as it was written, and every value that was in force, defaults included."""
    in_force = {name: value for name, value in asdict(recording.settings).items() if name != "path"}
    text = msgspec.json.format(msgspec.json.encode(msgspec.to_builtins(in_force, enc_hook=str)), indent=2).decode()
    return (
        f"<details><summary>The configuration as it is written</summary><pre>{escape(source)}</pre></details>"
        f"<details><summary>Every setting in force, defaults included</summary><pre>{escape(text)}</pre></details>"
    )


def facts(recording: Recording) -> str:
    """The head of the report."""
    vehicle = recording.settings.vehicle
    pairs = [
        ("Begins", date(recording.begun_s)),
        ("Ends", date(recording.ended_s)),
        ("Vehicle", f"{count(vehicle.wheelset_count, 'wheelset')}, {grouped(vehicle.mass_kg)} kg"),
        ("Preset", recording.settings.estimator.preset),
    ]
    return "".join(f"<dt>{escape(name)}</dt><dd>{escape(text)}</dd>" for name, text in pairs)
