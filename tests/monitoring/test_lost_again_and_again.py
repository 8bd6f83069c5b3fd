"""A signal that is lost for moments, again and again, is told of; what a bus loses now and then is not."""

from collections.abc import Callable, Iterable, Iterator
from functools import reduce
from math import floor, inf
from random import Random

import pytest
from msgspec.structs import replace

from brake_monitor.frame import Frame
from brake_monitor.monitoring.alarm import Alarm, Severity
from brake_monitor.monitoring.monitor import Monitor
from brake_monitor.monitoring.reports import GOOD, BusReport
from brake_monitor.monitoring.rules.all_rules import wagon_rules
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.samples import Quantity
from brake_monitor.settings.alarm_settings import AlarmSettings, InputLostRule
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.simulate import EPOCH_S, Recording
from drives import DRY, SLIDE, drive
from estimates import estimate, observation, report
from faults import carries, error_code, signal_changed

Fault = Callable[[list[Frame]], list[Frame]]
KIND = "input_lost"


def loose(gap_s: float, every_s: float, message: str | None = None) -> Fault:
    """A contact that opens so long, so often; of one message or of all."""

    def gone(frame: Frame) -> bool:
        return (frame.time_s - EPOCH_S) % every_s < gap_s and (message is None or carries(frame, message))

    return lambda frames: [frame for frame in frames if not gone(frame)]


def not_available(sensor: str, for_s: float, every_s: float) -> Fault:
    """As loose(), and its control unit says so."""
    return lambda frames: reduce(
        lambda told, k: error_code(sensor, every_s * k, every_s * k + for_s)(told), range(round(30.0 / every_s)), frames
    )


def drops_to_0(sensor: str, for_s: float, every_s: float) -> Fault:
    """As loose(), and what reads it takes that for 0."""
    return signal_changed(sensor, lambda time_s, value: 0.0 if time_s % every_s < for_s else value, 0.0, inf)


def slower(message: str, period_s: float) -> Fault:
    """It comes once in each period, as a gateway hands it on that thins it out."""

    def kept(frames: list[Frame]) -> Iterator[Frame]:
        last = -inf
        for frame in frames:
            turn = floor((frame.time_s - EPOCH_S) / period_s)
            if not carries(frame, message):
                yield frame
            elif turn != last:
                last = turn
                yield frame

    return lambda frames: list(kept(frames))


def fewer(share: float) -> Fault:
    """So many frames never arrive."""
    chance = Random(1)
    return lambda frames: [frame for frame in frames if chance.random() >= share]


def told(
    fault: Fault, often: int = AlarmSettings().input_lost.losses_per_minute, recording: Recording | None = None
) -> list[Alarm]:
    """Each alarm about lost signals as it was raised, in half a minute."""
    recording = recording or drive(DRY)
    rules = AlarmSettings(input_lost=InputLostRule(losses_per_minute=often))
    pipeline = Pipeline.from_settings(replace(recording.settings, alarms=rules))
    given = [alarm for frame in fault(recording.frames) for alarm in pipeline.step(frame).alarms if alarm.kind == KIND]
    return list({alarm.id: alarm for alarm in reversed(given)}.values())


@pytest.mark.parametrize(
    ("fault", "places", "named"),
    [
        (slower("BCU", 0.1), {1, 2}, "pressing_force"),  # the DBC says 10 ms, which makes a time-out of 50
        (loose(0.3, 1.5, "WSP"), {1, 2}, "axle_speed, wsp_active"),
        (loose(0.5, 1.5, "GNSS"), {None}, "speed"),
        (not_available("pressing force", 0.3, 1.5), {1}, "pressing_force"),
        (drops_to_0("wheel speed", 0.2, 1.5), {1}, "axle_speed"),
    ],
    ids=[
        "time-out too short",
        "loose contact of wheel speeds",
        "loose contact of the vehicle speed",
        "not available",
        "a wheel speed that drops to 0",
    ],
)
def test_what_is_lost_for_moments_again_and_again_is_told_of(fault: Fault, places: set[int | None], named: str) -> None:
    found = told(fault)
    assert {alarm.wheelset for alarm in found} == places
    assert {alarm.evidence["inputs"] for alarm in found} == {named}
    assert {alarm.severity for alarm in found} == {Severity.WARNING}
    for alarm in found:
        assert "again and again" in alarm.message
        assert "times within a minute" in str(alarm.evidence["conditions"])


