"""Pressures that are told more slowly than the slide protection works say nothing of friction while it does.

Its valves empty a brake within a tenth of a second. What is told as often shows the wheel doing something that the
force does not explain, again and again: taken at its word, it makes friction fall to nothing.
"""

from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from brake_monitor.estimation.estimate import Status
from brake_monitor.estimation.inputs.held_input import HeldInput
from brake_monitor.settings.config import OutputSettings, Preset
from brake_monitor.settings.config_file import load_settings
from brake_monitor.simulator.physics.coupler import GivenPull
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.simulate import run
from brake_monitor.validation.runs import estimate
from brake_monitor.validation.scores import judged, pressed
from coarse_bogie import coarse_bogie
from drives import play


@pytest.mark.parametrize(("preset", "train"), [("wagon", None), ("train", GivenPull)])
@pytest.mark.parametrize("pressures_ms", [50, 100])
def test_slides_leave_friction_alone(
    preset: Preset, train: type[GivenPull] | None, pressures_ms: int, tmp_path: Path
) -> None:
    settings = coarse_bogie(tmp_path, wheels_ms=50, pressures_ms=pressures_ms, preset=preset)
    settings = replace(settings, output=OutputSettings(rate_hz=0.0))
    series = estimate(run("wsp", settings, 1, Modifiers(train=train)), preset)
    adhesion_error = (series.adhesion - series.truth.adhesion)[judged(series)]
    friction_error = (series.friction - series.truth.friction)[pressed(series)]
    assert np.sqrt(np.mean(adhesion_error**2)) < 0.006
    assert np.sqrt(np.mean(friction_error**2)) < 0.03
    assert np.mean(np.abs(friction_error) < 1.96 * series.friction_std[pressed(series)]) > 0.9


@pytest.mark.parametrize(("period_ms", "status"), [(20, Status.VALID), (50, Status.HELD)])
def test_in_slides_friction_is_held_unless_pressures_are_told_as_quickly_as_valves_move(
    period_ms: int, status: Status, tmp_path: Path
) -> None:
    settings = coarse_bogie(tmp_path, wheels_ms=period_ms, pressures_ms=period_ms)
    told = [e for e in play(settings, list(run("wsp", settings, 1).frames)) if e.saturated and e.speed_mps > 4.0]
    sliding = [own for e in told for own in e.wheelsets if own.slip > 0.05 and own.pressing_force_n > 5e3]
    assert {own.friction_status for own in sliding} == {status}


def test_a_slip_that_a_coarse_vehicle_speed_is_unsure_of_is_no_slide(tmp_path: Path) -> None:
    """In a train v is known by its own readings alone: friction would be held for most of a braking on a dry rail."""
    settings = coarse_bogie(tmp_path, wheels_ms=50, pressures_ms=50, preset="train")
    (tmp_path / "coarse.toml").write_text((tmp_path / "coarse.toml").read_text().replace("0.02 }", "0.1 }"))
    settings = load_settings(tmp_path / "coarse.toml")
    recording = run("dry", settings, 1, Modifiers(train=GivenPull))
    told = [e for e in play(settings, list(recording.frames)) if e.speed_mps > 4.0]
    statuses = [e.wheelsets[0].friction_status for e in told if e.wheelsets[0].pressing_force_n > 5e3]
    assert len(statuses) > 100
    assert statuses.count(Status.HELD) < 0.05 * len(statuses)


def held(spacing_s: float) -> HeldInput:
    """One that has been told a steady force for two seconds."""
    force = HeldInput()
    for k in range(1, round(2.0 / spacing_s) + 1):
        force.sample(k * spacing_s, 40e3, 1.0)
    return force


@pytest.mark.parametrize(("spacing_s", "prompt"), [(0.01, True), (0.02, True), (0.05, False), (0.1, False)])
def test_what_comes_as_often_as_a_valve_moves_is_prompt(spacing_s: float, prompt: bool) -> None:
    assert held(spacing_s).is_prompt is prompt


def test_a_vented_cylinder_is_what_may_have_passed_unseen() -> None:
    """Against the impulse of F e^(-t/0.1 s), summed up; nothing while a valve would not have opened yet."""
    force, until_s = held(0.1), 2.0
    assert force.unseen_std_until(until_s + 0.03) == 0.0
    times_s = np.linspace(0.0, 0.07, 7001)
    missing_n = 40e3 * (1.0 - np.exp(-times_s / 0.1))
    assert force.unseen_std_until(until_s + 0.1) == pytest.approx(np.trapezoid(missing_n, times_s), rel=1e-3)


def test_an_emptied_brake_may_be_filled_again_unseen() -> None:
    force = held(0.1)
    force.sample(2.1, 0.0, 1.0)
    assert force.unseen_std_until(2.2) == pytest.approx(held(0.1).unseen_std_until(2.1), rel=0.1)
