"""Samples shown together leave what they leave one by one, to the bit, whatever wheels, brakes and clocks do."""

from functools import cache
from math import inf
from random import Random

import numpy as np
import pytest

from brake_monitor.decoding.sample_block import SampleBlock
from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.monitoring.creep_meter import CreepMeter
from brake_monitor.monitoring.inputs.block_watch import BlockWatch
from brake_monitor.monitoring.inputs.input_judge import InputJudge
from brake_monitor.samples import Channel, Quality, Quantity, Sample
from brake_monitor.settings.config import Settings
from brake_monitor.settings.example_vehicles import example_settings

BEGIN_S, STEP_S, LENGTH_S = 1.7e9, 0.01, 30.0
BLOCK_S = 4.0
SET_BACK_S = 0.7


@cache
def wagon() -> tuple[Settings, tuple[Channel, ...]]:
    settings = example_settings("wagon")
    return settings, SignalDecoder.from_settings(settings).channels


def two_judges() -> tuple[InputJudge, InputJudge]:
    """One that is to see samples together, one that is to see them one by one."""
    settings, channels = wagon()
    contact_n = settings.estimator.contact_force_n
    return InputJudge(settings, channels, CreepMeter(contact_n)), InputJudge(settings, channels, CreepMeter(contact_n))


def speed_mps(time_s: float) -> float:
    """A wagon that stands, starts, brakes to a halt, stands again, and moves on for a second.

    As it brakes all speeds stand still for three seconds, as of a gateway that tells again what it was told last.
    """
    if LENGTH_S - 14.0 <= time_s < LENGTH_S - 11.0:
        time_s = LENGTH_S - 14.0
    moves_on = 2.0 * min(time_s - LENGTH_S + 1.7, LENGTH_S - 0.3 - time_s)
    return max(0.0, min(3.0 * (time_s - 3.0), 20.0, 2.0 * (LENGTH_S - 4.0 - time_s)), moves_on)


def turning(time_s: float, i: int) -> float:
    """Circumferential over vehicle speed: the first wheelset locks for a while, the second slides a little before.

    That slide begins at the end of a block: what is remembered of it shows in the next one how the wheelset fell. The
    second one's sensor misses teeth for a moment before, once more just as a block ends, and for two seconds later.
    """
    if i == 1 and (9.0 <= time_s < 9.3 or 2.0 * BLOCK_S - 0.015 <= time_s < 2.0 * BLOCK_S + 0.1):
        return 0.6
    if i == 1 and 20.5 <= time_s < 22.5:
        return 0.6
    locked = i == 0 and 14.0 <= time_s < 16.5
    return 0.0 if locked else 0.93 if i == 1 and 3.0 * BLOCK_S - 0.05 <= time_s < 13.0 else 1.0


def pressing_n(time_s: float) -> float:
    return 20_000.0 if 13.0 <= time_s < 17.0 or time_s > LENGTH_S - 14.0 else 0.0


def value_of(channel: Channel, time_s: float, random: Random) -> float:
    match channel.quantity:
        case Quantity.SPEED:
            return speed_mps(time_s) + random.gauss(0.0, 0.02)
        case Quantity.AXLE_SPEED:
            return max(speed_mps(time_s) * turning(time_s, channel.wheelset) / 0.46 + random.gauss(0.0, 0.02), 0.0)
        case Quantity.PRESSING_FORCE:
            return pressing_n(time_s) and pressing_n(time_s) + random.gauss(0.0, 50.0)
        case Quantity.WSP_ACTIVE:
            return float(turning(time_s, channel.wheelset) < 1.0)
    return 0.0


