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


@pytest.mark.parametrize("true_wear", [0.06, 0.2, 0.35])
def test_two_gauge_readings_teach_the_specific_wear(true_wear: float) -> None:
    pads = PadWear.new(SETTINGS).gauged(SETTINGS, 0.0, 30.0).used(PadUse(energy_j=2e9, force_travel_nm=2e9 / 0.35))
    taught = pads.gauged(SETTINGS, 1.0, worn(pads, true_wear, 2e9))
    rate = taught.specific_wear_cm3_per_mj
    assert abs(rate.value - true_wear) < 2.0 * rate.std
    assert abs(rate.value - true_wear) < 0.25 * abs(0.2 - true_wear) + 1e-6  # most of what was wrong is put right
    assert rate.std < pads.specific_wear_cm3_per_mj.std
    assert taught.archard_mm3_per_nm.value == pytest.approx(0.35e-3 * rate.value, rel=0.1)


def test_pads_that_wear_as_no_others_of_the_fleet_are_followed_and_stay_in_doubt() -> None:
    """Seven of its deviations from what was known of it: it may as well be one of the readings."""
    pads = PadWear.new(SETTINGS).gauged(SETTINGS, 0.0, 30.0).used(PadUse(energy_j=2e9, force_travel_nm=2e9 / 0.35))
    rate = pads.gauged(SETTINGS, 1.0, worn(pads, 0.9, 2e9)).specific_wear_cm3_per_mj
    assert abs(rate.value - 0.9) < 0.25 * (0.9 - 0.2)
    assert rate.std == SETTINGS.specific_wear_std_cm3_per_mj


def test_readings_over_little_use_teach_little() -> None:
    pads = PadWear.new(SETTINGS).gauged(SETTINGS, 0.0, 30.0).used(PadUse(energy_j=1e6, force_travel_nm=3e6))
    rate = pads.gauged(SETTINGS, 1.0, 29.6).specific_wear_cm3_per_mj
    assert rate.value == pytest.approx(SETTINGS.specific_wear_cm3_per_mj, rel=0.01)


@pytest.mark.parametrize("thickness_mm", [34.9, 1.0])
def test_no_reading_teaches_what_no_pad_does(thickness_mm: float) -> None:
    """It grew, or lost ten times what the worst pads do: the monitor was off, or one of the readings is wrong."""
    pads = PadWear.new(SETTINGS).gauged(SETTINGS, 0.0, 34.0, 0.01).used(PadUse(1e9, 1e9 / 0.35))
    taught = pads.gauged(SETTINGS, 1.0, thickness_mm, 0.01)
    assert taught.specific_wear_cm3_per_mj == pads.specific_wear_cm3_per_mj
    assert taught.archard_mm3_per_nm == pads.archard_mm3_per_nm
    assert taught.gauge_thickness_mm == thickness_mm


@pytest.mark.parametrize(("error_mm", "bound"), [(+0.5, 0.05), (-0.5, 1.0)])
def test_no_rate_is_learned_beyond_those_of_any_pads(error_mm: float, bound: float) -> None:
    """Where the gauge leaves it open whether they had one."""
    pads = PadWear.new(SETTINGS).gauged(SETTINGS, 0.0, 30.0, 0.2).used(PadUse(4e9))
    known = msgspec.structs.replace(pads, specific_wear_cm3_per_mj=Rate(bound, 0.1))
    reading_mm = worn(known, bound, 4e9) + error_mm
    assert known.gauged(SETTINGS, 1.0, reading_mm, 0.2).specific_wear_cm3_per_mj.value == bound


def test_pads_of_which_nothing_was_noted_teach_nothing_yet() -> None:
    """They may have been worn as the monitor came; those that were noted as new, or measured, do."""
    used = PadUse(2e9, 2e9 / 0.35)
    found = PadWear.new(SETTINGS).used(used)
    thickness_mm = worn(found, 0.35, 2e9)
    assert found.gauged(SETTINGS, 1.0, 12.0).specific_wear_cm3_per_mj == Rate(0.2, 0.1)
    fitted = PadWear.new(SETTINGS).renewed(SETTINGS, 0.0).used(used)
    assert fitted.gauged(SETTINGS, 1.0, thickness_mm).specific_wear_cm3_per_mj.value > 0.25


@pytest.mark.parametrize("wrong_mm", [-1.8, +1.8])
def test_a_reading_that_contradicts_what_was_learned_leaves_it_in_doubt(wrong_mm: float) -> None:
    """Pads of 0.3 cm³/MJ, thrice measured well; then wrongly, then well: the interval holds the truth all along."""
    true_mm, pads = 34.0, PadWear.new(SETTINGS).gauged(SETTINGS, 0.0, 34.0, 0.1)
    holds = []
    for k, error_mm in enumerate((0.05, -0.05, 0.05, wrong_mm, 0.0, 0.05, -0.05)):
        for _ in range(4):
            pads = pads.used(PadUse(4e8, 4e8 / 0.35, stops=10.0))
            true_mm -= energy_loss_mm(4e8, 0.3, SETTINGS)
            if error_mm != wrong_mm:
                thickness = pad_life(pads, SETTINGS).by_energy
                holds.append(thickness.low_mm <= true_mm <= thickness.high_mm)
        before = pads.specific_wear_cm3_per_mj
        pads = pads.gauged(SETTINGS, float(k), true_mm + error_mm, 0.1)
        if error_mm == wrong_mm:
            assert pads.specific_wear_cm3_per_mj.std > 2.0 * before.std
            pads = pads.gauged(SETTINGS, float(k), true_mm, 0.1)  # measured again: it was wrong
    assert all(holds)
    assert pads.specific_wear_cm3_per_mj.value == pytest.approx(0.3, abs=0.03)


@pytest.mark.parametrize("entry", ["measured", "new pads"])
def test_an_entry_that_is_taken_back_leaves_no_trace(entry: str) -> None:
    pads = PadWear.new(SETTINGS, 0.0).used(PadUse(2e9, 6e9, 50.0)).gauged(SETTINGS, 1.0, 30.0)
    before, after = PadUse(1e9, 3e9, 20.0, 4.0, 5e5), PadUse(3e8, 9e8, 7.0, 0.0, 1e5)
    pads = pads.used(before)
    wrong = pads.gauged(SETTINGS, 2.0, 21.0) if entry == "measured" else pads.renewed(SETTINGS, 2.0)
    back, never = wrong.used(after).taken_back(), pads.used(after)
    assert back == msgspec.structs.replace(never, before_entry=None)
    assert back.taken_back() == back  # one entry only is remembered


def test_a_gauge_reading_is_the_new_zero_point() -> None:
    pads = PadWear.new(SETTINGS).used(PadUse(energy_j=1e9, stops=10.0)).gauged(SETTINGS, 5.0, 20.0)
    assert pad_life(pads, SETTINGS).by_energy.value_mm == 20.0
    assert (pads.since_gauge, pads.since_fitted.stops, pads.gauged_time_s) == (PadUse(), 10.0, 5.0)


def test_new_pads_forget_the_old_ones_but_not_what_they_taught() -> None:
    old = PadWear.new(SETTINGS, 0.0).used(PadUse(energy_j=2e9, stops=50.0)).gauged(SETTINGS, 1.0, 28.0, 0.05)
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
