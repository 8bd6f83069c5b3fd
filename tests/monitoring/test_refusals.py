"""Why nothing good arrives of a signal."""

import pytest

from brake_monitor.monitoring.inputs.refusals import Refusals
from brake_monitor.samples import Channel, InputCondition, Quality, Quantity, Sample


@pytest.mark.parametrize("longest_delay_s", [0.0, 0.3, 1.0])
def test_what_still_arrives_is_not_lost_though_estimates_are_late(longest_delay_s: float) -> None:
    """The sender says "not available" ten times a second; estimates are as late as the slowest sensor."""
    speed = Channel(Quantity.SPEED, 0, "can0", "M", "v", 0.02, longest_delay_s, 0.5)
    wheel = Channel(Quantity.AXLE_SPEED, 0, "can0", "M", "n", 0.02, 0.0, 0.1)
    refusals = Refusals([speed, wheel])
    refusals.refused[Quantity.AXLE_SPEED, 0] = Sample(20.0, Quantity.AXLE_SPEED, 0, 0.0, Quality.NOT_AVAILABLE)
    assert refusals.why_lost((Quantity.AXLE_SPEED, 0), 20.05 - longest_delay_s) is InputCondition.NOT_AVAILABLE
    for later_s in (20.2 + longest_delay_s, 10.0):  # the clock may have been set back
        assert refusals.why_lost((Quantity.AXLE_SPEED, 0), later_s) is InputCondition.LOST


@pytest.mark.parametrize(
    ("quantity", "is_counted"),
    [
        (Quantity.PRESSING_FORCE, True),
        (Quantity.WSP_ACTIVE, True),
        (Quantity.SPEED, False),
        (Quantity.AXLE_SPEED, False),
    ],
)
def test_what_is_not_available_for_a_moment_is_lost_unless_it_is_a_speed(quantity: Quantity, is_counted: bool) -> None:
    """Its control unit tells of the loose contact. Speeds are not available at a crawl, or in a tunnel."""
    signal = Channel(quantity, 0, "can0", "M", "s", 0.02, 0.0, 0.5)
    refusals = Refusals([signal])
    for quality in (Quality.NOT_AVAILABLE, Quality.STALE):
        refusals.refuse(Sample(10.0, quantity, 0, 0.0, quality))
    assert (refusals.losses[signal.measurand] == 1) is is_counted


def test_a_signal_is_lost_each_time_that_nothing_arrives_of_it() -> None:
    speed = Channel(Quantity.SPEED, 0, "can0", "M", "v", 0.02, 0.0, 0.5)
    refusals = Refusals([speed])

    def refuse(time_s: float, quality: Quality) -> int:
        refusals.refuse(Sample(time_s, Quantity.SPEED, 0, 0.0, quality))
        return refusals.losses[speed.measurand]

    assert [refuse(10.0, Quality.STALE), refuse(20.0, Quality.STALE)] == [1, 2]
    assert [refuse(29.8, Quality.OUT_OF_RANGE), refuse(30.0, Quality.STALE)] == [2, 2]  # it does arrive
    assert refuse(40.0, Quality.STALE) == 3
