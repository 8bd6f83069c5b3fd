"""What in a recording makes one doubt its mapping: remarks on identifiers, units, times, counters and rates."""

from collections import defaultdict
from collections.abc import Iterator
from math import inf

import numpy as np

from brake_monitor.decoding.j1939 import pgn_bits
from brake_monitor.decoding.routing import CYCLES_TO_TIMEOUT
from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.estimation.doubts.force_timing import EARLY_S
from brake_monitor.estimation.held_input import PROMPT_S
from brake_monitor.frame import can_id_text
from brake_monitor.inspection.batches import batches
from brake_monitor.inspection.coarse import remarks_on_steps
from brake_monitor.inspection.force_lag import obeyed_forces
from brake_monitor.inspection.force_size import remarks_on_forces, remarks_on_load
from brake_monitor.inspection.pulled import remarks_on_pull
from brake_monitor.inspection.repeated import remarks_on_repetitions
from brake_monitor.inspection.speed_lag import LEAST_LAG_S, UNSURE, speed_lag_s
from brake_monitor.inspection.traffic import Found, Traffic
from brake_monitor.inspection.wandering import remarks_on_wandering
from brake_monitor.inspection.wheels_mean import remarks_on_wheels_mean
from brake_monitor.samples import Quality, Quantity
from brake_monitor.settings.config import Settings, Vehicle

SHOWN_IDS = 4
MOVING_MPS = 3.0  # slower than this a recording says nothing about units
UNLIKE = 1.15  # wear takes a tenth of a wheel; gears, teeth and units that are mistaken for others differ by more
JITTER = 1.1  # of a period
TOO_SELDOM = {  # the longest good period (s), and what a longer one costs
    Quantity.AXLE_SPEED: (
        JITTER * 0.05,
        "jumps of adhesion in a slide are then read as friction; map speeds that come every 20 ms if there are any",
    ),
    Quantity.PRESSING_FORCE: (
        JITTER * PROMPT_S,
        "in slides friction is then held and adhesion up to three times as uncertain; map forces that come every "
        "10 to 20 ms if there are any",
    ),
}
NEVER_TOO_SELDOM = (inf, "")
COUNTER_FAILS = 0.4  # share of the frames; random numbers advance in half of them
LEAST_VALUES = 20  # fewer say nothing about how a sender works


def remarks_on_mapping(traffic: Traffic, decoder: SignalDecoder, settings: Settings) -> Iterator[str]:
    """What makes one doubt that the right frames were taken for a message, and in the right units."""
    yield from _on_speeds(traffic, settings.vehicle)
    yield from _on_times(traffic, settings)
    yield from remarks_on_repetitions(traffic.first_hour)
    yield from remarks_on_steps(traffic.first_hour)
    yield from remarks_on_wandering(traffic.first_hour, settings.vehicle.wheel_radius_m)
    yield from remarks_on_wheels_mean(traffic.first_hour, settings.vehicle.wheel_radius_m)
    yield from remarks_on_pull(traffic.first_hour, settings)
    yield from remarks_on_forces(traffic, settings)
    yield from remarks_on_load(traffic, settings)
    yield from _on_counters(traffic, decoder)
    yield from _on_qualifiers(traffic, decoder)
    yield from _on_batches(traffic, decoder)
    yield from _on_rates(traffic, settings.vehicle.wheelset_count)
    yield from _on_timeouts(traffic, decoder)
    yield from _on_identifiers(traffic, decoder)


def _on_identifiers(traffic: Traffic, decoder: SignalDecoder) -> Iterator[str]:
    """Frames that came under several identifiers, or under another one than the DBC's."""
    heard: defaultdict[tuple[str, str], set[int]] = defaultdict(set)
    for channel in decoder.channels:
        heard[channel.bus, channel.message] |= traffic.found[channel.place].can_ids
    for matching in decoder.matchings:
        senders = heard[matching.bus, matching.message]
        if len(senders) > 1:
            yield (
                f"{matching.message} came under {len(senders)} ids, as several senders do: {_listed(senders)}; "
                'match = "id" in the mapping takes only the one in the DBC'
            )
        others = [(extended, can_id) for bus, extended, can_id in traffic.unmapped if bus == matching.bus]
        if (not matching.extended, matching.can_id) in others:
            other = can_id_text(matching.can_id, not matching.extended)
            yield (
                f"{other} is on the bus and not mapped, while the DBC gives "
                f"{matching.message} this number with {29 if matching.extended else 11} bits"
            )
        if matching.by == "id" and matching.extended and not senders:
            near = {c for extended, c in others if extended and pgn_bits(c) == pgn_bits(matching.can_id)}
            if near:
                yield (
                    f"{matching.message} never came, but its PGN did, under {_listed(near)}; if the bus is J1939, "
                    'say match = "pgn" in the mapping'
                )


