"""`brake-monitor check`: whether the configuration fits the DBC files, and the bus."""

import os
from argparse import ArgumentParser, Namespace
from collections.abc import Iterator
from dataclasses import asdict

import can

from brake_monitor.bus.can_log import open_log
from brake_monitor.bus.python_can_bus import could_disturb
from brake_monitor.commands import options as shared
from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.desk.progress import with_progress
from brake_monitor.digits import significant
from brake_monitor.estimation.model.wheelset import is_on_tread
from brake_monitor.frame import can_id_text
from brake_monitor.host import extras
from brake_monitor.inspection.remarks import remarks_on_mapping
from brake_monitor.inspection.traffic import SignalLine, Traffic
from brake_monitor.nearest import nearest
from brake_monitor.plural import plural
from brake_monitor.publishing.zenoh_endpoints import check_endpoints, naming_endpoints, unprotected
from brake_monitor.samples import ESSENTIAL, FLAGS
from brake_monitor.settings.config import Settings, Vehicle
from brake_monitor.settings.config_file import load_settings
from brake_monitor.settings.units import shown_unit

DESCRIPTION = """\
Validates a configuration, its DBC files and its mapping; with a recording, shows what was found in it:
every mapped signal with its rate, range and quality, and the traffic that is not mapped."""

EPILOG = """\
examples:
  brake-monitor check -c wagon.toml             is the configuration sound?
  brake-monitor check -c wagon.toml trip.log    does it fit what the bus carries?

exit code 1 when a speed, an axle speed or a pressing force has no good value in the recording"""

SHOWN_UNMAPPED = 10
VALUE_COUNTS = ("good", "out_of_range", "not_available", "bad_counter", "stale")  # `DecodeCounts`; the others: frames
NAME_WIDTH = 24  # of the column of messages and signals; longer ones widen it
GREATEST_WHEEL_RADIUS_M = 0.7  # electric locomotives have up to 0.63
# J/r^2 of a wheelset, of its share of the mass: 0.015 under a laden wagon, 0.1 under an empty one, 0.3 with motors
LEAST_TURNING_MASS, GREATEST_TURNING_MASS = 0.006, 0.32
GREATEST_DELAY_S = 1.0  # sensors and their filters lag by tenths of a second
GREATEST_TIMEOUT_S = 60.0  # where the wagon is after so long, and how fast, no last value tells


def add_options(parser: ArgumentParser) -> None:
    """Its options."""
    shared.add_config(parser)
    parser.add_argument("log", type=shared.path, nargs="?", metavar="LOG", help="a recording to look into")


def run(options: Namespace) -> int:
    """Print what was found; 1 when an essential signal is missing from the recording."""
    settings = load_settings(options.config)
    with naming_endpoints(settings.path):
        check_endpoints(settings.zenoh)
    decoder = SignalDecoder.from_settings(settings)
    print(_configuration(settings, decoder))
    if options.log is None:
        return 0
    log = open_log(options.log, settings.can)
    traffic = Traffic(decoder.channels)
    for block in with_progress(log.blocks(), log.progress, f"reading {options.log.name}"):
        traffic.see_block(block, decoder.decode_block(block))
    print()
    print(_traffic(traffic, options.log.name, decoder))
    remarks = (*log.remarks, *remarks_on_mapping(traffic, decoder, settings))
    for remark in remarks:
        print(f"remark: {remark}")
    missing = [channel for channel in decoder.channels if not traffic.found[channel.measurand].good]
    for channel in missing:
        print(f"missing: {channel.name} ({channel.bus}: {channel.source}) has no good value in this recording")
    if not (remarks or missing):
        print("nothing to remark in this recording")
    return 1 if any(channel.quantity in ESSENTIAL for channel in missing) else 0


