"""What air does to a brake cylinder passes at once; what it cannot do waits until it is borne out."""

from math import exp

import pytest
from hypothesis import given
from hypothesis import strategies as st

from brake_monitor.estimation.doubts.force_gate import DEAD_S, LEAST_FALL_N, ForceGate

CYCLES_S = st.sampled_from([0.005, 0.01, 0.02, 0.05, 0.1])
FULL_N = st.floats(5e3, 60e3)


@given(cycle_s=CYCLES_S, full_n=FULL_N, time_constant_s=st.floats(0.05, 1.0), rolls=st.booleans())
def test_a_cylinder_that_is_vented_passes_at_once(
    cycle_s: float, full_n: float, time_constant_s: float, rolls: bool
) -> None:
    gate = ForceGate()
    for k in range(200):
        time_s = k * cycle_s
        opened_s = max(time_s - 0.5, 0.0)
        assert gate.passes(10.0 + time_s, full_n * exp(-opened_s / time_constant_s), rolls)


@given(cycle_s=CYCLES_S, full_n=FULL_N, time_constant_s=st.floats(0.05, 1.0), rolls=st.booleans())
def test_a_cylinder_that_is_filled_passes_at_once(
    cycle_s: float, full_n: float, time_constant_s: float, rolls: bool
) -> None:
    gate = ForceGate()
    for k in range(200):
        filled_s = max(k * cycle_s - 0.5, 0.0)
        assert gate.passes(10.0 + k * cycle_s, full_n * (1.0 - exp(-filled_s / time_constant_s)), rolls)


@given(cycle_s=CYCLES_S, step_n=st.floats(1.0, LEAST_FALL_N - 1.0), rolls=st.booleans())
def test_what_a_coarse_sensor_or_its_noise_takes_from_a_light_force_passes_at_once(
    cycle_s: float, step_n: float, rolls: bool
) -> None:
    """No air leaves so fast, and it goes to and fro."""
    gate = ForceGate()
    assert all(gate.passes(10.0 + k * cycle_s, step_n * (k % 2), rolls) for k in range(20))


@pytest.mark.parametrize("unlikely", [False, True])
@pytest.mark.parametrize("wrong_n", [0.0, 290e3])
def test_a_single_reading_that_is_wrong_is_never_used(wrong_n: float, unlikely: bool) -> None:
    """A wire that touches another for a moment; the reading after it is as those before."""
    gate, told = ForceGate(), []
    for k in range(20):
        told += believed(gate, 10.0 + 0.01 * k, wrong_n if k == 10 else 30e3, unlikely=unlikely)
        assert not gate.bears_out
    assert {force_n for _, force_n in told} == {30e3}
    assert told[-1] == (pytest.approx(10.19), 30e3)
    assert not gate.is_dead
    assert gate.passes(10.2, 30e3, True)  # nothing is held back any more


@pytest.mark.parametrize("wrong_n", [(12e3,), (40e3,), (70e3,), (12e3, 8e3), (40e3, 60e3)])
@pytest.mark.parametrize("cycle_s", [0.01, 0.02, 0.04])
@pytest.mark.parametrize("usual_n", [0.0, 5e3])
def test_back_from_a_spike_that_air_might_have_made_it_is_no_sensor_that_died(
    wrong_n: tuple[float, ...], cycle_s: float, usual_n: float
) -> None:
    """A wire beside the motor's, for a frame or two: no brake is filled and vented so quickly."""
    gate, told = ForceGate(), []
    for k in range(60):
        wrong = 20 <= k < 20 + len(wrong_n)
        force_n = wrong_n[k - 20] if wrong else usual_n
        told += believed(gate, 10.0 + k * cycle_s, force_n, unlikely=k > 20)
        assert not gate.is_dead
    assert told[-1] == (pytest.approx(10.0 + 59 * cycle_s), usual_n)
    assert [force_n for time_s, force_n in told if time_s > 10.0 + 22.5 * cycle_s] == [usual_n] * 37


@pytest.mark.parametrize("opens_every", [1, 2])
def test_a_vented_cylinder_whose_springs_take_the_pads_back_is_no_sensor_that_died(opens_every: int) -> None:
    """Air leaves ever more slowly, but the force comes to 0 and stays there; another brake presses on.

    The valve is open for good, or for every second cycle.
    """
    cycle_s, springs_n, time_constant_s = 0.05, 5750.0, 0.15
    for full_n in range(5000, 40000, 100):
        gate, air_n = ForceGate(), full_n + springs_n
        for k in range(200):
            if k >= 10 and k % opens_every == 0:
                air_n *= exp(-cycle_s / time_constant_s)
            believed(gate, 10.0 + k * cycle_s, max(air_n - springs_n, 0.0), unlikely=True)
            assert not gate.is_dead


