"""`brake-monitor check`: whether the configuration fits the DBC files, and the bus."""

from argparse import ArgumentParser, Namespace, RawDescriptionHelpFormatter, _SubParsersAction
from array import array
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from itertools import pairwise
from math import inf
from pathlib import Path
from statistics import median

from brake_monitor.can_log import open_log
from brake_monitor.commands import options as shared
from brake_monitor.config import Settings
from brake_monitor.config_file import load_settings
from brake_monitor.frame import Frame, FrameKind
from brake_monitor.j1939 import pgn_bits
from brake_monitor.progress import with_progress
from brake_monitor.signals import Channel, Quality, Quantity, Sample, SignalDecoder
from brake_monitor.zenoh_session import check_endpoints

DESCRIPTION = """\
Validates a configuration, its DBC files and its mapping; with a recording, shows what was found in it:
every mapped signal with its rate, range and quality, and the traffic that is not mapped."""

EXAMPLES = """\
examples:
  brake-monitor check -c wagon.toml             is the configuration sound?
  brake-monitor check -c wagon.toml trip.log    does it fit what the bus carries?

exit code 1 when a speed, an axle speed or a pressing force has no good value in the recording"""

SHOWN_UNMAPPED = 10
SHOWN_IDS = 4
ESSENTIAL = (Quantity.SPEED, Quantity.AXLE_SPEED, Quantity.PRESSING_FORCE)

UNITS = {
    Quantity.SPEED: "m/s",
    Quantity.AXLE_SPEED: "rad/s",
    Quantity.PRESSING_FORCE: "N",
    Quantity.LOAD_FORCE: "N",
    Quantity.WHEEL_TORQUE: "N m",
    Quantity.LATITUDE: "°",
    Quantity.LONGITUDE: "°",
}


