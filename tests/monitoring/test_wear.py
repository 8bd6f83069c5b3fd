"""Wear: what is left of the pads, and what gauge readings teach."""

import msgspec
import pytest

from brake_monitor.monitoring.brake_units.wear import PadUse, PadWear, Rate, energy_loss_mm, pad_life
from brake_monitor.settings.wear_settings import WearSettings

SETTINGS = WearSettings()
STOP_MJ = 0.5 * 80e3 * (100.0 / 3.6) ** 2 / 1e6  # 80 t from 100 km/h


def worn(pads: PadWear, true_wear_cm3_per_mj: float, energy_j: float) -> float:
    """The thickness that pads of this true wear rate have after so much energy from their last gauge on, mm."""
    return pads.gauge_thickness_mm - energy_loss_mm(energy_j, true_wear_cm3_per_mj, SETTINGS)


def test_a_stop_of_80_t_from_100_kmh_costs_16_pads_five_micrometres() -> None:
    assert pytest.approx(30.9, abs=0.05) == STOP_MJ
    assert energy_loss_mm(STOP_MJ / 4 * 1e6, 0.1, SETTINGS) == pytest.approx(0.0048, abs=5e-5)


def test_thickness_is_what_was_gauged_less_what_energy_and_archard_say() -> None:
    pads = PadWear.new(SETTINGS).used(PadUse(energy_j=1e9, force_travel_nm=2e9, stops=100.0, distance_m=1e6))
    life = pad_life(pads, SETTINGS)
    assert life.by_energy.value_mm == pytest.approx(35.0 - 0.2 * 250.0 / 400.0 * 10.0)
    assert life.by_archard.value_mm == pytest.approx(35.0 - 7e-5 * 0.5e9 / (400.0 * 100.0))
    assert life.by_energy.low_mm < life.by_energy.value_mm < life.by_energy.high_mm


def test_energy_and_archard_agree_for_pads_of_nominal_friction() -> None:
    life = pad_life(PadWear.new(SETTINGS).used(PadUse(energy_j=0.35 * 4e9, force_travel_nm=4e9)), SETTINGS)
    assert life.by_energy.value_mm == pytest.approx(life.by_archard.value_mm)


def test_remaining_stops_and_kilometres_follow_from_recent_use() -> None:
    pads = PadWear.new(SETTINGS)
    stop = PadUse(energy_j=8e6, stops=1.0, distance_m=5000.0)
    for _ in range(100):
        pads = pads.used(stop)
    life = pad_life(pads, SETTINGS)
    assert life.remaining_stops == pytest.approx(life.remaining_mm / energy_loss_mm(8e6, 0.2, SETTINGS))
    assert life.remaining_km == pytest.approx(life.remaining_stops * 5.0)


def test_of_use_long_ago_the_forecast_forgets() -> None:
    pads = PadWear.new(SETTINGS)
    for energy_j in [20e6] * 300 + [5e6] * 300:
        pads = pads.used(PadUse(energy_j=energy_j, stops=1.0, distance_m=1000.0))
    life = pad_life(pads, SETTINGS)
    assert life.remaining_stops == pytest.approx(life.remaining_mm / energy_loss_mm(5e6, 0.2, SETTINGS), rel=0.02)


def test_without_use_nothing_is_forecast() -> None:
    life = pad_life(PadWear.new(SETTINGS), SETTINGS)
    assert life.remaining_stops is None
    assert life.remaining_km is None


@pytest.mark.parametrize("true_wear", [0.06, 0.2, 0.35, 0.9])
def test_two_gauge_readings_teach_the_specific_wear(true_wear: float) -> None:
    pads = PadWear.new(SETTINGS).gauged(SETTINGS, 0.0, 30.0).used(PadUse(energy_j=2e9, force_travel_nm=2e9 / 0.35))
    taught = pads.gauged(SETTINGS, 1.0, worn(pads, true_wear, 2e9))
    rate = taught.specific_wear_cm3_per_mj
    assert abs(rate.value - true_wear) < 2.0 * rate.std
    assert abs(rate.value - true_wear) < 0.25 * abs(0.2 - true_wear) + 1e-6  # most of what was wrong is put right
    assert rate.std < pads.specific_wear_cm3_per_mj.std
    assert taught.archard_mm3_per_nm.value == pytest.approx(0.35e-3 * rate.value, rel=0.1)


def test_readings_over_little_use_teach_little() -> None:
    pads = PadWear.new(SETTINGS).gauged(SETTINGS, 0.0, 30.0).used(PadUse(energy_j=1e6, force_travel_nm=3e6))
    rate = pads.gauged(SETTINGS, 1.0, 29.6).specific_wear_cm3_per_mj
    assert rate.value == pytest.approx(SETTINGS.specific_wear_cm3_per_mj, rel=0.01)


@pytest.mark.parametrize(("thickness_mm", "bound"), [(34.9, 0.05), (1.0, 1.0)])
def test_no_reading_teaches_what_no_pad_does(thickness_mm: float, bound: float) -> None:
    pads = PadWear.new(SETTINGS).gauged(SETTINGS, 0.0, 34.0, 0.01).used(PadUse(energy_j=1e9))
    assert pads.gauged(SETTINGS, 1.0, thickness_mm, 0.01).specific_wear_cm3_per_mj.value == bound


def test_a_gauge_reading_is_the_new_zero_point() -> None:
    pads = PadWear.new(SETTINGS).used(PadUse(energy_j=1e9, stops=10.0)).gauged(SETTINGS, 5.0, 20.0)
    assert pad_life(pads, SETTINGS).by_energy.value_mm == 20.0
    assert (pads.since_gauge, pads.since_fitted.stops, pads.gauged_time_s) == (PadUse(), 10.0, 5.0)


def test_new_pads_forget_the_old_ones_but_not_what_they_taught() -> None:
    old = PadWear.new(SETTINGS).used(PadUse(energy_j=2e9, stops=50.0)).gauged(SETTINGS, 1.0, 20.0, 0.05)
    new = old.renewed(SETTINGS, 2.0)
    assert pad_life(new, SETTINGS).by_energy.value_mm == SETTINGS.new_pad_thickness_mm
    assert new.since_fitted == PadUse()
    assert new.specific_wear_cm3_per_mj == old.specific_wear_cm3_per_mj != Rate(0.2, 0.1)


def test_the_interval_holds_the_truth_of_pads_within_the_fleet() -> None:
    for true_wear in (0.05, 0.15, 0.3, 0.39):
        pads = PadWear.new(SETTINGS).used(PadUse(energy_j=1e9))
        thickness = pad_life(pads, SETTINGS).by_energy
        assert thickness.low_mm <= worn(pads, true_wear, 1e9) <= thickness.high_mm


def test_no_pad_is_thicker_than_it_was_when_gauged() -> None:
    """However little is known of its wear; of what it was then 95 % lie within 1.96 deviations."""
    vague = WearSettings(specific_wear_std_cm3_per_mj=0.2)
    pads = PadWear.new(vague).gauged(vague, 1.0, 30.0, 0.5).used(PadUse(energy_j=3e9))
    assert pad_life(pads, vague).by_energy.high_mm == pytest.approx(30.0 + 1.96 * 0.5)


def test_survives_being_written_down() -> None:
    pads = PadWear.new(SETTINGS).used(PadUse(1e9, 2e9, 3.0, 4.0, 5.0)).gauged(SETTINGS, 1.0, 30.0)
    assert msgspec.json.decode(msgspec.json.encode(pads), type=PadWear) == pads