@given(cycle_s=CYCLES_S, full_n=FULL_N, settles_at=st.floats(0.0, 0.8))
def test_a_fall_that_goes_on_is_borne_out(cycle_s: float, full_n: float, settles_at: float) -> None:
    """Readings that differ come from a sensor that lives: a message that was lost hid how the force fell."""
    gate = ForceGate()
    assert gate.passes(10.0, full_n, True)
    fallen = [(10.0 + k * cycle_s, settles_at * full_n - k) for k in (1, 2)]
    taken = [pair for pair in fallen for pair in believed(gate, *pair, unlikely=True)]
    assert taken[-1] == fallen[-1]
    assert not gate.is_dead


@given(cycle_s=st.sampled_from([0.005, 0.01, 0.02]), full_n=FULL_N, unlikely=st.booleans())
def test_a_fall_to_a_value_that_repeats_itself_is_a_sensor_that_died_where_others_press_on(
    cycle_s: float, full_n: float, unlikely: bool
) -> None:
    gate = ForceGate()
    assert gate.passes(10.0, full_n, True)
    count = 1 + round(2.0 * DEAD_S / cycle_s)
    times_s = [10.0 + k * cycle_s for k in range(1, count + 1)]
    taken = [pair for time_s in times_s for pair in believed(gate, time_s, 0.0, unlikely=unlikely)]
    assert taken == ([] if unlikely else [(time_s, 0.0) for time_s in times_s])
    assert gate.is_dead is unlikely


@given(cycle_s=st.sampled_from([0.005, 0.01]), full_n=st.floats(90e3, 300e3), rolls=st.booleans())
def test_a_rise_to_a_value_that_repeats_itself_is_a_sensor_that_failed_where_it_did_not_press_so_lately(
    cycle_s: float, full_n: float, rolls: bool
) -> None:
    """Slide protection may fill it again at once, in models of rigs."""
    for unlikely in (True, False):
        gate = ForceGate()
        assert gate.passes(10.0, 1e3, rolls)
        count = 1 + round(2.0 * DEAD_S / cycle_s)
        for k in range(1, count + 1):
            time_s = 10.0 + k * cycle_s
            taken = gate.passes(time_s, full_n, rolls) or gate.pass_on(time_s, full_n, rolls, unlikely)
        assert gate.is_dead is unlikely
        assert bool(taken) is not unlikely


@given(full_n=FULL_N)
def test_a_brake_that_slide_protection_empties_at_once_is_borne_out(full_n: float) -> None:
    """No air does so, but models of rigs do."""
    gate = ForceGate()
    assert gate.passes(10.0, full_n, False)
    taken = [gate.passes(time_s, 0.0, False) or gate.pass_on(time_s, 0.0, False, True) for time_s in (10.01, 10.02)]
    assert taken[-1]
    assert not gate.is_dead


@given(full_n=FULL_N)
def test_a_fall_was_borne_out_until_the_next_reading(full_n: float) -> None:
    gate = ForceGate()
    assert gate.passes(10.0, full_n, True)
    assert not gate.bears_out
    assert len([pair for k in (1, 2) for pair in believed(gate, 10.0 + 0.01 * k, 0.0, unlikely=False)]) == 2
    assert gate.bears_out
    assert believed(gate, 10.03, 0.0, unlikely=False)
    assert not gate.bears_out


def test_a_fall_that_was_borne_out_is_no_jump_where_air_may_have_moved_so_far_meanwhile() -> None:
    """Of a wheelset without a speed adhesion goes with the force, unless one of two readings must be wrong."""
    gate = ForceGate()
    assert gate.passes(10.0, 30e3, True)
    assert len([pair for k in (1, 2) for pair in believed(gate, 10.0 + 0.01 * k, 0.0, unlikely=False)]) == 2
    assert gate.bears_out
    assert not gate.has_jumped()


FAR = pytest.mark.parametrize(("from_n", "to_n"), [(200e3, 0.0), (0.0, 200e3)], ids=["fall", "rise"])