def _on_times(traffic: Traffic, settings: Settings) -> Iterator[str]:
    """Readings that come later than others of the same moment."""
    radii_m, signals = settings.vehicle.wheel_radius_m, settings.signals
    lag_s = speed_lag_s(traffic.first_hour, radii_m)
    if lag_s is not None:
        way, unsure_s = "later" if lag_s > 0.0 else "earlier", max(LEAST_LAG_S, UNSURE * abs(lag_s))
        yield (
            f"speed comes about {abs(lag_s):.2f} s {way} than the axle speeds: "
            f"its {_should_be(signals.speed.delay_s, lag_s, unsure_s)}"
        )
    for place, obeyed in enumerate(obeyed_forces(traffic.first_hour, radii_m)):
        if obeyed is None:
            continue
        if obeyed.place != place:
            yield (
                f"axle_speed {place + 1} does what pressing_force {obeyed.place + 1} says, not {place + 1}, as "
                "slides show: look at the order in both lists"
            )
            continue
        lag_s = obeyed.lag_s
        if lag_s == 0.0:
            continue
        ours, others = f"pressing_force {place + 1}", f"axle_speed {place + 1}"
        late, early = (ours, others) if lag_s > 0.0 else (others, ours)
        force_s, wheel_s = signals.pressing_force[place].delay_s, signals.axle_speed[place].delay_s
        late_s, early_s = (force_s, wheel_s) if lag_s > 0.0 else (wheel_s, force_s)
        shown = f"{late} comes about {abs(lag_s):.2f} s later than {early}, as slides show: "
        if early_s >= abs(lag_s) - EARLY_S:  # that one is said to come late by more than it does
            yield f"{shown}of {early} the {_should_be(early_s, -abs(lag_s), EARLY_S)}"
        else:
            or_pads = "" if lag_s > 0.0 else ", unless it is the pads that press as much later than told"
            yield f"{shown}its {_should_be(late_s, abs(lag_s), EARLY_S)}{or_pads}"


def _on_counters(traffic: Traffic, decoder: SignalDecoder) -> Iterator[str]:
    """A signal that is not a counter fails in half of the frames or more."""
    for (bus, message), counter in decoder.counters.items():
        own = [
            traffic.found[channel.place]
            for channel in decoder.channels
            if (channel.bus, channel.message) == (bus, message)
        ]
        failing = max(found.bad[Quality.BAD_COUNTER] / max(len(found.times_s), LEAST_VALUES) for found in own)
        if failing > COUNTER_FAILS:
            yield (
                f"{message}.{counter} does not advance as a counter does in {failing:.0%} of its frames, which are "
                "not used: is it one, and is every frame here once?"
            )


def _on_qualifiers(traffic: Traffic, decoder: SignalDecoder) -> Iterator[str]:
    """A flag that is read the wrong way round rejects what is sound."""
    for channel in decoder.channels:
        qualifier = decoder.qualifiers.get(channel.place)
        found = traffic.found[channel.place]
        if qualifier is not None and not found.good and qualifier.rejected >= LEAST_VALUES:
            yield (
                f"{channel.source} was never believed, as {qualifier} in none of {qualifier.rejected} frames with it: "
                "is qualifier_good right?"
            )


def _on_batches(traffic: Traffic, decoder: SignalDecoder) -> Iterator[str]:
    """Frames that bear the time of their batch; of longer batches `_on_rates` tells."""
    for bus in dict.fromkeys(channel.bus for channel in decoder.channels):
        own = [channel for channel in decoder.channels if channel.bus == bus]
        longest_s = min(TOO_SELDOM.get(channel.quantity, NEVER_TOO_SELDOM)[0] for channel in own)
        found = batches(traffic, own)
        if found is not None and found.every_s <= longest_s:
            yield (
                f"bus {bus}: {found.together:.0%} of the mapped frames come sooner after another than a frame lasts, "
                f"in batches about every {1000.0 * found.every_s:.0f} ms, as an adapter or a gateway stamps what it "
                "has gathered: estimates are then less certain than they say (with 30 ms, adhesion was in its 95 % "
                "interval 68 % of the time); have each frame stamped as it comes, as by hardware time stamps"
            )


