"""A bus whose messages come once a second: one that fails is told of, a bus that falls silent is the bus's fault."""

from math import floor, inf

import pytest
from msgspec.structs import replace

from brake_monitor.frame import Frame
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.settings.config import Settings, SignalMapping
from brake_monitor.simulator.simulate import EPOCH_S
from drives import DRY, drive
from faults import Fault, carries, lost, silence

TIMEOUT_S, DEBOUNCE_S = 3.0, 1.0
FAILS_S = 10.0


def once_a_second(frames: list[Frame]) -> list[Frame]:
    """The vehicle speed at each full second, all else 0.6 s later."""
    kept, seen = [], set()
    for frame in frames:
        due_s = 0.0 if carries(frame, "GNSS") else 0.6
        turn = (frame.can_id, floor(frame.time_s - EPOCH_S - due_s))
        if turn[1] >= 0 and turn not in seen:
            seen.add(turn)
            kept.append(frame)
    return kept


def patient(settings: Settings) -> Settings:
    """With time-outs that fit."""

    def slow(mapping: SignalMapping) -> SignalMapping:
        return replace(mapping, timeout_s=TIMEOUT_S)

    one = {name: slow(getattr(settings.signals, name)) for name in ("speed", "sanding", "latitude", "longitude")}
    several = {
        name: tuple(map(slow, getattr(settings.signals, name)))
        for name in ("axle_speed", "pressing_force", "wsp_active", "load_force")
    }
    return replace(settings, signals=replace(settings.signals, **one, **several))


def alarms(fault: Fault) -> list[Alarm]:
    """As raised, without those of the estimates that such a bus does not allow for."""
    recording = drive(DRY)
    pipeline = Pipeline.from_settings(patient(recording.settings))
    given = [alarm for frame in fault(once_a_second(recording.frames)) for alarm in pipeline.step(frame).alarms]
    raised = {alarm.id: alarm for alarm in reversed(given)}
    return [alarm for alarm in raised.values() if alarm.kind in {"input_lost", "bus_silent"}]


@pytest.mark.parametrize(("message", "place"), [("GNSS", {None}), ("WSP", {1, 2})])
def test_a_message_that_is_lost_is_told_of(message: str, place: set[int | None]) -> None:
    found = alarms(lost(message, FAILS_S, inf))
    assert {(alarm.kind, alarm.wheelset) for alarm in found} == {("input_lost", at) for at in place}
    for alarm in found:
        after_s = alarm.raised_time_s - EPOCH_S - FAILS_S
        assert TIMEOUT_S - 1.0 + DEBOUNCE_S <= after_s <= TIMEOUT_S + DEBOUNCE_S + 1.5  # heard of once a second


@pytest.mark.parametrize(
    ("from_s", "said"),
    [
        (FAILS_S, "Nothing arrives any more of the pressing force (BCU.p_{}) of wheelset {}."),
        (-1.0, "Nothing has arrived yet of the pressing force (BCU.p_{}) of wheelset {}."),
    ],
)
def test_what_never_came_is_not_said_to_have_ended(from_s: float, said: str) -> None:
    told = {alarm.message for alarm in alarms(lost("BCU", from_s, inf)) if alarm.wheelset}
    assert told == {said.format("A", 1), said.format("B", 2)}


@pytest.mark.parametrize("falls_silent_s", [9.5, 9.9, 10.3, 10.7])
def test_a_bus_that_falls_silent_is_told_of_as_such(falls_silent_s: float) -> None:
    """Whichever message came last: those before it lapse earlier, but the bus did not go on without them."""
    found = alarms(silence(falls_silent_s, 24.0))
    assert [alarm.kind for alarm in found] == ["bus_silent"]


def test_of_a_bus_that_is_well_nothing_is_told() -> None:
    assert alarms(lambda frames: frames) == []
