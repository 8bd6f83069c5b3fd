"""The smoother against the exact posterior of linear systems, and against the filter on a plant it does not know."""

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from msgspec.structs import replace

import motor_drives
from brake_monitor.arrays import Floats
from brake_monitor.cli import main
from brake_monitor.estimation.core import readout
from brake_monitor.estimation.estimate import Estimate
from brake_monitor.estimation.filter.tape import Reading, Step, Tape
from brake_monitor.estimation.kalman.ekf import Measured
from brake_monitor.estimation.model.wagon import GRAVITY_MPS2
from brake_monitor.frame import Frame
from brake_monitor.processing import smoother as smoothing
from brake_monitor.processing.estimate_table import line
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.processing.smoother import Future, Smoother
from brake_monitor.settings.config import OutputSettings, Settings
from brake_monitor.settings.example_vehicles import example_config, example_settings
from brake_monitor.simulator.simulate import EPOCH_S, Recording
from brake_monitor.simulator.simulate import run as simulate
from brake_monitor.validation.vehicles import campaign_settings
from drives import SLIDE as WSP_AT_WORK
from drives import Judged, drive
from faults import signal_changed

SLIDE = Path(__file__).parents[1] / "golden" / "slide.log.gz"
H = np.array([1.0, 0.5, 0.0])
STEPS = 12


# -- linear systems: the smoother must give the exact posterior ------------------------------------------------


class Linear(NamedTuple):
    """A linear system with a reading after each step: what the filter believed, the tape of it, and the posterior."""

    beliefs: list[tuple[Floats, Floats, int]]  # x, P and how many events came before
    events: list[Step | Reading]
    posterior: list[tuple[Floats, Floats]]


def linear_system(seed: int, singular: bool) -> Linear:
    """Three states, the first and half of the second measured. `singular`: one is known, another one never moves."""
    rng = np.random.default_rng(seed)
    x, covariance = np.zeros(3), np.diag([1.0, 2.0, 0.0 if singular else 0.5])
    # The whole trajectory as one Gaussian, conditioned on every reading at once.
    mean, joint = x, covariance
    beliefs, tape = [], Tape()
    readings = []
    for k in range(STEPS):
        change = 0.3 * rng.standard_normal((3, 3))
        if singular:
            change[2] = 0.0
        root = rng.standard_normal((3, 3)) * np.array([[0.3], [0.0 if singular else 0.2], [0.0 if singular else 0.1]])
        noise, variance = root @ root.T, 0.04
        f = np.eye(3) + change
        tape.step(Step(change, noise))
        last = joint[-3:]
        joint = np.block([[joint, last.T @ f.T], [f @ last, f @ last[:, -3:] @ f.T + noise]])
        mean = np.concatenate((mean, f @ mean[-3:]))
        x, covariance = f @ x, f @ covariance @ f.T + noise
        value = float(rng.normal(0.5, 1.0))
        readings.append((3 * (k + 1), value, variance))
        told = covariance @ H
        gain, residual = told / (H @ told + variance), value - H @ x
        tape.reading(Measured(0, 1, H[1]), residual, variance, gain * residual)
        x, covariance = x + gain * residual, covariance - np.outer(gain, told)
        beliefs.append((x, covariance, len(tape.events)))
    for place, value, variance in readings:
        h = np.zeros(len(mean))
        h[place : place + 3] = H
        gain = joint @ h / (h @ joint @ h + variance)
        mean, joint = mean + gain * (value - h @ mean), joint - np.outer(gain, joint @ h)
    blocks = [slice(3 * (k + 1), 3 * (k + 2)) for k in range(STEPS)]
    return Linear(beliefs, tape.events, [(mean[b], joint[b, b]) for b in blocks])


@pytest.mark.parametrize("singular", [False, True])
@pytest.mark.parametrize("seed", range(5))
def test_a_linear_system_gives_the_posterior_of_all_readings(seed: int, singular: bool) -> None:
    system = linear_system(seed, singular)
    future, end = Future(3), len(system.events)
    for (x, covariance, position), (mean, variance) in zip(
        reversed(system.beliefs), reversed(system.posterior), strict=True
    ):
        for event in reversed(system.events[position:end]):
            future.precede(event)
        end = position
        smoothed, smoothed_covariance = future.join(x, covariance)
        np.testing.assert_allclose(smoothed, mean, atol=1e-8)
        np.testing.assert_allclose(smoothed_covariance, variance, atol=1e-8)


