"""A vehicle that is configured wrongly by a factor shows in the friction of its brakings; a sound one does not."""

import numpy as np
import pytest
from msgspec.structs import replace

from brake_monitor.inspection.first_hour import FirstHour
from brake_monitor.inspection.friction_size import remarks_on_friction
from brake_monitor.samples import Channel, Quantity
from brake_monitor.settings.config import Settings
from brake_monitor.settings.example_vehicles import example_settings
from first_hours import Floats, of_readings, speed_channel, wheel_channel

STEP_S, CYCLE_S = 0.05, 40.0
FORCE_N = 30e3  # of each of two brakes, from 10 to 20 s of each cycle
SETTINGS = example_settings("wagon")
MASS_KG = SETTINGS.vehicle.mass_kg


def force_channel(place: int) -> Channel:
    return Channel(Quantity.PRESSING_FORCE, place, "can0", "BCU", f"p_{place + 1}", 100.0, 0.0, 0.5)


def recorded(friction: float, cycles: int = 4, slip: float = 0.0, stuck: bool = False) -> FirstHour:
    """A wagon of 36 t with pads of this friction, which gets back to speed between its brakings."""
    vehicle = SETTINGS.vehicle
    times_s = np.arange(0.0, cycles * CYCLE_S, STEP_S)
    phase_s = times_s % CYCLE_S
    forces_n = FORCE_N * np.clip(np.minimum(phase_s - 10.0, 20.0 - phase_s), 0.0, 1.0)
    ratio = vehicle.brake_radius_m[0] / vehicle.wheel_radius_m[0]
    slowing_mps2 = 2.0 * friction * forces_n * ratio / (MASS_KG + sum(vehicle.turning_kg))
    lost_mps = np.cumsum(slowing_mps2) * STEP_S
    gained_mps = lost_mps[-1] / cycles * (times_s // CYCLE_S + np.clip((phase_s - 22.0) / 12.0, 0.0, 1.0))
    true_mps: Floats = 20.0 + gained_mps - lost_mps
    wheels_radps = true_mps / vehicle.wheel_radius_m[0] * np.where(forces_n > 0.0, 1.0 - slip, 1.0)
    speed_mps = np.full_like(true_mps, 20.0) if stuck else true_mps
    channels = [speed_channel(0.02), *(wheel_channel(i, 0.02) for i in (0, 1)), *(force_channel(i) for i in (0, 1))]
    return of_readings(channels, times_s, speed_mps, wheels_radps, wheels_radps, forces_n, forces_n)


def remarks(first_hour: FirstHour, settings: Settings = SETTINGS, *masses_kg: float) -> list[str]:
    return list(remarks_on_friction(first_hour, settings, masses_kg or (MASS_KG,)))


VEHICLE = SETTINGS.vehicle
HALF = replace(VEHICLE, brake_radius_m=tuple(0.5 * radius_m for radius_m in VEHICLE.brake_radius_m))


@pytest.mark.parametrize(
    ("settings", "masses_kg", "friction"),
    [
        (SETTINGS, (2.0 * MASS_KG,), "0.69"),
        (SETTINGS, (0.5 * MASS_KG, 0.6 * MASS_KG), "0.21"),
        (replace(SETTINGS, vehicle=HALF), (MASS_KG,), "0.70"),
    ],
)
def test_what_is_wrong_by_a_factor_is_remarked(settings: Settings, masses_kg: tuple[float, ...], friction: str) -> None:
    (remark,) = remarks(recorded(0.35), settings, *masses_kg)
    assert remark.startswith(f"over 4 brake applications friction comes out at about {friction}, and estimator.")


@pytest.mark.parametrize("friction", [0.25, 0.35, 0.50])
def test_pads_that_there_are_are_not(friction: float) -> None:
    assert not remarks(recorded(friction))


def test_a_load_that_changes_leaves_it_open() -> None:
    assert not remarks(recorded(0.35), SETTINGS, 0.5 * MASS_KG, MASS_KG)


@pytest.mark.parametrize("first_hour", [recorded(0.7, cycles=2), recorded(0.7, slip=0.2), recorded(0.7, stuck=True)])
def test_few_brakings_slides_and_a_speed_that_is_stuck_say_nothing(first_hour: FirstHour) -> None:
    assert remarks(recorded(0.7, cycles=3))
    assert not remarks(first_hour)


def test_where_others_brake_or_blocks_do_it_is_not_told() -> None:
    estimator = SETTINGS.estimator
    blocks = replace(estimator, tuning=replace(estimator.tuning, friction=1e-4))
    for others in (replace(estimator, preset="train"), blocks):
        assert not remarks(recorded(0.7), replace(SETTINGS, estimator=others))
    assert not remarks(recorded(0.7), replace(SETTINGS, signals=replace(SETTINGS.signals, wheel_torque=("none",))))