def add_parser(subparsers: "_SubParsersAction[ArgumentParser]") -> None:
    """Describe the command."""
    parser = subparsers.add_parser(
        "check",
        help="validate a configuration, its DBC and its mapping",
        description=DESCRIPTION,
        epilog=EXAMPLES,
        formatter_class=RawDescriptionHelpFormatter,
    )
    shared.add_config(parser)
    parser.add_argument("log", type=Path, nargs="?", metavar="LOG", help="a recording to look into")
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Print what was found; 1 when an essential signal is missing from the recording."""
    settings = load_settings(options.config)
    check_endpoints(settings.zenoh)  # certificates may be on the gateway only
    decoder = SignalDecoder.from_settings(settings)
    print(_configuration(settings, decoder))
    if options.log is None:
        return 0
    log = open_log(options.log, settings.can)
    traffic = Traffic()
    for frame in with_progress(log, log.progress, f"reading {options.log.name}"):
        traffic.see(frame, decoder.decode(frame))
    print()
    print(traffic.text(options.log.name, decoder))
    for remark in (*log.remarks, *traffic.doubts(decoder)):
        print(f"remark: {remark}")
    missing = [channel for channel in decoder.channels if not traffic.found[channel.quantity, channel.wheelset].good]
    for channel in missing:
        print(f"missing: {_place(channel)} has no good value in this recording")
    return 1 if any(channel.quantity in ESSENTIAL for channel in missing) else 0


def _place(channel: Channel) -> str:
    return f"{channel.quantity} {channel.wheelset + 1} ({channel.bus}: {channel.message}.{channel.signal})"


def _configuration(settings: Settings, decoder: SignalDecoder) -> str:
    vehicle = settings.vehicle
    lines = [
        f"{settings.path}: good",
        f"vehicle {vehicle.id}: {vehicle.wheelset_count} wheelset(s), {vehicle.mass_kg:g} kg, "
        f"preset '{settings.estimator.preset}'",
        *(
            f"bus {bus.name}: {bus.interface} {bus.channel}, {', '.join(path.name for path in bus.dbc)}"
            for bus in settings.can
        ),
        "",
        f"{'quantity':<18}{'message.signal':<34}{'noise (1 sigma)':>18}{'time-out':>10}{'delay':>9}",
    ]
    for channel in decoder.channels:
        unit = UNITS.get(channel.quantity, "")
        lines.append(
            f"{channel.quantity + ' ' + str(channel.wheelset + 1):<18}{channel.message + '.' + channel.signal:<34}"
            f"{f'{channel.noise_std:.3g} {unit}':>18}{channel.timeout_s:>8.2f} s{channel.delay_s:>7.3f} s"
        )
    lines += ["", f"{'message':<34}frames taken for it"]
    several = len(settings.can) > 1
    lines += [
        f"{matching.message:<34}{matching}{f' on bus {matching.bus}' if several else ''}"
        for matching in decoder.matchings
    ]
    lines += [f"remark: {remark}" for remark in decoder.remarks]
    return "\n".join(lines)


@dataclass
class Found:
    """What one channel showed in a recording."""

    times_s: "array[float]" = field(default_factory=lambda: array("d"))
    can_ids: set[int] = field(default_factory=set)
    least: float = inf
    greatest: float = -inf
    good: int = 0
    bad: Counter[Quality] = field(default_factory=Counter)

    def see(self, sample: Sample, can_id: int) -> None:
        """Take a sample and the identifier of the frame that it came in."""
        self.times_s.append(sample.time_s)
        self.can_ids.add(can_id)
        if sample.quality is not Quality.GOOD:
            self.bad[sample.quality] += 1
            return
        self.good += 1
        self.least = min(self.least, sample.value)
        self.greatest = max(self.greatest, sample.value)


class Traffic:
    """What a recording carries."""

    def __init__(self) -> None:
        self.found: defaultdict[tuple[Quantity, int], Found] = defaultdict(Found)
        self._unmapped: Counter[tuple[str, bool, int]] = Counter()
        self._first_s = inf
        self._last_s = -inf

    def see(self, frame: Frame, samples: list[Sample]) -> None:
        """Take a frame and what was decoded from it."""
        self._first_s = min(self._first_s, frame.time_s)
        self._last_s = max(self._last_s, frame.time_s)
        for sample in samples:
            self.found[sample.quantity, sample.wheelset].see(sample, frame.can_id)
        if not samples and frame.kind is FrameKind.DATA:
            self._unmapped[frame.bus, frame.extended, frame.can_id] += 1

    def text(self, name: str, decoder: SignalDecoder) -> str:
        """Rates, ranges and qualities of what is mapped, and the rest in short."""
        counts = {key: value for key, value in asdict(decoder.counts).items() if value}
        lines = [
            f"{name}: {self._last_s - self._first_s:.1f} s; " + ", ".join(f"{k} {v}" for k, v in counts.items()),
            "",
            f"{'quantity':<18}{'values':>9}{'period':>11}{'longest gap':>13}{'least':>12}{'greatest':>12}  not good",
        ]
        for channel in decoder.channels:
            found = self.found[channel.quantity, channel.wheelset]
            gaps = [b - a for a, b in pairwise(found.times_s)] or [0.0]
            span = f"{found.least:>12.5g}{found.greatest:>12.5g}" if found.good else f"{'-':>12}{'-':>12}"
            bad = ", ".join(f"{quality.name.lower()} {count}" for quality, count in sorted(found.bad.items()))
            lines.append(
                f"{channel.quantity + ' ' + str(channel.wheelset + 1):<18}{len(found.times_s):>9}"
                f"{median(gaps) * 1000:>8.1f} ms{max(gaps):>11.3f} s{span}  {bad or '-'}"
            )
        lines.append(f"\n{sum(self._unmapped.values())} frames of {len(self._unmapped)} ids without a mapped value")
        for (bus, extended, can_id), count in self._unmapped.most_common(SHOWN_UNMAPPED):
            lines.append(f"  {bus} {_number(can_id, extended)}: {count}")
        return "\n".join(lines)

    def doubts(self, decoder: SignalDecoder) -> Iterator[str]:
        """What makes one doubt that the right frames were taken for a message."""
        heard: defaultdict[tuple[str, str], set[int]] = defaultdict(set)
        for channel in decoder.channels:
            heard[channel.bus, channel.message] |= self.found[channel.quantity, channel.wheelset].can_ids
        for matching in decoder.matchings:
            senders = heard[matching.bus, matching.message]
            if len(senders) > 1:
                yield (
                    f"{matching.message} came under {len(senders)} ids, as several senders do: {_listed(senders)}; "
                    'match = "id" in the mapping takes only the one in the DBC'
                )
            others = [(extended, can_id) for bus, extended, can_id in self._unmapped if bus == matching.bus]
            if (not matching.extended, matching.can_id) in others:
                yield (
                    f"{_number(matching.can_id, not matching.extended)} is on the bus and not mapped, while the DBC "
                    f"gives {matching.message} this number with {29 if matching.extended else 11} bits"
                )
            if matching.by == "id" and matching.extended and not senders:
                near = {c for extended, c in others if extended and pgn_bits(c) == pgn_bits(matching.can_id)}
                if near:
                    yield (
                        f"{matching.message} never came, but its PGN did, under {_listed(near)}; if the bus is J1939, "
                        'say match = "pgn" in the mapping'
                    )


def _number(can_id: int, extended: bool) -> str:
    return f"{can_id:08X}" if extended else f"{can_id:03X}"


def _listed(can_ids: set[int]) -> str:
    shown = [_number(can_id, extended=True) for can_id in sorted(can_ids)[:SHOWN_IDS]]
    return ", ".join(shown) + (" ..." if len(can_ids) > SHOWN_IDS else "")