def _on_rates(traffic: Traffic, wheelset_count: int) -> Iterator[str]:
    """What comes too seldom for good estimates."""
    for quantity, (longest_s, costs) in TOO_SELDOM.items():
        seldom = {
            place + 1: found
            for place in range(wheelset_count)
            if len((found := traffic.found[quantity, place]).times_s) >= LEAST_VALUES
            and found.period_s > longest_s
            and not found.comes_on_change
        }
        if not seldom:
            continue
        which, most_ms = ", ".join(map(str, seldom)), 1000.0 * max(found.period_s for found in seldom.values())
        if any(found.is_bunched for found in seldom.values()):
            yield (
                f"{quantity} {which}: values come in bunches, every {most_ms:.0f} ms, as a gateway hands on what "
                "it has gathered, and are taken as measured when they come; map them where they come one by one"
            )
        else:
            yield f"{quantity} {which}: a value comes every {most_ms:.0f} ms, and {costs}"


def _on_timeouts(traffic: Traffic, decoder: SignalDecoder) -> Iterator[str]:
    """What comes regularly and yet counts as lost each time, as where the DBC's cycle time is wrong."""
    lost: defaultdict[tuple[Quantity, float], dict[int, float]] = defaultdict(dict)
    for channel in decoder.channels:
        gap_s = _gap_beyond_s(traffic.found[channel.place], channel.timeout_s / JITTER)
        if gap_s is not None:
            lost[channel.quantity, channel.timeout_s][channel.wheelset + 1] = gap_s
    for (quantity, timeout_s), gaps_s in lost.items():
        most_s = max(gaps_s.values())
        yield (
            f"{quantity} {', '.join(map(str, gaps_s))}: a value comes every {1000.0 * most_s:.0f} ms, and counts "
            f"as lost {1000.0 * timeout_s:.0f} ms after it came: timeout_s should be about "
            f"{CYCLES_TO_TIMEOUT * most_s:.2g}"
        )


def _gap_beyond_s(found: Found, timeout_s: float) -> float | None:
    """The usual one of the gaps that are longer than that, where most of the time lies in many such.

    Of a value that comes as it changes: the one in which most of that time lies, while nothing changes.
    """
    gaps_s = found.gaps_s
    longer_s = np.sort(gaps_s[gaps_s > timeout_s])
    if len(longer_s) < LEAST_VALUES or longer_s.sum() < 0.5 * gaps_s.sum():
        return None
    if found.comes_on_change:
        passed_s = np.cumsum(longer_s)
        return float(longer_s[np.searchsorted(passed_s, 0.5 * passed_s[-1])])
    return float(np.median(longer_s))


def _on_speeds(traffic: Traffic, vehicle: Vehicle) -> Iterator[str]:
    """Over a recording the greatest wheel speed and the greatest vehicle speed agree, whatever slid meanwhile."""
    speed_mps = traffic.found[Quantity.SPEED, 0].size
    for place, radius_m in enumerate(vehicle.wheel_radius_m):
        rim_mps = traffic.found[Quantity.AXLE_SPEED, place].size * radius_m
        slower, faster = sorted((speed_mps, rim_mps))
        if slower > 0.0 and faster > MOVING_MPS and faster > UNLIKE * slower:
            yield (
                f"axle_speed {place + 1} turns its wheel at up to {rim_mps:.3g} m/s, speed goes up to "
                f"{speed_mps:.3g} m/s: look at unit and scale of the two, and at vehicle.wheel_radius_m"
            )


def _should_be(told_s: float, lag_s: float, unsure_s: float) -> str:
    """What to make of a delay that is told, where the reading still lags, or comes early (negative)."""
    delay_s = told_s + lag_s
    better = f"about {delay_s:.2f}" if delay_s > unsure_s else "about 0 (leave it out)"
    return f"delay_s should be {better}, not {told_s:g}"


def _listed(can_ids: set[int]) -> str:
    shown = [can_id_text(can_id, extended=True) for can_id in sorted(can_ids)[:SHOWN_IDS]]
    return ", ".join(shown) + (" ..." if len(can_ids) > SHOWN_IDS else "")
