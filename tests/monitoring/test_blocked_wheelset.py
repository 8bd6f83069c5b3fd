"""A wheelset that is dragged along though its brake says released: a hand brake is on, or the pads stick."""

from functools import cache

import pytest
from msgspec.structs import replace

from brake_monitor.estimation.estimate import Status
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.settings.config import Settings
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.brake_faults import BrakeFault
from brake_monitor.simulator.journey import Act, Leg, LegJourney
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.scenarios import Profile, Scenario, steps
from brake_monitor.simulator.simulate import Recording
from brake_monitor.simulator.simulate import run as simulate
from drives import Judged

EMPTY_KG = 12_600.0
HAND_BRAKE_N = 60e3
RAIL = 0.08
STAND_S = 4.0


def _pulled(rail: float) -> Scenario:
    return Scenario(
        name="pulled away",
        summary="an empty wagon stops with locked wheels, is pulled away as its brake is released, and stops again",
        initial_speed_mps=6.0,
        duration_s=110.0,
        demand=LegJourney(
            (
                Leg(Act.STAND, lasts_s=STAND_S, demand=0.8),
                Leg(Act.PULL, 12.0, pull_mps2=0.6),
                Leg(Act.STAND, lasts_s=STAND_S, demand=0.5),
            ),
            2000.0,
        ),
        rail_over_time=Profile(((0.0, rail),)),
    )


@cache
def empty(vehicle: str) -> Settings:
    settings = example_settings(vehicle)
    return replace(settings, vehicle=replace(settings.vehicle, mass_kg=EMPTY_KG))


def played(recording: Recording) -> tuple[list[Alarm], Judged]:
    """The alarms and the estimates that it gives."""
    pipeline = Pipeline.from_settings(recording.settings)
    outputs = [pipeline.step(frame) for frame in recording.frames]
    told = [output.estimate for output in outputs if output.estimate is not None]
    return [alarm for output in outputs for alarm in output.alarms], Judged.of(recording, told)


@cache
def pulled(vehicle: str) -> tuple[list[Alarm], Judged]:
    """The first wheelset stands all the way: the wagon has stopped, and the hand brake is on, or the pads stick."""
    faults = (BrakeFault(0, stuck_force_n=HAND_BRAKE_N),)
    return played(simulate(_pulled(RAIL), empty(vehicle), 1, Modifiers(brake_faults=faults, slide_protection=False)))


@pytest.mark.parametrize("vehicle", ["wagon", "bogie"])
def test_a_hand_brake_that_is_on_is_told_as_a_brake_that_drags_and_not_as_a_slippery_rail(vehicle: str) -> None:
    found, _ = pulled(vehicle)
    drags = [alarm for alarm in found if alarm.kind == "dragging_brake"]
    assert drags
    for drag in drags:  # as it is braked once more nothing new is said of it
        assert drag.wheelset == 1
        assert "hand brake" in drag.message
        assert drag.evidence["pressing_force_n"] < 1000.0
    assert {alarm.wheelset for alarm in found if alarm.kind == "wheelset_not_rotating"} >= {1}
    told = [alarm.evidence["least_adhesion"] for alarm in found if alarm.kind == "low_adhesion"]
    assert all(least > RAIL / 2 for least in told), told


@pytest.mark.parametrize("vehicle", ["wagon", "bogie"])
def test_adhesion_is_not_valid_and_wrong_while_a_wheelset_is_dragged_by_its_hand_brake(vehicle: str) -> None:
    _, judged = pulled(vehicle)
    stood = (judged.truth.omega_radps[:, 0] == 0.0) & (judged.truth.speed_mps > 2.0)
    assert stood.sum() > 200
    judged.assert_sound()
    runs = [k for k, speed_mps in enumerate(judged.truth.speed_mps) if speed_mps > 2.0 and judged.time_s[k] > 10.0]
    judged.during(float(judged.time_s[runs[0]]), float(judged.time_s[runs[-1]])).assert_honest()


@pytest.mark.parametrize(("vehicle", "rail"), [("wagon", 0.03), ("bogie", 0.015)])
def test_wheelsets_that_a_poor_rail_takes_long_to_turn_again_are_neither_held_nor_doubted(
    vehicle: str, rail: float
) -> None:
    """Those of an empty wagon, half a minute at the worst."""
    slippery = Scenario(
        name="turns late",
        summary="an empty wagon brakes without slide protection on wet leaves that go on after the release",
        initial_speed_mps=33.0,
        duration_s=45.0,
        demand=steps((3.0, 0.8), (12.0, 0.0)),
        rail_over_time=Profile(((0.0, 0.3), (3.0, rail))),
    )
    found, judged = played(simulate(slippery, empty(vehicle), 1, Modifiers(slide_protection=False)))
    slips = judged.truth.omega_radps[:, -1] * 0.4 < 0.7 * judged.truth.speed_mps
    assert judged.time_s[slips].max() > 12.0 + 6.0, "they find back too soon for this test"
    assert {alarm.kind for alarm in found} == {"wheelset_not_rotating", "low_adhesion", "slide"}
    assert judged.during(5.0, 45.0).statuses == {Status.VALID}
    judged.assert_honest()
