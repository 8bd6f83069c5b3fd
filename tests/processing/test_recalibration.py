"""Once mass, forces or brake radius are configured otherwise, what the same pads rub is told otherwise, too."""

from collections.abc import Callable, Sequence

import pytest
from msgspec.structs import replace

from brake_monitor.estimation.estimate import Estimate
from brake_monitor.estimation.learned import Learned
from brake_monitor.frame import Frame
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.processing.remembered import Remembered
from brake_monitor.settings.config import Settings
from brake_monitor.settings.example_vehicles import example_settings
from drives import DRY, drive

PAUSE_S = 16.0  # between the two brakings
SCALED = 1.25
Change = Callable[[Settings, float], Settings]


def unweighed() -> Settings:
    """Of a wagon whose mass is what the configuration says."""
    settings = example_settings("wagon")
    return replace(settings, signals=replace(settings.signals, load_force=()))


def with_scale(settings: Settings, factor: float) -> Settings:
    forces = [
        replace(own, scale=own.scale * factor, offset=own.offset * factor) for own in settings.signals.pressing_force
    ]
    return replace(settings, signals=replace(settings.signals, pressing_force=tuple(forces)))


def with_mass(settings: Settings, factor: float) -> Settings:
    return replace(settings, vehicle=replace(settings.vehicle, mass_kg=settings.vehicle.mass_kg * factor))


def with_brake_radius(settings: Settings, factor: float) -> Settings:
    radii_m = tuple([radius_m * factor for radius_m in settings.vehicle.brake_radius_m])
    return replace(settings, vehicle=replace(settings.vehicle, brake_radius_m=radii_m))


def with_limit(settings: Settings, factor: float) -> Settings:
    rule = settings.alarms.friction_drift
    return replace(settings, alarms=replace(settings.alarms, friction_drift=replace(rule, limit=rule.limit * factor)))


def play(settings: Settings, frames: Sequence[Frame], remembered: Remembered | None = None) -> Pipeline:
    pipeline = Pipeline.from_settings(settings)
    if remembered is not None:
        pipeline.resume(remembered)
    for frame in frames:
        pipeline.step(frame)
    return pipeline


def after_change(settings: Settings, change: Change) -> tuple[Learned, Estimate]:
    """What one braking taught before `change` was undone, and what is told half a second after the restart."""
    frames = drive(DRY).frames
    pause_s = frames[0].time_s + PAUSE_S
    before = play(change(settings, SCALED), [frame for frame in frames if frame.time_s < pause_s]).remembered()
    assert before.learned is not None
    soon = [frame for frame in frames if pause_s <= frame.time_s < pause_s + 0.5]
    return before.learned, play(settings, soon, before).estimator.estimate()


@pytest.mark.parametrize("change", [with_scale, with_mass, with_brake_radius])
def test_pads_that_would_be_told_otherwise_are_not_known(change: Change) -> None:
    settings = unweighed()
    nominal, std = settings.estimator.friction_nominal, settings.estimator.friction_nominal_std
    learned, now = after_change(settings, change)
    for own, then in zip(now.wheelsets, learned.friction, strict=True):
        assert abs(then - nominal) > 0.03
        assert own.friction == pytest.approx(nominal, abs=0.003)
        assert own.friction_std == pytest.approx(std, rel=0.1)


@pytest.mark.parametrize(("settings", "change"), [(unweighed(), with_limit), (example_settings("wagon"), with_mass)])
def test_pads_that_would_be_told_alike_are_known(settings: Settings, change: Change) -> None:
    """The mass that the configuration says is none of a wagon that is weighed."""
    learned, now = after_change(settings, change)
    for own, then, then_std in zip(now.wheelsets, learned.friction, learned.friction_std, strict=True):
        assert own.friction == pytest.approx(then, abs=0.003)
        assert own.friction_std < 1.3 * then_std


def test_a_brake_application_says_by_what_its_friction_was_told() -> None:
    settings = unweighed()
    frames = drive(DRY).frames
    heavier = with_mass(settings, SCALED)
    told = {play(own, frames).brake_book.brakes.applications[-1].calibration for own in (settings, heavier)}
    assert told == {settings.calibration, heavier.calibration}
    assert len(told) == 2


def with_wheel_radius(settings: Settings, factor: float) -> Settings:
    first_m, *others_m = settings.vehicle.wheel_radius_m
    return replace(settings, vehicle=replace(settings.vehicle, wheel_radius_m=(first_m * factor, *others_m)))


def with_new_pads(settings: Settings, factor: float) -> Settings:
    thickness_mm = settings.wear.new_pad_thickness_mm * factor
    return replace(settings, wear=replace(settings.wear, new_pad_thickness_mm=thickness_mm))


def test_what_is_forgotten_as_the_configuration_was_changed_is_told() -> None:
    settings = unweighed()
    known = play(settings, drive(DRY).frames).remembered()
    changes = (with_scale, with_mass, with_brake_radius)
    told = {tuple(known.without_use(change(settings, SCALED))) for change in changes}
    ((pads,),) = told
    assert "friction of all pads is learned anew" in pads
    (wheel,) = known.without_use(with_wheel_radius(settings, 1.05))
    assert wheel == "wheelset 1: wheel_radius_m is 0.46725 and was 0.445; its radius is learned anew"
    (thickness,) = known.without_use(with_new_pads(settings, 1.1))
    assert thickness.startswith("[wear] was changed")
    for unchanged in (settings, with_limit(settings, SCALED)):
        assert not list(known.without_use(unchanged))