def block(
    begin: int, end: int, set_back_at_s: float, bad: float, random: Random, *, heading: float = 1.0
) -> SampleBlock:
    """The samples of some steps, a few of them bad; the vehicle's speed is not the first of them."""
    channels = wagon()[1]
    rows = [
        (k, number, value_of(channel, k * STEP_S, random))
        for k in range(begin, end)
        for number, channel in enumerate(channels)
        if channel.quantity in {Quantity.AXLE_SPEED, Quantity.PRESSING_FORCE} or (k + 2) % 5 == number % 5
    ]
    step, number, value = (np.array(column) for column in zip(*rows, strict=True))
    is_bad = np.array([random.random() < bad for _ in rows])
    quality = np.where(is_bad, Quality.OUT_OF_RANGE, Quality.GOOD).astype(np.int64)
    has_sign = [channel.quantity in {Quantity.SPEED, Quantity.AXLE_SPEED} for channel in channels]
    value = np.where(np.array(has_sign)[number], heading * value, value)
    time_s = BEGIN_S + step * STEP_S - SET_BACK_S * (step * STEP_S >= set_back_at_s)
    return SampleBlock(channels, step - begin, time_s, number, value, quality)


def state(judge: InputJudge) -> str:
    """All that the watches know."""
    others = {"_vehicle_speed", "_protection", "holding", "bursts", "descent", "turning"}
    wheels = [
        (
            {name: value for name, value in vars(wheel).items() if name not in others},
            vars(wheel.holding),
            {name: value for name, value in vars(wheel.turning).items() if not hasattr(value, "__dict__")},
            vars(wheel.turning.odd),
        )
        for wheel in judge._wheels.wheels
    ]
    falls = [(vars(wheel.bursts), vars(wheel.descent)) for wheel in judge._wheels.wheels]
    forces = [
        vars(force) | {"_life": vars(force._life), "_others": [(i, vars(span)) for i, span in force._others.items()]}
        for force in judge._frozen._forces.values()
        if not force.is_zero  # of which nothing is said
    ]
    return repr((shown_at_once(judge), wheels, falls, forces))


def shown_at_once(judge: InputJudge) -> tuple[object, ...]:
    """What is asked for at any time, and by those who do not wait until what was passed over is remembered."""
    watched = judge._wheels
    wheels = [
        (
            wheel.rolling_mps,
            wheel.stands_since_s,
            wheel.decided,
            vars(wheel.holding),
        )
        for wheel in watched.wheels
    ]
    flags = [flag.is_set for flag in judge._flags.flags.values()]
    refused = (dict(judge._refusals.refused), dict(judge._refusals.losses))
    return (dict(vars(watched.speed)), wheels, flags, judge._frozen.all_are_zero, refused)


