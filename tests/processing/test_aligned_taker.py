"""Samples of sensors that lag are taken by the thousand in the order in which they are taken one by one."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from brake_monitor.decoding.sample_block import Columns, SampleBlock
from brake_monitor.estimation.estimate import Estimate
from brake_monitor.estimation.estimator import Estimator
from brake_monitor.estimation.inputs.alignment import Alignment
from brake_monitor.processing.aligned_taker import AlignedTaker
from brake_monitor.samples import Channel, InputCondition, Quality, Quantity, Sample
from brake_monitor.settings.example_vehicles import example_settings

DELAY_S = {(Quantity.SPEED, 0): 0.15, (Quantity.AXLE_SPEED, 0): 0.02, (Quantity.PRESSING_FORCE, 0): 0.0}
CHANNELS = [Channel(*measurand, "can0", "M", "s", 0.01, delay_s, 1.0) for measurand, delay_s in DELAY_S.items()]
SPEED, AXLE_SPEED, PRESSING_FORCE = range(3)
IMPOSSIBLE_MPS = 300.0

Arrival = tuple[int, float, Quality]  # channel, seconds after the arrival before, quality
arrivals = st.lists(
    st.tuples(
        st.integers(0, len(CHANNELS) - 1),
        st.sampled_from([0.0, 0.001, 0.02, 0.07, 0.3]),
        st.sampled_from([Quality.GOOD, Quality.OUT_OF_RANGE]),
    ),
    max_size=60,
)


class Listener:
    """Writes down what it is to take; to it all of it is fused."""

    def __init__(self) -> None:
        self.taken: list[Sample] = []

    def take(self, samples: SampleBlock, begin: int, end: int) -> int | None:
        self.taken += samples.samples[begin:end]
        return end - 1 if end > begin else None

    def settle(self) -> None:
        pass

    def estimate(self, time_s: float | None) -> Estimate:
        raise NotImplementedError


def estimator() -> Estimator:
    settings = example_settings("rig")
    return Estimator(settings.vehicle, settings.estimator, CHANNELS)


def block(some: Sequence[Arrival], begin_s: float, first_value: int = 0) -> SampleBlock:
    """One sample for each frame; each has a value of its own."""
    time_s = begin_s + np.cumsum([step_s for _, step_s, _ in some])
    table = [(k, channel, float(first_value + k), quality) for k, (channel, _, quality) in enumerate(some)]
    return SampleBlock.of(CHANNELS, time_s, [Columns.of(table)])


def in_order(alignment: Alignment, samples: Sequence[Sample]) -> list[list[Sample]]:
    """What each of them makes ready, one by one."""
    return [list(alignment.put(sample)) for sample in samples]


@given(arrivals, arrivals, st.data())
def test_order_and_instant_are_those_of_one_by_one(
    first: list[Arrival], second: list[Arrival], data: st.DataObject
) -> None:
    """Blocks, and stretches of them; once they are settled, those that wait are the estimator's."""
    listener, alignment, mine = Listener(), Alignment(CHANNELS), estimator()
    taker = AlignedTaker(mine, listener)
    begin_s = 10.0
    for number, some in enumerate((first, second)):
        samples = block(some, begin_s, 100 * number)
        ready = in_order(alignment, samples.samples)
        cuts = sorted(data.draw(st.sets(st.integers(0, len(some)), max_size=4)) | {0, len(some)})
        for begin, end in pairwise(cuts):
            listener.taken.clear()
            fused = taker.take(samples, begin, end)
            assert listener.taken == [sample for each in ready[begin:end] for sample in each]
            assert fused == max((k for k in range(begin, end) if ready[k]), default=None)
            if data.draw(st.booleans()):
                taker.settle()
        taker.settle()
        begin_s = float(max(samples.time_s, default=begin_s))
    assert mine.alignment.ready(begin_s + 1.0) == alignment.ready(begin_s + 1.0)


def test_what_cannot_be_does_not_wait() -> None:
    """The estimator loses its signal as it comes; what waited for it does no longer."""
    listener, mine = Listener(), estimator()
    taker = AlignedTaker(mine, listener)
    good = [(AXLE_SPEED, 0.01, Quality.GOOD)] * 3
    samples = block([*good, (SPEED, 10.0, Quality.GOOD), *good], 10.0)
    samples.value[3] = IMPOSSIBLE_MPS
    taker.take(samples, 0, 3)
    assert mine.input_condition((Quantity.SPEED, 0)) is InputCondition.AWAITED
    taker.take(samples, 3, 4)
    assert mine.input_condition((Quantity.SPEED, 0)) is InputCondition.IMPOSSIBLE
    assert [sample.value for sample in listener.taken] == [0.0, 1.0, 2.0]
    taker.take(samples, 4, 7)
    assert [sample.value for sample in listener.taken] == [0.0, 1.0, 2.0]


def test_what_was_fused_before_something_that_cannot_be_counts() -> None:
    taker = AlignedTaker(estimator(), Listener())
    samples = block([(SPEED, 0.01, Quality.GOOD)] * 5, 10.0)
    samples.value[4] = IMPOSSIBLE_MPS
    assert taker.take(samples, 0, 5) == 3


@pytest.mark.parametrize("back_s", [0.1, 2.0])
@pytest.mark.parametrize("sizes", [(40,), (20, 20)])
def test_where_time_goes_back_each_is_taken_by_itself(back_s: float, sizes: tuple[int, ...]) -> None:
    """In a block, or between two, as a clock is set."""
    some: list[Arrival] = [(PRESSING_FORCE, 0.02, Quality.GOOD)] * 40
    some[20] = (PRESSING_FORCE, -back_s, Quality.GOOD)
    whole = block(some, 10.0)
    listener, mine, other = Listener(), estimator(), estimator()
    taker = AlignedTaker(mine, listener)
    begin = 0
    for size in sizes:
        columns = (whole.frame, whole.time_s, whole.channel, whole.value, whole.quality)
        taker.take(SampleBlock(CHANNELS, *[column[begin : begin + size] for column in columns]), 0, size)
        taker.settle()
        begin += size
    for sample in whole.samples:
        other.take(sample)
    assert len(listener.taken) < len(some) // 2
    assert mine.core.wheels[0].force.value == other.core.wheels[0].force.value > 0.0
    assert mine.alignment.take_over() == other.alignment.take_over() != []
