"""What is seen and yet no news: of a wagon that is parked, and of wheelsets that slide."""

from collections.abc import Callable
from math import inf

import pytest

from brake_monitor.estimation.core.core import Core
from brake_monitor.estimation.core.correction import FROZEN, TAKEN
from brake_monitor.estimation.doubts.consistency import BIASED
from test_doubted_friction import braking

SPACING_S = 0.01
TREMBLING_N = (0.0, 60.0, -30.0, 30.0)  # about a step of its sensor


@pytest.fixture
def core() -> Core:
    """Of a wagon on two wheelsets, in the midst of a brake."""
    return braking(2).core


@pytest.mark.parametrize(("stands", "outcome"), [(True, TAKEN), (False, FROZEN)])
def test_a_parked_wagons_pressing_force_may_sleep(core: Core, stands: bool, outcome: int) -> None:
    core.now.near_standstill = stands
    begin_s, force_n = core.now.time_s, core.wheels[0].force.value
    for k in range(400):
        trembling_n = TREMBLING_N[k % len(TREMBLING_N)] if k < 300 else 0.0
        last = core.take_force(0, begin_s + k * SPACING_S, force_n + trembling_n)
    assert last == outcome


@pytest.mark.parametrize("acts", [True, False])
def test_a_wheelset_that_its_slide_protection_has_released_tells_nothing_of_its_radius(core: Core, acts: bool) -> None:
    """No pad has pressed for long, but it need not have found back to rolling."""
    core.now.pressed_s, core.now.wsp_active = core.now.time_s - 10.0, acts
    radius_m = core.wheels[0].radius.radius_m
    core.filter.x[0] *= 0.98
    core.see_free_rolling(SPACING_S)
    assert (core.wheels[0].radius.radius_m == radius_m) is acts


@pytest.mark.parametrize("acts", [True, False])
def test_a_wheelset_tells_a_lost_speed_of_the_vehicle_only_while_no_slide_protection_acts(
    core: Core, acts: bool
) -> None:
    core.now.wsp_active = acts
    speed, rim_mps = core.wheelset_count, core.fastest_mps()
    speed_mps = core.filter.x[speed] = rim_mps * 1.01
    core.filter.covariance[speed][speed] = 0.1
    core.filter.x[0] = rim_mps / core.wheels[0].radius.radius_m
    assert core.follow_rolling(0, core.filter.x[0], 1e-4)
    assert (core.filter.x[speed] == speed_mps) is acts


@pytest.mark.parametrize("bound", ["least", "most"])
def test_a_lag_at_either_bound_explains_nothing(core: Core, bound: str) -> None:
    assert not core.is_lag_at_limit()
    core.filter.x[core.lag_place] = getattr(core.filter, bound)[core.lag_place]
    assert core.is_lag_at_limit()


def slide(core: Core) -> None:
    core.now.has_slid = True


def come_back(core: Core) -> None:
    core.now.application.back_from = -0.1


def contradict(core: Core) -> None:
    core.now.consistency.raised_s[BIASED] = core.now.time_s


def go_steadily_on(_: Core) -> None:
    """Nothing else accounts for the change."""


@pytest.mark.parametrize(
    ("meanwhile", "doubts"), [(slide, False), (come_back, False), (contradict, False), (go_steadily_on, True)]
)
def test_a_deceleration_that_changes_is_in_doubt_only_where_nothing_else_accounts_for_it(
    core: Core, meanwhile: Callable[[Core], None], doubts: bool
) -> None:
    """Slides teach friction, what comes back is friction's, and a speed that contradicts widens it anyway."""
    now, brakes, place = core.now, core.filter, core.friction_place
    now.has_slid, now.application.back_from, now.consistency.raised_s[BIASED] = False, 0.0, -inf
    core.see_changes()
    meanwhile(core)
    before = brakes.std(place)
    brakes.x[core.deceleration_place] += 0.2
    now.time_s += 0.1
    core.see_changes()
    assert (brakes.std(place) > before) is doubts


@pytest.mark.parametrize(
    ("known_std_mps2", "change_mps2", "doubts"),
    [(0.0, 0.5, True), (0.0, 5e-4, False), (0.1, 0.5, False)],
    ids=["a change", "noise", "what was not known before"],
)
def test_only_what_was_known_can_change_and_by_more_than_it_wanders(
    core: Core, known_std_mps2: float, change_mps2: float, doubts: bool
) -> None:
    now, brakes, place = core.now, core.filter, core.friction_place
    now.consistency.raised_s[BIASED] = -inf
    brakes.widen(core.deceleration_place, known_std_mps2**2)
    core.see_changes()
    before = brakes.std(place)
    brakes.x[core.deceleration_place] += change_mps2
    now.time_s += 0.1
    core.see_changes()
    assert (brakes.std(place) > before) is doubts