def _configuration(settings: Settings, decoder: SignalDecoder) -> str:
    vehicle = settings.vehicle
    names = (*(channel.source for channel in decoder.channels), *(found.message for found in decoder.matchings))
    width = max(NAME_WIDTH, max(map(len, names)) + 2)
    lines = [
        f"{settings.path}: good",
        f"vehicle {vehicle.id}: {plural(vehicle.wheelset_count, 'wheelset')}, {vehicle.mass_kg:g} kg, "
        f"preset '{settings.estimator.preset}'",
        *(
            f"bus {bus.name}: {bus.interface} {bus.channel}, {', '.join(path.name for path in bus.dbc)}"
            for bus in settings.can
        ),
        "",
        f"{'quantity':<18}{'message.signal':<{width}}{'noise (1 sigma)':>18}{'time-out':>10}{'delay':>9}",
    ]
    for channel in decoder.channels:
        noise = f"{significant(channel.noise_std, 3)} {shown_unit(channel.quantity)}"
        qualifier = decoder.qualifiers.get(channel.measurand)
        lines.append(
            f"{channel.name:<18}{channel.source:<{width}}"
            f"{'-' if channel.quantity in FLAGS else noise:>18}{channel.timeout_s:>8.2f} s{channel.delay_s:>7.3f} s"
            + ("" if qualifier is None else f"  used while {qualifier}")
        )
    lines += ["", f"{'message':<{width}}frames taken for it"]
    several = len(settings.can) > 1
    lines += [
        f"{matching.message:<{width}}{matching}{f' on bus {matching.bus}' if several else ''}"
        for matching in decoder.matchings
    ]
    lines += [f"remark: {remark}" for remark in (*_doubts(settings), *decoder.remarks)]
    return "\n".join(lines)


def _doubts(settings: Settings) -> Iterator[str]:
    """What is right on some vehicles or computers, and more often a slip of the pen."""
    vehicle, tls = settings.vehicle, settings.zenoh.tls
    for name, path in tls.files.items() if tls is not None else ():
        if not os.access(path, os.R_OK):
            yield f"zenoh.tls.{name}: {path} cannot be read here; where the daemon runs it must be"
    if settings.metrics.port and not extras.is_installed("metrics"):
        yield f"metrics.port: the daemon needs the extra 'metrics' for it: {extras.how_to_install('metrics')}"
    yield from unprotected(settings.zenoh)
    if (radius_m := max(vehicle.wheel_radius_m)) > GREATEST_WHEEL_RADIUS_M:
        yield f"vehicle.wheel_radius_m: {radius_m:g} m is more than railway wheels have; is it the diameter?"
    for brake_m, wheel_m in sorted(set(zip(vehicle.brake_radius_m, vehicle.wheel_radius_m, strict=True))):
        if brake_m > wheel_m:
            yield (
                f"vehicle.brake_radius_m: {brake_m:g} m is more than the wheel's {wheel_m:g} m, "
                "which only discs on geared shafts have"
            )
    yield from _on_inertia(vehicle)
    yield from _on_times(settings)
    yield from _on_blocks(settings)
    yield from _on_buses(settings)


def _on_inertia(vehicle: Vehicle) -> Iterator[str]:
    """A power of ten is easily lost in it, and slides would be told wrong."""
    share_kg = vehicle.mass_kg / vehicle.wheelset_count
    for inertia, turning_kg in sorted(set(zip(vehicle.wheelset_inertia_kgm2, vehicle.turning_kg, strict=True))):
        if not LEAST_TURNING_MASS < turning_kg / share_kg < GREATEST_TURNING_MASS:
            yield (
                f"vehicle.wheelset_inertia_kgm2: {inertia:g} kg m2 at this wheel radius stand for {turning_kg:.0f} kg "
                f"of the {share_kg:.0f} kg on each wheelset; wheelsets stand for 1 to 10 %, with motors for up to 30 %"
            )


def _on_times(settings: Settings) -> Iterator[str]:
    """Times that are right in milliseconds."""
    for quantity, place, mapping in settings.signals.mapped():
        key = f"signals.{quantity}" + ("" if place is None else f"[{place + 1}]")
        if mapping.delay_s > GREATEST_DELAY_S:
            yield f"{key}.delay_s: {mapping.delay_s:g} s is more than sensors lag; is it in milliseconds?"
        if mapping.timeout_s is not None and mapping.timeout_s > GREATEST_TIMEOUT_S:
            yield (
                f"{key}.timeout_s: for {mapping.timeout_s:g} s a value that is lost would count as good; "
                "is it in milliseconds?"
            )