def test_what_was_forgotten_tells_nothing_of_the_time_before() -> None:
    future = Future(2)
    future.precede(Reading(Measured(0), 3.0, 0.01, np.zeros(2)))
    future.precede(Reading(Measured(1), 5.0, 0.01, np.zeros(2)))
    future.precede(Step(np.diag([-1.0, 0.0]), np.diag([1.0, 0.0])))
    x, covariance = future.join(np.zeros(2), np.eye(2))
    assert x[0] == pytest.approx(0.0)
    assert covariance[0, 0] == pytest.approx(1.0)
    assert x[1] == pytest.approx(5.0 / 1.01)


def test_the_tape_leaves_out_what_is_not_finite() -> None:
    tape = Tape()
    tape.step(Step(np.full((2, 2), np.nan), np.eye(2)))
    tape.step(Step(np.eye(2), np.full((2, 2), np.inf)))
    tape.reading(Measured(0), np.inf, 1.0, np.zeros(2))
    tape.reading(Measured(0), 1.0, 1.0, np.array([0.0, np.nan]))
    assert tape.events == []


# -- the plant -------------------------------------------------------------------------------------------------


class Played(NamedTuple):
    """The filter's estimates of a recording, and the smoothed ones."""

    recording: Recording
    filtered: list[Estimate]
    smoothed: list[Estimate]

    def truth(self, name: str) -> Floats:
        """A column of the truth at the estimates' times."""
        table = np.array(list(self.recording.truth()))
        column = table[:, self.recording.truth_header().index(name)]
        return np.interp([e.time_s for e in self.filtered], table[:, 0], column)

    def judged(self) -> Floats:
        """Which estimates count: settled and not too slow."""
        times_s = np.array([e.time_s for e in self.filtered])
        return (times_s > EPOCH_S + 3.0) & (self.truth("speed_mps") > 2.0)


def play(settings: Settings, frames: list[Frame], *, smooth: bool = True) -> tuple[list[Estimate], list[Estimate]]:
    pipeline = Pipeline.from_settings(settings)
    smoother = Smoother(pipeline) if smooth else None
    filtered, smoothed = [], []
    for frame in frames:
        estimate = pipeline.step(frame).estimate
        if estimate is not None:
            filtered.append(estimate)
            smoothed += smoother.take(estimate) if smoother else []
    return filtered, smoothed + (smoother.finish() if smoother else [])


@cache
def played(scenario: str) -> Played:
    recording = simulate(scenario, example_settings("wagon"), seed=5)
    return Played(recording, *play(recording.settings, recording.frames))


def rmse(estimates: list[Estimate], truth: Floats, judged: Floats) -> float:
    error = np.array([e.adhesion for e in estimates]) - truth
    return float(np.sqrt(np.mean(error[judged] ** 2)))


def test_adhesion_is_better_than_the_filters_by_a_third() -> None:
    """Over both runs together, and in each by a quarter at least."""
    squares = {"filtered": 0.0, "smoothed": 0.0}
    for scenario in ("wsp", "leaf"):
        run = played(scenario)
        truth, judged = run.truth("adhesion"), run.judged()
        assert judged.sum() > 200
        filtered, smoothed = rmse(run.filtered, truth, judged), rmse(run.smoothed, truth, judged)
        assert smoothed <= 0.75 * filtered
        squares["filtered"] += filtered**2
        squares["smoothed"] += smoothed**2
    assert squares["smoothed"] <= 0.67**2 * squares["filtered"]


@pytest.mark.parametrize("scenario", ["wsp", "leaf"])
def test_two_sigma_hold_the_truth(scenario: str) -> None:
    run = played(scenario)
    judged = run.judged()
    error = np.array([e.adhesion for e in run.smoothed]) - run.truth("adhesion")
    std = np.array([e.adhesion_std for e in run.smoothed])
    assert np.mean(np.abs(error[judged]) <= 2.0 * std[judged]) >= 0.93
    assert np.median(std[judged]) < np.median([e.adhesion_std for e in run.filtered])
    for i in (1, 2):
        pressed = judged & (run.truth(f"pressing_force_{i}_n") > 5000.0)
        wheelsets = [e.wheelsets[i - 1] for e in run.smoothed]
        error = np.array([w.friction for w in wheelsets]) - run.truth(f"friction_{i}")
        std = np.array([w.friction_std for w in wheelsets])
        assert np.mean(np.abs(error[pressed]) <= 2.0 * std[pressed]) >= 0.93