@FAR
def test_what_was_borne_out_is_a_jump_where_air_cannot_have_moved_so_far(from_n: float, to_n: float) -> None:
    """Until the next reading, which is as the last one."""
    gate = ForceGate()
    for time_s in (10.0, 10.01):
        assert gate.passes(time_s, from_n, True)
    assert not gate.has_jumped()
    told = [believed(gate, time_s, to_n, unlikely=False) for time_s in (10.02, 10.03)]
    assert told == [[], [(10.02, to_n), (10.03, to_n)]]
    assert gate.has_jumped()
    assert believed(gate, 10.04, to_n, unlikely=False)
    assert not gate.has_jumped()


@FAR
def test_a_clock_that_is_set_back_holds_no_force_back(from_n: float, to_n: float) -> None:
    """Nobody knows how long air has had."""
    gate = ForceGate()
    assert gate.passes(5000.0, from_n, True)
    assert gate.passes(10.0, to_n, True)
    assert not gate.has_jumped()


@given(full_n=FULL_N)
def test_a_sensor_that_died_lives_again_where_it_says_something_else(full_n: float) -> None:
    gate = ForceGate()
    assert gate.passes(10.0, full_n, True)
    for k in range(1, 30):
        assert not believed(gate, 10.0 + 0.01 * k, 0.0, unlikely=True)
    assert gate.is_dead
    assert believed(gate, 10.3, 0.9 * full_n, unlikely=True) == [(10.3, 0.9 * full_n)]
    assert not gate.is_dead


def test_a_sensor_that_died_stays_dead_while_its_wheelset_slides() -> None:
    """What slide protection may do now does not explain what was impossible before."""
    gate = ForceGate()
    assert gate.passes(10.0, 30e3, True)
    for k in range(1, 60):
        assert not gate.passes(10.0 + 0.01 * k, 0.0, k < 30)
        assert not gate.pass_on(10.0 + 0.01 * k, 0.0, k < 30, unlikely=True)
    assert gate.is_dead


def test_a_sensor_that_dies_while_its_brake_is_eased_is_no_cylinder_that_is_vented() -> None:
    """Return springs take a force to 0 no faster than the air that left before."""
    gate = ForceGate()
    for k, force_n in enumerate([12e3, 9.5e3, 7e3]):
        assert gate.passes(10.0 + 0.1 * k, force_n, True)
    assert not [pair for k in range(3, 6) for pair in believed(gate, 10.0 + 0.1 * k, 0.0, unlikely=True)]
    assert gate.is_dead


@pytest.mark.parametrize("noise_n", [0.0, 1.0])
def test_a_sensor_is_alive_as_long_as_its_readings_differ_if_only_by_noise(noise_n: float) -> None:
    """One that repeats itself is no witness against the sensor of another brake."""
    gate = ForceGate()
    for k in range(100):
        assert gate.passes(10.0 + 0.01 * k, 40e3 + noise_n * (k % 2), True)
    assert gate.is_alive(11.0) is (noise_n > 0.0)


def believed(gate: ForceGate, time_s: float, pressing_force_n: float, *, unlikely: bool) -> list[tuple[float, float]]:
    """As the core asks, and who is asked where the core leaves it."""
    if gate.passes(time_s, pressing_force_n, True):
        return [(time_s, pressing_force_n)]
    return gate.pass_on(time_s, pressing_force_n, True, unlikely)


def test_nor_is_one_a_witness_whose_reading_is_held_back() -> None:
    gate = ForceGate()
    assert all(gate.passes(10.0 + 0.01 * k, 40e3 + k % 2, True) for k in range(10))
    assert gate.is_alive(10.1)
    assert not believed(gate, 10.1, 0.0, unlikely=True)
    assert not gate.is_alive(10.1)


@pytest.mark.parametrize(
    "told",
    [
        [(0.0, 30e3), (0.01, 60e3), (0.02, 0.0)],
        [(0.0, 40e3), (0.02, 20e3), (0.04, 4e3)],
        [(0.0, 30e3), (0.03, 9.9e3), (0.06, 9.9e3), (0.97, 9.9e3), (1.0, 1e3)],
    ],
    ids=["below where a spike rose from", "from more than springs move", "long after it was vented"],
)
def test_a_fall_is_held_back_that_neither_a_spike_nor_springs_explain(told: list[tuple[float, float]]) -> None:
    gate = ForceGate()
    *before, (time_s, force_n) = told
    assert all(gate.passes(10.0 + early_s, early_n, True) for early_s, early_n in before)
    assert not gate.passes(10.0 + time_s, force_n, True)