def _on_blocks(settings: Settings) -> Iterator[str]:
    """Blocks on the tread rub the less the faster the wheel turns: `wagon` has to know, to `train` it is too much."""
    vehicle, estimator = settings.vehicle, settings.estimator
    radii_m = zip(vehicle.brake_radius_m, vehicle.wheel_radius_m, strict=True)
    on_tread = all(is_on_tread(brake_m, wheel_m) for brake_m, wheel_m in radii_m)
    if not on_tread:
        return
    if estimator.preset == "wagon" and estimator.tuning.friction is None:
        yield (
            "vehicle.brake_radius_m: pads at the wheel's radius are blocks, whose friction rises as they slow down by "
            "so much that a part of it would be taken for the line: set estimator.tuning.friction, to 3e-5 for LL "
            "blocks, 1e-4 for K blocks, 4e-4 for cast iron"
        )
    if estimator.preset == "train" and estimator.tuning.friction is not None:
        yield (
            'estimator.tuning.friction: what blocks need by themselves leaves hardly any friction valid with "train": '
            "leave it out"
        )


def _on_buses(settings: Settings) -> Iterator[str]:
    """What the daemon would refuse, unless it runs elsewhere."""
    for bus in settings.can:
        if bus.interface not in can.VALID_INTERFACES:
            hint = nearest(bus.interface, sorted(can.VALID_INTERFACES))
            yield f'bus {bus.name}: python-can has no interface "{bus.interface}" here, {hint}'
        elif bus.interface != "socketcan" and could_disturb(bus):
            yield (
                f"bus {bus.name}: nobody can tell whether {bus.interface} only listens: "
                "the daemon wants allow_active = true"
            )


def _traffic(traffic: Traffic, name: str, decoder: SignalDecoder) -> str:
    """Rates, ranges and qualities of what is mapped, and the rest in short."""
    counts = {key: value for key, value in asdict(decoder.counts).items() if value}
    of_values = [_count(counts, key) for key in VALUE_COUNTS if key in counts]
    of_frames = [_count(counts, key) for key in counts if key not in VALUE_COUNTS]
    parts = (f"{traffic.duration_s:.1f} s", ", ".join(of_frames), of_values and f"values: {', '.join(of_values)}")
    lines = [
        f"{name}: " + "; ".join(part for part in parts if part),
        "",
        f"{'quantity':<17}{'values':>8}{'period':>10}{'longest gap':>12}{'least':>11}{'greatest':>11}  {'unit':<6}bad",
    ]
    for line in traffic.lines(decoder):
        span = "".join(f"{'-' if end is None else significant(end, 5):>11}" for end in (line.least, line.greatest))
        period = "-" if line.period_s is None else f"{line.period_s * 1000:.1f} ms"
        gap = "-" if line.longest_gap_s is None else f"{line.longest_gap_s:.3f} s"
        only = f"  there only {line.presence}" if line.presence else ""
        lines.append(
            f"{line.channel.name:<17}{line.values:>8}"
            f"{period:>10}{gap:>12}{span}  {shown_unit(line.channel.quantity):<6}{_not_good(line, decoder)}{only}"
        )
    frames, ids = plural(traffic.unmapped.total(), "frame"), plural(len(traffic.unmapped), "id")
    lines.append(f"\n{frames} of {ids} without a mapped value")
    extended_ones = {(matching.bus, matching.message) for matching in decoder.matchings if matching.extended}
    mapped = {
        (channel.bus, (channel.bus, channel.message) in extended_ones, can_id): channel.message
        for channel in decoder.channels
        for can_id in traffic.found[channel.measurand].can_ids
    }
    for (bus, extended, can_id), count in traffic.unmapped.most_common(SHOWN_UNMAPPED):
        message = mapped.get((bus, extended, can_id))
        of = "" if message is None else f", of {message} without its mapped signals"
        lines.append(f"  {bus} {can_id_text(can_id, extended)}: {count}{of}")
    if len(traffic.unmapped) > SHOWN_UNMAPPED:
        lines.append(f"  and {len(traffic.unmapped) - SHOWN_UNMAPPED} more")
    return "\n".join(lines)


def _count(counts: dict[str, int], key: str) -> str:
    return f"{key.replace('_', ' ')} {counts[key]}"


def _not_good(line: SignalLine, decoder: SignalDecoder) -> str:
    """How many values were bad, and how."""
    told = [f"{quality} {count}" for quality, count in line.not_good.items()]
    qualifier = decoder.qualifiers.get(line.channel.measurand)
    if qualifier is not None and qualifier.rejected:
        told.append(f"{qualifier.rejected} of them by {qualifier.field.name}")
    return ", ".join(told) or "-"