@pytest.mark.parametrize("scenario", ["wsp", "leaf"])
def test_every_number_of_a_row_is_nearer_to_the_truth(scenario: str) -> None:
    run = played(scenario)
    judged = run.judged()

    def errors(name: str, value: Callable[[Estimate], float]) -> list[Floats]:
        return [(np.array([value(e) for e in told]) - run.truth(name))[judged] for told in (run.filtered, run.smoothed)]

    found = [errors("speed_mps", lambda e: e.speed_mps)]
    for i in (0, 1):
        found.append(errors(f"omega_{i + 1}_radps", lambda e, i=i: e.wheelsets[i].omega_radps))
        found.append(errors(f"slip_{i + 1}", lambda e, i=i: e.wheelsets[i].slip))
        adhesion = errors(f"adhesion_{i + 1}", lambda e, i=i: e.wheelsets[i].adhesion)
        found.append(adhesion)
        std = np.array([e.wheelsets[i].adhesion_std for e in run.smoothed])[judged]
        assert np.mean(np.abs(adhesion[1]) <= 2.0 * std) >= 0.93
        assert np.median(std) < np.median([e.wheelsets[i].adhesion_std for e in run.filtered])
    for filtered, smoothed in found:
        assert np.sqrt(np.mean(smoothed**2)) < 0.8 * np.sqrt(np.mean(filtered**2))
    level = [(e.deceleration_mps2, e.deceleration_std_mps2) for e in run.smoothed]  # with nothing that pulls
    assert np.mean([abs(value) <= 2.0 * std for value, std in level]) >= 0.93
    assert np.median([std for _, std in level]) < np.median([e.deceleration_std_mps2 for e in run.filtered])


def test_rows_are_the_filters_with_other_numbers() -> None:
    run = played("leaf")

    def untouched(estimate: Estimate) -> tuple[object, ...]:
        wheelsets = [(w.friction_status, w.pressing_force_n, w.wsp_active) for w in estimate.wheelsets]
        e = estimate
        return (e.time_s, e.status, e.reasons, e.saturated, e.nis, e.reset_count, wheelsets)

    assert [untouched(e) for e in run.smoothed] == [untouched(e) for e in run.filtered]
    assert all(e.speed_mps >= 0.0 and 0.02 <= w.friction <= 1.0 for e in run.smoothed for w in e.wheelsets)


def test_the_filter_does_not_notice_that_it_is_followed() -> None:
    run = played("leaf")
    frames = run.recording.frames[:6000]
    alone, _ = play(run.recording.settings, frames, smooth=False)
    assert [line(e) for e in alone] == [line(e) for e in run.filtered[: len(alone)]]


