"""What in a recording makes one doubt its mapping: remarks on identifiers, units, times, counters and rates."""

from collections import defaultdict
from collections.abc import Iterator

import numpy as np

from brake_monitor.decoding.j1939 import pgn_bits
from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.frame import can_id_text
from brake_monitor.inspection.batches import remarks_on_batches
from brake_monitor.inspection.coarse import remarks_on_steps
from brake_monitor.inspection.first_hour import FirstHour
from brake_monitor.inspection.force_size import remarks_on_forces, remarks_on_load
from brake_monitor.inspection.lags import remarks_on_lags
from brake_monitor.inspection.pulled import remarks_on_pull
from brake_monitor.inspection.rates import LEAST_VALUES, remarks_on_rates, remarks_on_timeouts
from brake_monitor.inspection.repeated import remarks_on_repetitions
from brake_monitor.inspection.traffic import Traffic
from brake_monitor.inspection.wandering import remarks_on_wandering
from brake_monitor.inspection.wheels_mean import remarks_on_wheels_mean
from brake_monitor.samples import Quality, Quantity
from brake_monitor.settings.config import Settings, Vehicle

SHOWN_IDS = 4
MOVING_MPS = 3.0  # slower than this a recording says nothing about units
UNLIKE = 1.15  # wear takes a tenth of a wheel; gears, teeth and units that are mistaken for others differ by more
COUNTER_FAILS = 0.4  # share of the frames; random numbers advance in half of them


def remarks_on_mapping(traffic: Traffic, decoder: SignalDecoder, settings: Settings) -> Iterator[str]:
    """What makes one doubt that the right frames were taken for a message, and in the right units."""
    yield from _on_speeds(traffic, settings.vehicle)
    yield from remarks_on_lags(traffic.first_hour, settings)
    yield from remarks_on_repetitions(traffic.first_hour)
    yield from remarks_on_steps(traffic.first_hour)
    yield from remarks_on_wandering(traffic.first_hour, settings.vehicle.wheel_radius_m)
    yield from remarks_on_wheels_mean(traffic.first_hour, settings.vehicle.wheel_radius_m)
    yield from remarks_on_pull(traffic.first_hour, settings)
    yield from remarks_on_forces(traffic, settings)
    yield from remarks_on_load(traffic, settings)
    yield from _on_counters(traffic, decoder)
    yield from _on_qualifiers(traffic, decoder)
    yield from remarks_on_batches(traffic, decoder.channels)
    yield from remarks_on_rates(traffic, settings.vehicle.wheelset_count)
    yield from remarks_on_timeouts(traffic, decoder.channels)
    yield from _on_identifiers(traffic, decoder)


def _on_identifiers(traffic: Traffic, decoder: SignalDecoder) -> Iterator[str]:
    """Frames that came under several identifiers, or under another one than the DBC's."""
    heard: defaultdict[tuple[str, str], set[int]] = defaultdict(set)
    for channel in decoder.channels:
        heard[channel.bus, channel.message] |= traffic.found[channel.measurand].can_ids
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
            if near and matching.can_id not in near:  # else it came, without what is mapped
                yield (
                    f"{matching.message} never came, but its PGN did, under {_listed(near)}; if the bus is J1939, "
                    'say match = "pgn" in the mapping'
                )


def _on_counters(traffic: Traffic, decoder: SignalDecoder) -> Iterator[str]:
    """A signal that is not a counter fails in half of the frames or more."""
    for (bus, message), counter in decoder.counters.items():
        own = [
            traffic.found[channel.measurand]
            for channel in decoder.channels
            if (channel.bus, channel.message) == (bus, message)
        ]
        failing = max(found.bad[Quality.BAD_COUNTER] / max(found.arrivals.count, LEAST_VALUES) for found in own)
        if failing > COUNTER_FAILS:
            yield (
                f"{message}.{counter} does not advance as a counter does in {failing:.0%} of its frames, which are "
                "not used: is it one, and is every frame here once?"
            )


def _on_qualifiers(traffic: Traffic, decoder: SignalDecoder) -> Iterator[str]:
    """A flag that is read the wrong way round rejects what is sound."""
    for channel in decoder.channels:
        qualifier = decoder.qualifiers.get(channel.measurand)
        found = traffic.found[channel.measurand]
        if qualifier is not None and not found.good and qualifier.rejected >= LEAST_VALUES:
            yield (
                f"{channel.source} was never believed, as {qualifier} in none of {qualifier.rejected} frames with it: "
                "is qualifier_good right?"
            )


def _on_speeds(traffic: Traffic, vehicle: Vehicle) -> Iterator[str]:
    """Over a recording the greatest wheel speed and the greatest vehicle speed agree, whatever slid meanwhile.

    Where one was away, or stood still, as the wagon was fastest, the two agree as a rule.
    """
    speed = traffic.found[Quantity.SPEED, 0]
    speed_mps = speed.size
    wheels = [traffic.found[Quantity.AXLE_SPEED, place] for place in range(len(vehicle.wheel_radius_m))]
    rims_mps = [wheel.size * radius_m for wheel, radius_m in zip(wheels, vehicle.wheel_radius_m, strict=True)]
    if speed.is_kept and speed_mps == 0.0 and max(rims_mps) > MOVING_MPS:
        yield f"speed is always 0, while wheels turn at up to {max(rims_mps):.3g} m/s: is it the signal that is sent?"
    for place, (wheel, rim_mps) in enumerate(zip(wheels, rims_mps, strict=True)):
        if wheel.is_kept and rim_mps == 0.0 and speed_mps > MOVING_MPS:
            yield (
                f"axle_speed {place + 1} is always 0, while speed goes up to {speed_mps:.3g} m/s: is it the signal "
                "that is sent, and does the wheelset turn?"
            )
        slower, faster = sorted((speed_mps, rim_mps))
        is_unlike = slower > 0.0 and faster > MOVING_MPS and faster > UNLIKE * slower
        if is_unlike and not _agree_as_a_rule(traffic.first_hour, vehicle, place):
            yield (
                f"axle_speed {place + 1} turns its wheel at up to {rim_mps:.3g} m/s, speed goes up to "
                f"{speed_mps:.3g} m/s: look at unit and scale of the two, and at vehicle.wheel_radius_m"
            )


def _agree_as_a_rule(first_hour: FirstHour, vehicle: Vehicle, place: int) -> bool:
    """Whether a wheelset's speed and the vehicle's do, where all are told at the same time; not where none are."""
    speeds = first_hour.speeds_told_together_mps(vehicle.wheel_radius_m)
    if speeds is None:
        return False
    speed, wheel = speeds[0], speeds[1 + place]
    moves = speed.values > MOVING_MPS
    if np.count_nonzero(moves) < LEAST_VALUES:
        return False
    share = float(np.median(wheel.at(speed.times_s[moves]) / speed.values[moves]))
    return 1.0 / UNLIKE < share < UNLIKE


def _listed(can_ids: set[int]) -> str:
    shown = [can_id_text(can_id, extended=True) for can_id in sorted(can_ids)[:SHOWN_IDS]]
    return ", ".join(shown) + (" ..." if len(can_ids) > SHOWN_IDS else "")
