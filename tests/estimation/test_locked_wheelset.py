"""A wheelset that its brake holds fast: its pads do not slide, and nothing tells of the friction that they have then.

Discs that hardly turn are held by up to a quarter more, and let go of that within some seconds as they turn again.
"""

import pytest

from brake_monitor.estimation.estimate import Status
from brake_monitor.settings.config_file import load_settings
from brake_monitor.settings.vehicle_files import example_config
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.scenarios import Profile, Scenario, steps
from brake_monitor.simulator.simulate import run
from drives import Judged, play

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
    recording = run(scenario, load_settings(example_config("wagon")), seed=5, modifiers=modifiers)
    judged = Judged.of(recording, play(recording.settings, recording.frames)).during(BRAKE_FROM_S)
    held = [e for e in judged.told if all(wheelset.slip > 0.98 for wheelset in e.wheelsets)]
    assert held[-1].time_s - held[0].time_s > 5.0
    assert all(wheelset.friction_status is Status.HELD for e in held for wheelset in e.wheelsets)
    judged.assert_honest()
