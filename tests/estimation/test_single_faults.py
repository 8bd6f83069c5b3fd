"""Faults that were once believed for long: what they taught stayed, or was doubted until the next braking."""

from functools import reduce

import numpy as np
import pytest

from brake_monitor.estimation.doubts.consistency import Doubt
from brake_monitor.estimation.estimate import Status
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.brake_faults import BrakeFault
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.scenarios import SCENARIOS, Profile, Scenario, steps
from brake_monitor.simulator.simulate import run as simulate
from drives import DRY, END_S, SLIDE, Judged, drive, play
from faults import Fault, changed, frozen, lost, signal_changed

TOP_BAR = 10.0  # of the range of the DBC
BRAKED_FROM_S = 5.0
LIGHT = Scenario(
    name="light braking",
    summary="coast, brake lightly from 5 to 15 s, coast",
    initial_speed_mps=32.0,
    duration_s=END_S,
    demand=steps((5.0, 0.4), (15.0, 0.0)),
    rail_over_time=Profile(((0.0, 0.45),)),
)
FULL = Scenario(
    name="full braking",
    summary="coast, brake fully from 5 s on",
    initial_speed_mps=32.0,
    duration_s=END_S,
    demand=steps((5.0, 1.0)),
    rail_over_time=Profile(((0.0, 0.45),)),
)
UNIT = ("wheel speed", "pressing force")  # what one of them tells


def judged(scenario: Scenario, *faults: Fault) -> Judged:
    """A drive with faults, as honest as it has to be."""
    recording = drive(scenario)
    frames = reduce(lambda changed, fault: fault(changed), faults, list(recording.frames))
    seen = Judged.of(recording, play(recording.settings, frames))
    seen.assert_sound()
    seen.assert_honest()
    return seen


@pytest.mark.parametrize(("from_s", "to_s"), [(3.0, 8.0), (8.0, 11.0)], ids=["as the brake comes on", "braking"])
@pytest.mark.parametrize("scenario", [DRY, SLIDE], ids=lambda scenario: scenario.name)
def test_a_pressing_force_that_jumps_to_the_top_of_its_range_has_no_say(
    scenario: Scenario, from_s: float, to_s: float
) -> None:
    """A wire that touches the supply: no air fills a cylinder from one reading to the next."""
    seen = judged(scenario, signal_changed("pressing force", lambda _, __: TOP_BAR, from_s, to_s))
    shorted = seen.during(from_s + 0.3, to_s)
    assert shorted.statuses == {Status.INVALID}
    assert shorted.reasons == {"pressing_force 1 impossible"}
    assert seen.worst_friction() < 0.05
    assert seen.during(to_s + 4.0).statuses == {Status.VALID}


@pytest.mark.parametrize(("from_s", "lasts_s"), [(6.7, 0.7), (6.7, 0.9)])
def test_a_vehicle_speed_that_stands_still_for_a_moment_in_a_slide_is_not_doubted_until_its_end(
    from_s: float, lasts_s: float
) -> None:
    """It looks like one that comes early, of which nothing tells any more as long as wheelsets slide."""
    seen = judged(SLIDE, frozen("vehicle speed", from_s, from_s + lasts_s))
    assert seen.during(12.0, 14.0).statuses == {Status.VALID}


def test_a_vehicle_speed_that_has_said_0_since_the_start_is_no_standstill() -> None:
    """The wheelsets turn: the speed is theirs, and a dead sensor is told of."""
    seen = judged(DRY, signal_changed("vehicle speed", lambda _, __: 0.0, -1.0, END_S)).during(2.0)
    assert seen.reasons == {"speed 1 frozen"}
    assert [e.speed_mps for e in seen.told] == pytest.approx(seen.truth.speed_mps, rel=0.02)


@pytest.mark.parametrize("from_s", [5.45, 5.5])
def test_brakes_that_do_more_than_frozen_forces_say_are_taken_for_no_line(from_s: float) -> None:
    """Sensors that hang as the brake comes on: what is missing looks like a gradient that comes at once."""
    seen = judged(DRY, *[hangs(signal, from_s, 12.9) for signal in ("p_A", "p_B")])
    assert Doubt.UNEXPLAINED in seen.during(10.0, 12.5).reasons


def hangs(signal: str, from_s: float, to_s: float) -> Fault:
    """A pressing force says the same again and again."""
    told: list[float] = []

    def repeat(_: float, value: float) -> float:
        told.append(value)
        return told[0]

    return changed("BCU", (signal,), repeat, from_s, to_s)


@pytest.mark.parametrize("to_s", [7.0, 8.0, 8.9])
def test_a_force_that_is_not_told_until_a_while_after_the_brake_came_on_teaches_nothing(to_s: float) -> None:
    """Its brake works: what it does would be taken for the friction of the other."""
    seen = judged(DRY, signal_changed("pressing force", lambda _, __: 0.0, 1.0, to_s))
    silent, after = seen.during(BRAKED_FROM_S, to_s), seen.during(to_s + 1.0, 12.5)
    assert np.abs(silent.friction_error[:, 1]).max() < 0.05
    assert np.abs(after.friction_error).max() < 0.05