@pytest.mark.parametrize("fault", [fewer(0.2), loose(0.8, 1.5)], ids=["a fifth of the frames", "gaps of the bus"])
def test_what_a_bus_loses_is_no_fault_of_a_signal(fault: Fault) -> None:
    assert told(fault, often=7) == []


@pytest.mark.parametrize("slide_protection", [True, False], ids=["slides", "locked"])
def test_wheelsets_that_slide_or_lock_are_no_signals_that_are_lost(slide_protection: bool) -> None:
    assert told(list, often=1, recording=drive(SLIDE, Modifiers(slide_protection=slide_protection))) == []


class Wagon:
    """One signal, of which is known how often it was lost."""

    def __init__(self, bus_silent_s: float = 0.0) -> None:
        """`bus_silent_s`: for so long nothing else has come on its bus either, whenever it is lost."""
        self.monitor, self.time_s, self.losses = Monitor(wagon_rules(AlarmSettings(), 2)), 1000.0, 0
        self._bus_silent_s = bus_silent_s

    def told(self, lost_every_s: float, lasting_s: float) -> list[Alarm]:
        """What is given out while it is lost so often."""
        return self.told_of([step % round(lost_every_s * 10) == 0 for step in range(1, round(lasting_s * 10) + 1)])

    def told_of(self, losses: Iterable[bool]) -> list[Alarm]:
        """What is given out; `losses`: whether it is lost in each tenth of a second."""
        given: list[Alarm] = []
        for is_lost in losses:
            self.time_s += 0.1
            self.losses += is_lost
            speed = report(Quantity.SPEED, 0, "GNSS.v", GOOD, bus="can0", losses=self.losses)
            bus = BusReport("can0", self._bus_silent_s if is_lost else 0.0, 0, is_off=False, expected_within_s=0.1)
            given += self.monitor.see(observation(estimate(time_s=self.time_s), (speed,), (bus,)))
        return given


@pytest.mark.parametrize(("bus_silent_s", "is_told"), [(0.3, True), (0.7, False)])
def test_a_signal_counts_as_lost_in_short_gaps_of_its_bus_though_not_in_longer_ones(
    bus_silent_s: float, is_told: bool
) -> None:
    """The time-outs of all that is on it are a tenth of a second: nothing else tells of the short ones."""
    assert bool(Wagon(bus_silent_s).told(2.0, 50.0)) is is_told


def test_it_is_over_when_it_was_seldom_lost_for_a_minute() -> None:
    wagon = Wagon()
    (raised, *_) = wagon.told(2.0, 50.0)
    assert raised.raised_time_s - 1000.0 == pytest.approx(15 * 2.0 + 1.0, abs=0.2)
    *_, cleared = wagon.told(10.0, 70.0)
    assert (cleared.id, cleared.cleared_time_s is not None) == (raised.id, True)


def test_how_often_it_was_lost_at_the_most_is_still_told_when_it_is_over() -> None:
    """By that a loose contact and a time-out that is too short are told apart."""
    wagon = Wagon()
    wagon.told(2.0, 50.0)
    *_, cleared = wagon.told(10.0, 70.0)
    assert cleared.cleared_time_s is not None
    assert cleared.evidence["conditions"] == "lost 26 times within a minute"  # after 2, 4, ... 50 and 60 s


@pytest.mark.parametrize("per_minute", [12, 15, 18])
def test_a_contact_that_opens_about_as_often_as_is_told_raises_no_flood(per_minute: int) -> None:
    chance = Random(1)
    told = Wagon().told_of(chance.random() < per_minute / 600 for _ in range(18_000))
    assert len({alarm.id for alarm in told}) <= 4  # in half an hour


def test_one_that_is_lost_every_five_seconds_is_not_told_of() -> None:
    assert Wagon().told(5.0, 300.0) == []


def test_a_clock_that_is_set_back_tells_nothing() -> None:
    wagon = Wagon()
    assert wagon.told(2.0, 20.0) == []
    wagon.time_s -= 3600.0
    assert wagon.told(2.0, 20.0) == []
