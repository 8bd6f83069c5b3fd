"""How well the mean friction of many brake applications is known: better than that of one, as far as each is anew."""

import numpy as np
import pytest

from brake_monitor.monitoring.brake_units.application_record import ApplicationRecord, WheelsetRecord
from brake_monitor.monitoring.brake_units.brakes import Brakes
from brake_monitor.monitoring.rule import Finding, Verdict
from brake_monitor.monitoring.rules.friction_out_of_band import FrictionOutOfBand
from brake_monitor.monitoring.rules.mean_friction import pooled
from brake_monitor.settings.alarm_settings import FrictionOutOfBandRule
from brake_monitor.settings.wear_settings import WearSettings
from estimates import estimate, observation

NOMINAL, ALIKE_STD = 0.35, 0.011
COUNT = 20  # as many as are looked at


def stops(friction: float, std: float, prior_std: float | None) -> tuple[ApplicationRecord, ...]:
    own = WheelsetRecord(
        energy_j=2e6,
        force_travel_nm=7e6,
        friction=friction,
        friction_std=std,
        friction_energy_j=2e6,
        pressing_force_n=None,
        torque_nm=None,
        sliding_distance_m=0.0,
        wsp_actions=0,
        greatest_slip=0.003,
        peak_disc_temperature_c=60.0,
        friction_gradient_std=0.0,
        friction_prior_std=prior_std,
    )
    return tuple(
        ApplicationRecord(start_s, start_s + 12.0, 25.0, 10.0, 220.0, 1.0, 0.1, 36e3, None, None, (own,))
        for start_s in np.arange(100.0, 100.0 + 300.0 * COUNT, 300.0).tolist()
    )


def judged(records: tuple[ApplicationRecord, ...], alike_std: float | None) -> Verdict:
    rule = FrictionOutOfBand(FrictionOutOfBandRule(), NOMINAL, 1, alike_std)
    brakes = Brakes(1e4, Brakes.new(1, WearSettings()).units, records)
    (verdict,) = rule.judge(observation(estimate(time_s=1e4), brakes=brakes))
    return verdict


@pytest.mark.parametrize("learned_anew", [0.4, 0.75, 0.95])
def test_the_mean_is_known_as_well_as_errors_that_go_from_stop_to_stop_let_it(learned_anew: float) -> None:
    """A filter whose error goes on by 1 - `learned_anew` of it, and one that all stops have alike."""
    rng, runs, std, carried = np.random.default_rng(3), 40000, 0.02, 1.0 - learned_anew
    fresh_std = np.sqrt((1.0 - carried**2) * (std**2 - ALIKE_STD**2))
    error = np.sqrt(std**2 - ALIKE_STD**2) * rng.standard_normal(runs)
    total = np.zeros(runs)
    for _ in range(COUNT):
        total += error
        error = carried * error + fresh_std * rng.standard_normal(runs)
    truly = float(np.std(total / COUNT + ALIKE_STD * rng.standard_normal(runs)))
    prior_std = np.sqrt(ALIKE_STD**2 + (std**2 - ALIKE_STD**2) / carried)
    (own,) = pooled(stops(0.3, std, prior_std), ALIKE_STD).wheelsets
    assert own.friction_std == pytest.approx(truly, rel=0.02)


def test_pads_that_weaken_within_weeks_are_told_before_they_have_lost_a_quarter() -> None:
    """Each stop learns most of friction anew; not so where it hardly shows, in a train, or by an older memory."""
    weak = 0.77 * NOMINAL
    assert isinstance(judged(stops(weak, 0.02, 0.036), ALIKE_STD), Finding)
    assert not isinstance(judged(stops(weak, 0.02, 0.0201), ALIKE_STD), Finding)
    assert not isinstance(judged(stops(weak, 0.02, 0.036), None), Finding)
    assert not isinstance(judged(stops(weak, 0.02, None), ALIKE_STD), Finding)
    assert not isinstance(judged(stops(0.86 * NOMINAL, 0.02, 0.036), ALIKE_STD), Finding)
