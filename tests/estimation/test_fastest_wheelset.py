"""How fast a wheelset may leave its prediction, so that a reading which does is no spike: written down by hand."""

import pytest

from brake_monitor.estimation.core.core import Core
from brake_monitor.estimation.core.correction import LARGEST_ADHESION, UNBRAKED_RADPS2
from brake_monitor.settings.bounds import LARGEST_FRICTION
from test_doubted_friction import braking
from test_estimator import BRAKE_RADIUS_M, GRAVITY_MPS2, INERTIA_KGM2, RADIUS_M, Run, vehicle

GATE_RADPS = 0.1
HARDEST_RADPS2 = LARGEST_FRICTION * Run().pressing_force_n * BRAKE_RADIUS_M / INERTIA_KGM2
DRY_RAIL_RADPS2 = LARGEST_ADHESION * vehicle(2).mass_kg / 2 * GRAVITY_MPS2 * RADIUS_M / INERTIA_KGM2


@pytest.fixture
def core() -> Core:
    """Of a wagon on two wheelsets, in the midst of a brake."""
    return braking(2).core


def test_no_reading_of_a_wheelset_that_its_pads_stop_is_a_spike(core: Core) -> None:
    assert HARDEST_RADPS2 < DRY_RAIL_RADPS2
    fastest = core.fastest_radps2(0, -1.0, GATE_RADPS)
    assert HARDEST_RADPS2 <= fastest <= HARDEST_RADPS2 + UNBRAKED_RADPS2


@pytest.mark.parametrize("residual", [-1.0, 1.0])
def test_where_its_pressing_force_is_lost_it_may_be_as_fast_as_a_dry_rail_makes_it(core: Core, residual: float) -> None:
    core.wheels[0].force_lost = True
    assert core.fastest_radps2(0, residual, GATE_RADPS) == pytest.approx(DRY_RAIL_RADPS2, rel=0.1)  # loads shift


def test_the_rail_turns_it_up_until_it_rolls_and_nothing_beyond(core: Core) -> None:
    rolling_radps = core.filter.x[2] / RADIUS_M
    core.filter.x[0] = 0.5 * rolling_radps
    to_rolling = core.fastest_radps2(0, 0.5 * rolling_radps, GATE_RADPS)
    beyond = core.fastest_radps2(0, 0.6 * rolling_radps, GATE_RADPS)
    assert to_rolling == pytest.approx(DRY_RAIL_RADPS2, rel=0.1)
    assert beyond == UNBRAKED_RADPS2
