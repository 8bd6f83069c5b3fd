"""Creep, and how far the noise of wheel speeds leaves it in doubt: as far as it scatters, no less."""

from math import sqrt

import numpy as np
import pytest
from numpy.random import Generator

from brake_monitor.monitoring.creep_meter import AVERAGE_S, Creep, CreepMeter
from estimates import estimate, wheelset

STEP_S, FREE_UNTIL_S, END_S = 0.1, 20.0, 32.0
SPEED_MPS, RADIUS_M, CREEP = 15.0, 0.45, 0.0012
CONTACT_N, FULL_N = 2000.0, 40e3


def measured(rng: Generator, omega_std: float) -> list[Creep]:
    """Of the first of two wheelsets, both braked with CREEP after free rolling, wheel speeds as they are read."""
    meter, found = CreepMeter(CONTACT_N), []
    for time_s in np.arange(0.0, END_S, STEP_S).tolist():
        creep, force_n = (CREEP, FULL_N) if time_s >= FREE_UNTIL_S else (0.0, 0.0)
        omega = SPEED_MPS * (1.0 - creep) / RADIUS_M + omega_std * rng.standard_normal(2)
        noise = omega_std**2 * STEP_S
        own = [wheelset(omega_radps=w, omega_noise=noise, pressing_force_n=force_n, slip=creep) for w in omega.tolist()]
        now = estimate(time_s=time_s, speed_mps=SPEED_MPS, saturated=False, wheelsets=tuple(own))
        meter.note(now, (True, True))
        creeps = meter.creep(now)
        if time_s >= FREE_UNTIL_S + 4.0:
            assert creeps is not None
            found.append(creeps[0])
    return found


@pytest.mark.parametrize("omega_std", [0.002, 0.03], ids=["fine", "coarse"])
def test_the_doubt_is_neither_smaller_than_the_scatter_nor_twice_as_large(omega_std: float) -> None:
    rng = np.random.default_rng(1)
    runs = [measured(rng, omega_std) for _ in range(300)]
    whole_s = len(runs[0]) * STEP_S
    for values, claimed in (
        ([run[-1].value for run in runs], runs[0][-1].std(AVERAGE_S)),
        ([float(np.mean([creep.value for creep in run])) for run in runs], runs[0][-1].std(whole_s)),
    ):
        scatter = sqrt(float(np.mean((np.array(values) - CREEP) ** 2)))
        assert 0.5 * claimed < scatter < 1.05 * claimed


def test_what_is_exact_leaves_no_doubt() -> None:
    creep = measured(np.random.default_rng(1), 0.0)[-1]
    assert creep.value == pytest.approx(CREEP, rel=1e-4)  # twelve time constants after the onset
    assert creep.std(AVERAGE_S) == 0.0


def test_a_wheelset_that_stands_has_its_doubt_too() -> None:
    meter = CreepMeter(CONTACT_N)
    for k in range(100):
        own = wheelset(omega_radps=33.0, pressing_force_n=0.0)
        meter.note(estimate(time_s=0.1 * k, saturated=False, wheelsets=(own, own)), (True, True))
    stands = wheelset(omega_radps=0.0, pressing_force_n=FULL_N)
    now = estimate(time_s=10.0, saturated=False, wheelsets=(own, stands))
    meter.note(now, (True, True))
    found = meter.creep(now)
    assert found is not None
    assert found[1].std(AVERAGE_S) == pytest.approx(1.0, rel=0.01)


@pytest.mark.parametrize("rolls_s", [0.0, 5.0, 30.0])
@pytest.mark.parametrize("turned", [0.97, 1.0])
def test_what_a_wheelset_was_before_it_was_turned_does_not_count(turned: float, rolls_s: float) -> None:
    """It stands for eight hours, rolls on, and is braked; without any free rolling nothing is known."""
    meter = CreepMeter(CONTACT_N)
    for begin_s, rolled_s, radius_m in ((0.0, 60.0, RADIUS_M), (8 * 3600.0, rolls_s, turned * RADIUS_M)):
        for time_s in np.arange(begin_s, begin_s + rolled_s + 12.0, STEP_S).tolist():
            creep, force_n = (CREEP, FULL_N) if time_s >= begin_s + rolled_s else (0.0, 0.0)
            omegas = [SPEED_MPS * (1.0 - creep) / own_m for own_m in (radius_m, RADIUS_M)]
            own = [wheelset(omega_radps=omega, pressing_force_n=force_n, slip=creep) for omega in omegas]
            now = estimate(time_s=time_s, speed_mps=SPEED_MPS, saturated=False, wheelsets=tuple(own))
            meter.note(now, (True, True))
    found = meter.creep(now)
    assert (found is None) is (rolls_s == 0.0)
    assert [own.value for own in found or ()] == pytest.approx([CREEP] * 2 * (rolls_s > 0.0), rel=0.001)
