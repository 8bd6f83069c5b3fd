"""A restarted estimator goes on with what it had learned, and doubts it the more the longer the pause was."""

from math import inf, nan

import pytest
from msgspec.structs import replace

from brake_monitor.errors import InputError
from brake_monitor.estimation.learned import Learned
from brake_monitor.frame import Frame
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.settings.config import Settings
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.simulate import EPOCH_S
from drives import DRY, drive

CUT_S = 16.0  # between the two brakings
WORN = Modifiers(wheel_radius_factor=(0.97, 1.0))


@pytest.fixture(scope="module")
def settings() -> Settings:
    return example_settings("wagon")


def play(settings: Settings, frames: list[Frame], learned: Learned | None = None) -> Pipeline:
    pipeline = Pipeline.from_settings(settings)
    if learned is not None:
        pipeline.estimator.resume(learned)
    for frame in frames:
        pipeline.step(frame)
    return pipeline


def learn(settings: Settings) -> tuple[Learned, list[Frame]]:
    """What the first braking taught, and the frames after it."""
    frames = drive(DRY, WORN).frames
    end_s = frames[0].time_s + CUT_S
    learned = play(settings, [frame for frame in frames if frame.time_s < end_s]).estimator.learned()
    assert learned is not None
    return learned, [frame for frame in frames if frame.time_s >= end_s]


def test_before_any_measurement_nothing_is_learned(settings: Settings) -> None:
    assert play(settings, []).estimator.learned() is None


def test_radii_friction_and_deceleration_are_taken_up_again(settings: Settings) -> None:
    learned, rest = learn(settings)
    assert learned.wheel_radius_m[0] == pytest.approx(0.97 * settings.vehicle.wheel_radius_m[0], rel=0.005)
    soon = [frame for frame in rest if frame.time_s < rest[0].time_s + 0.3]
    again = play(settings, soon, learned).estimator.learned()
    assert again is not None
    assert again.wheel_radius_m == pytest.approx(learned.wheel_radius_m, rel=0.002)
    assert again.friction == pytest.approx(learned.friction, abs=0.003)
    assert max(again.friction_std) < 0.8 * settings.estimator.friction_nominal_std
    assert again.deceleration_mps2 == pytest.approx(learned.deceleration_mps2, abs=0.02)


def test_what_a_late_disk_brings_is_taken_up_while_no_brake_was_applied(settings: Settings) -> None:
    frames = drive(DRY).frames
    coasting = play(settings, [frame for frame in frames if frame.time_s < frames[0].time_s + 4.0]).estimator
    before = replace(play(settings, frames).estimator.learned(), time_s=coasting.time_s - 60.0, friction=(0.28, 0.29))
    coasting.resume(before)
    late = coasting.learned()
    assert late is not None
    assert late.friction == pytest.approx(before.friction, abs=1e-6)
    assert max(before.friction_std) < max(late.friction_std) < settings.estimator.friction_nominal_std
    braked = play(settings, frames).estimator
    own = braked.learned()
    assert own is not None
    braked.resume(before)
    assert braked.learned().friction == own.friction


@pytest.mark.parametrize("factor", [0.905, 1.03, 1.09], ids=["worn out", "less worn than configured", "renewed"])
def test_every_radius_that_can_be_learned_is_taken_up_again(settings: Settings, factor: float) -> None:
    changed = drive(DRY, Modifiers(wheel_radius_factor=(factor, 1.0)))
    learned = play(settings, changed.frames).estimator.learned()
    assert learned is not None
    true_m = factor * settings.vehicle.wheel_radius_m[0]
    assert learned.wheel_radius_m[0] == pytest.approx(true_m, rel=0.01)  # after five seconds of rolling
    again = Pipeline.from_settings(settings).estimator
    again.resume(learned)
    assert again.wheel_radius_m == learned.wheel_radius_m


def test_radii_are_worth_the_rolling_that_they_were_learned_in(settings: Settings) -> None:
    """Unless the wheels may be others, after a pause in which there was time for that."""
    frames = [frame for frame in drive(DRY, WORN).frames if frame.time_s < EPOCH_S + 4.5]  # it coasts
    before, after = ([f for f in frames if (f.time_s < EPOCH_S + 3.5) is is_early] for is_early in (True, False))
    learned, uninterrupted = play(settings, before).estimator.learned(), play(settings, frames).estimator.learned()
    assert learned is not None
    assert uninterrupted is not None

    def again(pause_s: float) -> Learned:
        found = play(settings, after, replace(learned, time_s=after[0].time_s - pause_s)).estimator.learned()
        assert found is not None
        return found

    soon, late = again(60.0), again(86400.0)
    assert soon.wheel_radius_m == pytest.approx(uninterrupted.wheel_radius_m, rel=1e-4)
    assert soon.wheel_rolled_s == pytest.approx(uninterrupted.wheel_rolled_s, rel=0.1)
    assert max(late.wheel_rolled_s or ()) < 2.0


@pytest.mark.parametrize("radius_m", [0.39, 0.41, 0.485])
def test_a_wheel_that_is_configured_anew_is_as_configured(settings: Settings, radius_m: float) -> None:
    """Its speed in km/h is converted with the new radius, and with the one learned before it would seem to slip."""
    learned, rest = learn(settings)
    changed = replace(settings, vehicle=replace(settings.vehicle, wheel_radius_m=(radius_m, 0.445)))
    soon = [frame for frame in rest if frame.time_s < rest[0].time_s + 0.9]
    estimator = play(changed, soon, learned).estimator
    now = estimator.estimate()
    assert estimator.wheel_radius_m[0] == pytest.approx(0.97 * radius_m, rel=0.015)
    assert estimator.wheel_radius_m[1] == pytest.approx(learned.wheel_radius_m[1], rel=0.002)
    assert max(abs(wheelset.slip) for wheelset in now.wheelsets) < 0.015
    assert now.wheelsets[0].friction == pytest.approx(learned.friction[0], abs=0.003)
    assert not now.saturated


