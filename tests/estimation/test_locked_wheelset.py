"""A wheelset that its brake holds fast: its pads do not slide, and nothing tells of the friction that they have then.

Discs that hardly turn are held by up to a quarter more, and let go of that within some seconds as they turn again.
"""

from math import inf

import numpy as np
import pytest

from brake_monitor.estimation.estimate import Status
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.scenarios import Profile, Scenario, Track, steps
from brake_monitor.simulator.simulate import run
from drives import Judged, play
from faults import changed

BRAKE_FROM_S = 5.0


@pytest.mark.parametrize(("mass_factor", "better_rail"), [(0.4, 0.15), (0.35, 0.16)])
def test_friction_is_doubted_as_wheelsets_turn_again_that_stood(mass_factor: float, better_rail: float) -> None:
    """An empty wagon without slide protection, on a rail that lets it turn again as the wagon has slowed down."""
    scenario = Scenario(
        name="locked",
        summary="brake from 5 s, locked from 7 to 13 s",
        initial_speed_mps=12.0,
        duration_s=17.0,
        demand=steps((BRAKE_FROM_S, 0.43)),
        rail_over_time=Profile(((4.0, 0.02), (9.0, 0.02), (10.0, better_rail))),
    )
    modifiers = Modifiers(slide_protection=False, mass_factor=mass_factor)
    recording = run(scenario, example_settings("wagon"), seed=5, modifiers=modifiers)
    judged = Judged.of(recording, play(recording.settings, recording.frames)).during(BRAKE_FROM_S)
    held = [e for e in judged.told if all(wheelset.slip > 0.98 for wheelset in e.wheelsets)]
    assert held[-1].time_s - held[0].time_s > 5.0
    assert all(wheelset.friction_status is Status.HELD for e in held for wheelset in e.wheelsets)
    judged.assert_honest()


def test_a_descent_that_begins_while_wheelsets_stand_is_not_read_as_friction() -> None:
    """Only the vehicle's speed tells of the rail then, and of the line, so that neither contradicts anything.

    What remains untold as the wheelsets turn again is the line's as well as the pads'.
    """
    scenario = Scenario(
        name="locked on a crest",
        summary="brake from 5 s, locked from 7 to 21 s; from 9 to 17 s the line turns 10 ‰ down",
        initial_speed_mps=14.0,
        duration_s=30.0,
        demand=steps((BRAKE_FROM_S, 0.6)),
        rail_over_time=Profile(((4.0, 0.3), (4.5, 0.02), (20.0, 0.02), (22.0, 0.3))),
        track=Track(gradient=Profile(((120.0, 0.0), (220.0, -0.01))), curvature_pm=Profile(((0.0, 0.0),))),
    )
    modifiers = Modifiers(slide_protection=False, mass_factor=0.5)
    recording = run(scenario, example_settings("bogie"), seed=5, modifiers=modifiers)
    judged = Judged.of(recording, play(recording.settings, recording.frames)).during(BRAKE_FROM_S)
    crest = judged.during(9.0, 17.0)
    assert min(wheelset.slip for e in crest.told for wheelset in e.wheelsets) > 0.98
    judged.assert_honest()


def test_a_wheelset_that_nearly_locks_with_the_others_is_not_told_to_brake_more_than_they_do() -> None:
    """What pulls all of them back into rolling tells as little of the pads of the one that still turned."""
    scenario = Scenario(
        name="three of four",
        summary="brake from 6 s, three locked and one nearly so at 9 s, all rolling by 10 s",
        initial_speed_mps=26.0,
        duration_s=13.5,
        demand=steps((6.0, 0.84)),
        rail_over_time=Profile(((4.0, 0.3), (4.5, 0.03), (9.0, 0.03), (9.6, 0.3))),
    )
    recording = run(scenario, example_settings("bogie"), seed=5, modifiers=Modifiers(slide_protection=False))
    judged = Judged.of(recording, play(recording.settings, recording.frames))
    turns = [1.0 - wheelset.slip for wheelset in judged.during(9.2).told[0].wheelsets]
    assert [share < 0.03 for share in turns] == [True, True, True, False]
    assert np.ptp(judged.friction_error[-1]) < 0.06
    judged.assert_honest()


def test_what_the_rail_gives_does_not_fall_to_nothing_on_the_way_to_a_lock() -> None:
    """By how much it falls with slip speed was learned where slip was small; a wheelset that nearly stands goes on.

    A rail that gave ever less would have the brakes do ever less, and the line retard the wagon instead.
    """
    scenario = Scenario(
        name="long slides",
        summary="brake from 8 s, a short slide at first and a long one from 20 s on that ends locked",
        initial_speed_mps=36.0,
        duration_s=25.0,
        demand=steps((8.0, 0.38)),
        rail_over_time=Profile(((9.3, 0.01), (10.3, 0.3), (18.6, 0.3), (21.0, 0.02))),
    )
    modifiers = Modifiers(slide_protection=False, mass_factor=0.6, gradient=-0.008)
    recording = run(scenario, example_settings("bogie"), seed=5, modifiers=modifiers)
    judged = Judged.of(recording, play(recording.settings, recording.frames))
    sliding = judged.during(22.5, 25.0)
    assert min(wheelset.slip for e in sliding.told for wheelset in e.wheelsets) > 0.1
    assert abs(sliding.adhesion_error.mean()) < 0.002
    judged.during(12.0, 25.0).assert_honest()


@pytest.mark.parametrize("cut_out_kmh", [2.5, 3.5])
def test_what_a_wheelset_loses_as_its_sensor_cuts_out_is_not_taken_from_the_rail(cut_out_kmh: float) -> None:
    """Below some speed a sensor says 0, so that a wheelset on its way to a lock seems to stop at once."""
    scenario = Scenario(
        name="cut out",
        summary="brake from 5 s on a rail on which all wheelsets lock",
        initial_speed_mps=28.0,
        duration_s=18.0,
        demand=steps((BRAKE_FROM_S, 0.8)),
        rail_over_time=Profile(((4.0, 0.05), (18.0, 0.05))),
    )
    recording = run(scenario, example_settings("wagon"), seed=5, modifiers=Modifiers(slide_protection=False))
    cut_out = changed("WSP", ("n_A", "n_B"), lambda _, kmh: 0.0 if kmh < cut_out_kmh else kmh, 0.0, inf)
    judged = Judged.of(recording, play(recording.settings, cut_out(recording.frames))).during(BRAKE_FROM_S)
    assert max(wheelset.slip for wheelset in judged.told[-1].wheelsets) == 1.0
    assert abs(judged.adhesion_error).max() < 0.02
    judged.assert_honest()
