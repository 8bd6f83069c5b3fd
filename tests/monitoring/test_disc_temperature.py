"""The discs' heat: one lump, against what is known of it."""

import pytest

from brake_monitor.monitoring.brake_units.disc_temperature import Cooling
from brake_monitor.settings.wear_settings import WearSettings

INSULATED = WearSettings(disc_cooling_wpk=1e-9, disc_cooling_per_speed_wpk=0.0, discs_per_wheelset=1)
COOLED = WearSettings()


def disc_temperature_c(
    before_c: float, power_w: float, speed_mps: float, step_s: float, settings: WearSettings
) -> float:
    return Cooling(speed_mps, step_s, settings).temperature_c(before_c, power_w)


def test_a_disc_of_100_kg_that_takes_an_eighth_of_a_stop_warms_by_77_k() -> None:
    energy_j = 0.5 * 80e3 * (100.0 / 3.6) ** 2 / 8.0
    assert disc_temperature_c(15.0, energy_j / 30.0, 14.0, 30.0, INSULATED) - 15.0 == pytest.approx(77.0, abs=0.5)


def test_the_length_of_the_steps_does_not_matter() -> None:
    in_steps_c = 15.0
    for _ in range(600):
        in_steps_c = disc_temperature_c(in_steps_c, 60e3, 20.0, 0.1, COOLED)
    assert in_steps_c == pytest.approx(disc_temperature_c(15.0, 60e3, 20.0, 60.0, COOLED))


def test_cools_faster_in_the_wind_and_never_below_ambient() -> None:
    standing, running = (disc_temperature_c(300.0, 0.0, speed_mps, 600.0, COOLED) for speed_mps in (0.0, 30.0))
    assert COOLED.ambient_c < running < standing < 300.0
    assert disc_temperature_c(300.0, 0.0, 0.0, 1e9, COOLED) == pytest.approx(COOLED.ambient_c)


def test_settles_where_cooling_takes_what_braking_gives() -> None:
    power_w, speed_mps = 40e3, 20.0
    cooling_wpk = COOLED.discs_per_wheelset * (COOLED.disc_cooling_wpk + COOLED.disc_cooling_per_speed_wpk * speed_mps)
    settled_c = disc_temperature_c(15.0, power_w, speed_mps, 1e6, COOLED)
    assert settled_c == pytest.approx(COOLED.ambient_c + power_w / cooling_wpk)