def test_the_longer_the_pause_the_less_is_believed(settings: Settings) -> None:
    learned, rest = learn(settings)
    soon = [frame for frame in rest if frame.time_s < rest[0].time_s + 0.3]

    def doubt(pause_s: float) -> tuple[float, float]:
        again = play(settings, soon, replace(learned, time_s=rest[0].time_s - pause_s)).estimator.learned()
        assert again is not None
        return max(again.friction_std), again.deceleration_std_mps2

    (friction_short, d_short), (friction_long, d_long) = doubt(1.0), doubt(3600.0)
    assert friction_short < friction_long
    assert d_short < d_long
    assert doubt(-3600.0)[0] >= friction_long  # the clock was set back: no telling how long it was


IMPOSSIBLE = {
    "radius too small": {"wheel_radius_m": (0.39, 0.445)},
    "radius too large": {"wheel_radius_m": (0.445, 0.50)},
    "radius not a number": {"wheel_radius_m": (nan, 0.445)},
    "another wagon": {"friction": (0.3,)},
    "no friction": {"friction": (0.3, 0.0)},
    "friction not a number": {"friction": (0.3, nan)},
    "negative doubt": {"friction_std": (0.01, -0.01)},
    "infinite doubt": {"friction_std": (0.01, inf)},
    "a wall": {"deceleration_mps2": 5.0},
    "any wall": {"deceleration_std_mps2": 5.0},
    "radii of no rolling": {"wheel_rolled_s": (1.0, 0.0)},
    "radii of not a number": {"wheel_rolled_s": (1.0, nan)},
    "radii of another wagon": {"wheel_rolled_s": (1.0,)},
    "radii of another wagon, configured anew": {"wheel_rolled_s": (1.0,), "configured_radius_m": (0.46, 0.46)},
    "no mass": {"mass_kg": 0.0},
    "time not a number": {"time_s": nan},
    "a line of cliffs": {"deceleration_per_metre": 1e-3},
    "a line that is not a number": {"deceleration_per_metre": nan},
}


@pytest.mark.parametrize("changes", IMPOSSIBLE.values(), ids=IMPOSSIBLE)
def test_what_cannot_be_is_refused(settings: Settings, changes: dict[str, object]) -> None:
    good = Learned(1.7e9, settings.vehicle.wheel_radius_m, (0.3, 0.3), (0.01, 0.01), 0.0, 0.01)
    Pipeline.from_settings(settings).estimator.resume(good)
    with pytest.raises(InputError):
        Pipeline.from_settings(settings).estimator.resume(replace(good, **changes))


@pytest.mark.parametrize("known", [8e-6, None])
def test_how_lines_undulate_is_taken_up_again(settings: Settings, known: float | None) -> None:
    """A memory from before that was learned tells nothing of it."""
    told_before = Learned(1.7e9, settings.vehicle.wheel_radius_m, (0.3, 0.3), (0.01, 0.01), 0.0, 0.01)
    coasting = drive(DRY).frames[:500]
    memory = replace(told_before, deceleration_per_metre=known)
    first, found = [play(settings, coasting, told).estimator.learned() for told in (None, memory)]
    assert first is not None
    assert found is not None
    assert found.deceleration_per_metre == (known or first.deceleration_per_metre)


def test_what_a_train_teaches_as_it_stops_is_taken_up_again(settings: Settings) -> None:
    """Its coupler slows a wagon whose own brakes are cut out as a full braking does: d is that, and not a gradient."""
    good = Learned(1.7e9, settings.vehicle.wheel_radius_m, (0.3, 0.3), (0.01, 0.01), 0.9, 0.55)
    again = Pipeline.from_settings(settings).estimator
    again.resume(good)
    assert again.wheel_radius_m == good.wheel_radius_m


def test_many_restarts_leave_no_more_in_doubt_than_one_that_knows_nothing(settings: Settings) -> None:
    learned, rest = learn(settings)
    soon = [frame for frame in rest if frame.time_s < rest[0].time_s + 0.3]
    learned = replace(learned, friction=(0.29, 0.29), friction_std=(0.015, 0.015))
    for _ in range(24):
        again = play(settings, soon, replace(learned, time_s=rest[0].time_s - 1800.0)).estimator.learned()
        assert again is not None
        learned = again
    assert max(learned.friction_std) <= settings.estimator.friction_nominal_std * 1.001
    assert learned.friction == pytest.approx((0.29, 0.29), abs=0.005)


def test_the_mass_that_the_load_told_last_is_taken_up_until_it_is_told_again(settings: Settings) -> None:
    frames = drive(DRY, Modifiers(mass_factor=1.8)).frames
    weighed = play(settings, frames[:4000]).estimator
    learned = weighed.learned()
    assert learned is not None
    assert learned.mass_kg == pytest.approx(1.8 * settings.vehicle.mass_kg, rel=0.03)
    again = Pipeline.from_settings(settings).estimator
    again.resume(learned)
    assert again.estimate().mass_kg == learned.mass_kg
    light = play(settings, drive(DRY).frames[:4000], learned).estimator  # it was unloaded meanwhile
    assert light.estimate().mass_kg == pytest.approx(settings.vehicle.mass_kg, rel=0.05)
