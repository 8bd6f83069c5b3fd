"""Polach's creep law against the peaks known from the literature, and its shape."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from brake_monitor.simulator.physics.creep import DRY, WET, law_for, utilisation

LOAD_N = 100e3
speeds = st.floats(1.0, 60.0)
slips = st.floats(1e-4, 0.9)
levels = st.floats(0.01, 0.6)


def peak(mu0: float) -> tuple[float, float]:
    """Highest F/Q and the slip at which it stands."""
    law, speed_mps = law_for(mu0), 10.0
    curve = ((utilisation(s / 2000 * speed_mps, speed_mps, LOAD_N, mu0, law)[0], s / 2000) for s in range(1, 1000))
    return max(curve)


@pytest.mark.parametrize(
    ("mu0", "expected", "at_slip"),
    [(0.55, 0.427, 0.04), (0.30, 0.238, 0.11), (0.06, 0.054, 0.048), (0.03, 0.028, 0.033)],
)
def test_the_peaks_are_those_of_the_literature(mu0: float, expected: float, at_slip: float) -> None:
    value, slip = peak(mu0)
    assert value == pytest.approx(expected, abs=0.003)
    assert slip == pytest.approx(at_slip, abs=0.005)


def test_the_law_is_wet_at_low_and_dry_at_high_levels_and_mixed_between() -> None:
    assert law_for(0.05) == WET
    assert law_for(0.60) == DRY
    assert all(min(w, d) <= m <= max(w, d) for w, m, d in zip(WET, law_for(0.4), DRY, strict=True))


@given(speeds, slips, levels)
def test_the_force_opposes_the_slip_and_never_exceeds_the_level(speed: float, slip: float, mu0: float) -> None:
    law = law_for(mu0)
    braking, slope = utilisation(slip * speed, speed, LOAD_N, mu0, law)
    driving, same_slope = utilisation(-slip * speed, speed, LOAD_N, mu0, law)
    assert 0.0 < braking <= mu0
    assert driving == -braking
    assert slope == same_slope


@given(speeds, slips, levels)
def test_the_slope_is_the_derivative_by_slip_velocity(speed: float, slip: float, mu0: float) -> None:
    law, w = law_for(mu0), slip * speed
    step = 1e-5 * w
    above, below = (utilisation(w + d, speed, LOAD_N, mu0, law)[0] for d in (step, -step))
    slope = utilisation(w, speed, LOAD_N, mu0, law)[1]
    assert slope == pytest.approx((above - below) / (2.0 * step), rel=1e-4, abs=1e-6)


def test_no_slip_no_force_and_stiffest_there() -> None:
    force, slope = utilisation(0.0, 20.0, LOAD_N, 0.3, WET)
    assert force == 0.0
    assert slope > utilisation(0.2, 20.0, LOAD_N, 0.3, WET)[1] > 0.0


def test_far_past_the_peak_the_curve_falls() -> None:
    assert utilisation(5.0, 20.0, LOAD_N, 0.1, WET)[1] < 0.0


def test_standstill_is_defined() -> None:
    force, _ = utilisation(1e-3, 0.0, LOAD_N, 0.3, WET)
    assert 0.0 < force < 0.3