def test_a_brake_that_has_shown_to_be_isolated_costs_the_others_nothing_at_the_next_application() -> None:
    """At the first one it might have worked unseen; it has shown since that it does not."""
    recording = drive(DRY, Modifiers(brake_faults=(BrakeFault(0, isolated=True),)))
    seen = Judged.of(recording, play(recording.settings, list(recording.frames)))
    seen.assert_honest()
    assert Status.VALID not in seen.during(6.0, 7.0).friction_statuses(1)
    assert seen.during(18.5).friction_statuses(1) == {Status.VALID}


@pytest.mark.parametrize("to_s", [7.0, 8.0])
def test_a_unit_that_says_0_of_its_wheelset_is_learned_from_as_soon_as_it_is_back(to_s: float) -> None:
    """Its brake pressed all the time: as its force is told again the rail gives no more than before."""
    seen = judged(DRY, *[signal_changed(sensor, lambda _, __: 0.0, 3.0, to_s) for sensor in UNIT])
    after = seen.during(to_s + 2.5, 12.5)
    assert after.statuses == {Status.VALID}
    assert np.abs(after.friction_error).max() < 0.05


@pytest.mark.parametrize("seed", [1, 2])
def test_what_a_brake_does_unseen_for_a_second_as_brakes_come_on_is_no_friction_of_the_others(seed: int) -> None:
    """The others' adhesion and friction bore it: as the force was told again, friction was a quarter too high."""
    recording = simulate(SCENARIOS["sanding"], example_settings("bogie"), seed)
    frames = changed("BrakeTrail", ("p_3",), lambda _, __: 0.0, 5.2, 6.2, vehicle="bogie")(list(recording.frames))
    seen = Judged.of(recording, play(recording.settings, frames))
    seen.assert_sound()
    seen.assert_honest()
    assert seen.during(6.6, 12.0).worst_friction() < 0.06


def test_what_the_wagon_uses_of_the_rail_is_known_while_a_brake_presses_unseen() -> None:
    seen = judged(DRY, signal_changed("pressing force", lambda _, __: 0.0, 1.0, END_S))
    silent = seen.during(BRAKED_FROM_S + 0.7, BRAKED_FROM_S + 2.4)
    std = np.array([e.adhesion_std for e in silent.told])
    assert (np.abs(silent.adhesion_error) < 3.0 * std).all()
    assert silent.rmse < 0.008


def test_all_forces_that_are_gone_at_once_are_dead_as_long_as_the_wagon_retards_on() -> None:
    """No air goes at once; and no line that begins in that moment takes from the speed what the brakes took."""
    gone = [changed("BCU", (signal,), lambda _, __: 0.0, 9.0, 14.5) for signal in ("p_A", "p_B")]
    seen = judged(LIGHT, *gone)
    silent = seen.during(9.3, 14.4)
    assert silent.statuses == {Status.INVALID}
    assert silent.reasons == {"pressing_force 1 impossible", "pressing_force 2 impossible"}
    assert silent.worst < 0.01
    told_again = seen.during(15.0, 16.0)
    assert told_again.statuses == {Status.VALID}
    assert told_again.worst < 0.006


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_forces_that_nobody_tells_as_the_brake_comes_on_leave_friction_and_line_as_they_were(seed: int) -> None:
    """What the wagon loses is what its brakes do: were it taken for the line, their pads would seem to do nothing."""
    recording = simulate(FULL, example_settings("bogie"), seed)
    untold = [lost(message, 4.0, 9.0, vehicle="bogie") for message in ("BrakeLead", "BrakeTrail")]
    frames = reduce(lambda changed, fault: fault(changed), untold, list(recording.frames))
    seen = Judged.of(recording, play(recording.settings, frames))
    seen.assert_sound()
    seen.assert_honest()
    silent = seen.during(7.0, 9.0)
    assert silent.statuses == {Status.INVALID}
    assert silent.worst < 0.02
    told_again = seen.during(10.0, 14.0)
    assert told_again.statuses == {Status.VALID}
    assert told_again.worst < 0.01
    assert told_again.worst_friction() < 0.05


def test_forces_that_are_gone_at_once_are_believed_once_the_wagon_rolls_on() -> None:
    """They have died in mid-brake, say 0 ever after, and the brake is released: nothing is left that contradicts 0."""
    gone = [changed("BCU", (signal,), lambda _, __: 0.0, 9.0, 60.0) for signal in ("p_A", "p_B")]
    assert judged(LIGHT, *gone).during(19.0, 23.0).statuses == {Status.VALID}


def test_nothing_is_counted_as_sliding_while_the_vehicles_speed_is_lost() -> None:
    """The slip of a wheelset that turns more slowly than was foretold in a tunnel is not known."""
    slower = signal_changed("wheel speed", lambda _, kmh: 0.85 * kmh, 14.0, 16.5)
    seen = judged(DRY, slower, lost("GNSS", 13.5, 17.0))
    assert max(estimate.wheelsets[0].slip for estimate in seen.during(14.0, 16.5).told) > 0.1
    assert seen.told[-1].wheelsets[0].work.sliding_distance_m == 0.0