@pytest.mark.parametrize(
    ("bad", "set_back_at_s", "heading"),
    [(0.0, inf, 1.0), (0.0, inf, -1.0), (0.001, inf, 1.0), (0.0, 9.5, 1.0), (0.0, 11.99, 1.0), (0.0, 20.0, 1.0)],
    ids=["", "reversing", "some are bad", "clock set back", "at a block's last samples", "between two blocks"],
)
def test_together_they_leave_what_they_leave_one_by_one(
    bad: float, set_back_at_s: float, heading: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    together, singly = two_judges()
    passed: list[int] = []
    pass_over = BlockWatch.pass_over

    def counted(watch: BlockWatch, begin: int, end: int) -> None:
        passed.append(end - begin)
        pass_over(watch, begin, end)

    monkeypatch.setattr(BlockWatch, "pass_over", counted)
    random, size, samples_count = Random(1), round(BLOCK_S / STEP_S), 0
    for begin in range(0, round(LENGTH_S / STEP_S), size):
        samples = block(begin, begin + size, set_back_at_s, bad, random, heading=heading)
        samples_count += len(samples)
        first = 0
        while first < len(samples):
            end = min(first + random.choice((1, 7, 50, 80)), len(samples))
            if random.random() < 0.05:  # as a frame is that is taken by itself
                for sample in samples.at(np.arange(first, end)):
                    together.see(sample)
            else:
                together.see_together(samples, first, end)
            for sample in samples.at(np.arange(first, end)):
                singly.see(Sample(*sample))
            time_s = float(samples.time_s[end - 1])
            for judge in (together, singly):
                judge._frozen.frozen(time_s, 10.0, [True, True], slides=False)
            assert shown_at_once(together) == shown_at_once(singly)
            if random.random() < 0.1:
                assert state(together) == state(singly)
            first = end
    assert state(together) == state(singly)
    assert sum(passed) > 0.5 * samples_count


def numbers() -> dict[Quantity, int]:
    """The first channel of each quantity."""
    return {channel.quantity: k for k, channel in reversed(list(enumerate(wagon()[1])))}


def block_of(rows: list[tuple[int, int, float]]) -> SampleBlock:
    """Good samples by step, number of the channel and value, in order of time."""
    step, number, value = (np.array(column) for column in zip(*sorted(rows, key=lambda row: row[0]), strict=True))
    good = np.full(len(rows), int(Quality.GOOD))
    return SampleBlock(wagon()[1], step, BEGIN_S + step * STEP_S, number, value, good)


def show_both(together: InputJudge, singly: InputJudge, samples: SampleBlock) -> None:
    """Show them, by seven, to the one, and one by one to the other."""
    for first in range(0, len(samples), 7):
        together.see_together(samples, first, min(first + 7, len(samples)))
    for sample in samples.at(np.arange(len(samples))):
        singly.see(Sample(*sample))


def test_what_wheels_do_before_the_first_speed_of_the_vehicle_counts_in_neither() -> None:
    """They fall as no rolling wheelset does, and nobody knows yet what they should do."""
    rolling_mps = 15.0 * wagon()[0].vehicle.wheel_radius_m[0]
    rows = [(k, numbers()[Quantity.AXLE_SPEED], 45.0 - k if k < 30 else 15.0) for k in range(60)]
    rows += [(k, numbers()[Quantity.SPEED], rolling_mps) for k in range(30, 60, 5)]
    together, singly = two_judges()
    show_both(together, singly, block_of(rows))
    assert state(together) == state(singly)


@pytest.mark.parametrize("rolling_mps", [0.48, 0.51, 0.6])
def test_at_a_crawl_wheels_beside_a_speed_that_is_no_longer_told_do_the_same_in_both(rolling_mps: float) -> None:
    """The vehicle's speed was 0.52 m/s when it was told last, more than two seconds ago."""
    rolling_radps = rolling_mps / wagon()[0].vehicle.wheel_radius_m[0]
    rows = [(0, numbers()[Quantity.SPEED], 0.52)]
    rows += [(k, numbers()[Quantity.AXLE_SPEED], rolling_radps) for k in range(1, 400, 2)]
    together, singly = two_judges()
    show_both(together, singly, block_of(rows))
    assert state(together) == state(singly)


@pytest.mark.parametrize("to_mps", [18.0, 22.0])
@pytest.mark.parametrize("jump_at", range(20, 28))
def test_a_vehicle_speed_that_jumps_is_seen_in_both(jump_at: int, to_mps: float) -> None:
    """All wheelsets go on turning; the samples before and after it may be shown together or not."""
    rows = [(k, numbers()[Quantity.AXLE_SPEED], 45.0) for k in range(0, 50, 2)]
    rows += [(k, numbers()[Quantity.SPEED], 20.0 if k < jump_at else to_mps) for k in range(1, 50, 2)]
    samples = block_of(rows)
    together, singly = two_judges()
    for first in range(0, len(samples), 5):
        together.see_together(samples, first, first + 5)
        for sample in samples.at(np.arange(first, first + 5)):
            singly.see(Sample(*sample))
        assert state(together) == state(singly)


@pytest.mark.parametrize("presses_at", range(20, 30))
def test_a_brake_that_begins_to_press_is_seen_in_both(presses_at: int) -> None:
    """The last sample of a released brake may be shown together with the first one that presses, or not."""
    together, singly = two_judges()
    channels = wagon()[1]
    forces = [k for k, channel in enumerate(channels) if channel.quantity is Quantity.PRESSING_FORCE]
    place = np.arange(50)
    step, number = place // len(forces), np.array(forces)[place % len(forces)]
    value = np.where(place < presses_at, 0.0, 20e3 + step)
    samples = block_of(list(zip(step.tolist(), number.tolist(), value.tolist(), strict=True)))
    for first in range(0, len(samples), 5):
        together.see_together(samples, first, first + 5)
        for sample in samples.at(np.arange(first, first + 5)):
            singly.see(Sample(*sample))
        assert shown_at_once(together) == shown_at_once(singly)
        assert state(together) == state(singly)
    assert not singly._frozen.all_are_zero