def test_windows_give_what_the_whole_recording_gives(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = played("leaf").smoothed  # shorter than a window and its look-ahead
    assert whole[-1].time_s - whole[0].time_s < smoothing.WINDOW_S + smoothing.LOOK_AHEAD_S
    monkeypatch.setattr(smoothing, "WINDOW_S", 10.0)
    monkeypatch.setattr(smoothing, "LOOK_AHEAD_S", 45.0)
    recording = played("leaf").recording
    pipeline = Pipeline.from_settings(recording.settings)
    smoother, given = Smoother(pipeline), []
    for frame in recording.frames:
        estimate = pipeline.step(frame).estimate
        if estimate is not None:
            given += smoother.take(estimate)
            oldest_s = given[-1].time_s if given else whole[0].time_s
            assert estimate.time_s - oldest_s < 10.0 + 45.0 + 0.2  # no more is kept
    given += smoother.finish()
    assert len(smoother._tape.events) < 100  # nor of what has happened
    assert [e.time_s for e in given] == [e.time_s for e in whole]
    for one, other in zip(given, whole, strict=True):
        assert one.adhesion == pytest.approx(other.adhesion, abs=0.2 * other.adhesion_std)


def test_a_gap_and_time_that_jumps_back_harm_nothing() -> None:
    run = played("leaf")
    frames = [f for f in run.recording.frames if f.time_s - EPOCH_S < 26.0 and not 14.0 < f.time_s - EPOCH_S < 16.0]
    again = [*frames, *(f for f in frames if f.time_s - EPOCH_S >= 16.0)]
    filtered, smoothed = play(run.recording.settings, again)
    assert [e.time_s for e in smoothed] == [e.time_s for e in filtered]
    assert smoothed[-1].reset_count == 2
    for estimate in smoothed:
        assert np.isfinite([estimate.adhesion, estimate.adhesion_std, estimate.deceleration_std_mps2]).all()
        assert abs(estimate.adhesion) < 0.1


def test_who_looks_back_has_seen_all_that_waited_for_slower_sensors_as_the_bus_fell_silent() -> None:
    recording = played("leaf").recording
    signals = recording.settings.signals
    late = replace(
        recording.settings,
        signals=replace(
            signals,
            speed=replace(signals.speed, delay_s=0.3),
            axle_speed=tuple(replace(one, timeout_s=2.0) for one in signals.axle_speed),
        ),
    )
    pipeline = Pipeline.from_settings(late)
    Smoother(pipeline)
    (shadow,) = pipeline.shadows
    last_s = EPOCH_S + 14.0
    for frame in recording.frames:
        if frame.time_s < last_s:
            pipeline.step(frame)
    assert pipeline.estimator.time_s < last_s - 0.2
    for k in range(1, 20):
        pipeline.step(Frame(last_s + 0.1 * k, "can0", 0x7FF, False, bytes(8)))
    assert shadow.time_s == pipeline.estimator.time_s > last_s - 0.1  # of the wheel speeds


def test_a_preset_with_states_that_have_no_variance_is_smoothed_too() -> None:
    settings = replace(campaign_settings("laboratory"), output=OutputSettings(rate_hz=50.0))
    recording = simulate("leaf", settings, seed=5)
    run = Played(recording, *play(settings, recording.frames))
    assert settings.estimator.preset == "rig"
    assert {e.deceleration_std_mps2 for e in run.smoothed} == {0.0}
    truth, judged = run.truth("adhesion"), run.judged()
    assert rmse(run.smoothed, truth, judged) <= rmse(run.filtered, truth, judged)
    # adhesion is nearly white to this preset, so the future tells little of it; friction is not
    pressed = judged & (run.truth("pressing_force_1_n") > 5000.0)
    friction_rmse = [
        np.sqrt(np.mean((np.array([e.wheelsets[0].friction for e in found]) - run.truth("friction_1"))[pressed] ** 2))
        for found in (run.smoothed, run.filtered)
    ]
    assert friction_rmse[0] < 0.5 * friction_rmse[1]


def test_what_one_motor_errs_by_is_part_of_the_deviation_looking_back_as_well(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(readout, "OWN_TORQUE_STD", much := 0.3)  # far more than all motors err by together
    drive = motor_drives.recording(motor_drives.BRAKINGS)
    frames = [frame for frame in drive.frames if frame.time_s - EPOCH_S < 12.0]  # motors brake from 8 s on
    filtered, smoothed = play(drive.settings, frames)
    braked = [e for e in filtered if e.time_s - EPOCH_S > 9.5]
    for estimate in smoothed[-len(braked) :]:
        for own in estimate.wheelsets[:2]:
            load_n = own.relative_load * estimate.mass_kg * GRAVITY_MPS2 / 4
            assert own.motor_force_n is not None
            assert own.adhesion_std > 0.99 * much * own.motor_force_n / load_n > 0.01


# -- the command -----------------------------------------------------------------------------------------------


def test_replay_writes_the_smoothed_rows(tmp_path: Path) -> None:
    common = ["replay", "-c", str(example_config("wagon")), str(SLIDE), "-o"]
    assert main([*common, str(tmp_path / "filter.csv")]) == 0
    assert main([*common, str(tmp_path / "smooth.csv"), "--smooth"]) == 0
    tables = [
        [line.split(",") for line in (tmp_path / name).read_text().splitlines()]
        for name in ("filter.csv", "smooth.csv")
    ]
    header = tables[0][0]
    assert header == tables[1][0]
    kept = [header.index(name) for name in ("time_s", "status", "saturated", "friction_1_status")]
    assert [[cells[i] for i in kept] for cells in tables[0]] == [[cells[i] for i in kept] for cells in tables[1]]
    adhesion = header.index("adhesion")
    assert [cells[adhesion] for cells in tables[0]] != [cells[adhesion] for cells in tables[1]]


def test_replay_refuses_to_smooth_a_table_that_nobody_wants(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["replay", "-c", str(example_config("wagon")), str(SLIDE), "--smooth"]) == 2
    assert "-o OUT.csv" in capsys.readouterr().err


def test_what_the_rules_disbelieve_the_smoother_does_not_believe_either() -> None:
    """A pressing force that reads 0 in a braking is told as false: friction is then not said to be known by it."""
    recording = drive(WSP_AT_WORK)
    frames = signal_changed("pressing force", lambda _, __: 0.0, 8.0, 13.5)(list(recording.frames))
    smoothed = Judged.of(recording, play(recording.settings, frames)[1])
    assert smoothed.friction_dishonest_s() < 0.5
