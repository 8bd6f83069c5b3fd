"""`brake-monitor validate` as its user meets it, and the estimators that it compares."""

import csv
import json
import re
import sys
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from brake_monitor.cli import main
from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.estimation.model.wagon import Wagon
from brake_monitor.samples import Quantity
from brake_monitor.simulator.scenarios import Profile, Scenario, steps
from brake_monitor.simulator.simulate import NO_MODIFIERS
from brake_monitor.validation.cases import Case
from brake_monitor.validation.runs import Task, drive, estimate, tasks
from brake_monitor.validation.variants import PrintedWagon
from brake_monitor.validation.vehicles import PAPER_OMEGA_STD_RADPS, PAPER_SPEED_STD_MPS, campaign_settings
from wagons import derivative, jacobian, told

SHORT = Scenario(
    name="short",
    summary="one braking from 15 m/s on a dry rail",
    initial_speed_mps=15.0,
    duration_s=12.0,
    demand=steps((4.0, 0.6)),
    rail_over_time=Profile(((0.0, 0.45),)),
)


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The report of one case with one seed."""
    folder = tmp_path_factory.mktemp("validate") / "accuracy"
    only = "single/sanding/as_modelled/wagon"
    assert main(["validate", "-o", str(folder), "--seeds", "1", "--jobs", "1", "--only", only]) in (0, 1)
    return folder


def test_the_table_says_in_numbers_what_the_plant_shows(campaign: Path) -> None:
    (row,) = csv.DictReader((campaign / "accuracy.csv").read_text().splitlines())
    assert (row["vehicle"], row["wheelsets"], row["scenario"], row["runs"]) == ("single", "1", "sanding", "1")
    assert 1e-5 < float(row["adhesion_rmse"]) < 0.01
    assert float(row["adhesion_rmse"]) <= float(row["worst_error"])
    assert 0.0 <= float(row["adhesion_coverage"]) <= 1.0
    assert float(row["valid_share"]) > 0.8  # nothing is wrong with its sensors
    document = json.loads((campaign / "accuracy.json").read_text())
    assert document["seeds"] == 1
    assert document["results"][0]["adhesion_rmse"] == float(row["adhesion_rmse"])
    assert (row["verdict"] == "miss") == bool(row["misses"])


def test_every_column_of_the_table_is_told(campaign: Path) -> None:
    page = (Path(__file__).parents[2] / "docs" / "commands.md").read_text()
    section = page.partition("## What `validate` and")[2].partition("\n`validate-alarms")[0]
    told = [name for row in re.findall(r"^\| (`.*?) \|", section, re.MULTILINE) for name in re.findall(r"`(\w+)`", row)]
    (columns, *_) = csv.reader((campaign / "accuracy.csv").read_text().splitlines())
    assert sorted(told) == sorted(columns)


class Wanted(HTMLParser):
    """Collects what a browser would fetch, and whether tags close in order."""

    VOID = frozenset({"meta", "br", "link", "img"})

    def __init__(self) -> None:
        super().__init__()
        self.fetched: list[str] = []
        self.open: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        links = [value or "" for name, value in attrs if name in {"src", "href", "xlink:href", "data", "action"}]
        self.fetched += [link for link in links if not link.startswith(("#", "data:"))]
        assert tag != "script"
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_the_report_needs_nothing_but_itself(campaign: Path) -> None:
    page = (campaign / "report.html").read_text()
    parser = Wanted()
    parser.feed(page)
    assert parser.fetched == []
    assert parser.open == []
    assert not re.search(r"@import|url\((?!#)", page)
    assert page.count("<svg") == 2  # sanding over time, and adhesion over slip
    identifiers = re.findall(r'\bid="(p[0-9a-f]{10})"', page)
    assert len(identifiers) == len(set(identifiers)), "two figures share a clip path"


def test_figures_stand_alone_as_files_too(campaign: Path) -> None:
    assert sorted(path.name for path in (campaign / "figures").iterdir()) == ["sanding.svg", "slip.svg"]
    for path in (campaign / "figures").iterdir():
        assert path.read_text().startswith("<svg")
        assert 'xmlns="http://www.w3.org/2000/svg"' in path.read_text()


def test_a_case_that_does_not_exist_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["validate", "-o", str(tmp_path), "--only", "waggon/*"]) == 2
    assert "waggon/*" in capsys.readouterr().err


def test_without_matplotlib_the_extra_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert main(["validate", "-o", str(tmp_path / "never")]) == 2
    assert "drawing needs the extra 'report'" in capsys.readouterr().err
    assert not (tmp_path / "never").exists()


def test_printed_equations_double_the_adhesion() -> None:
    """Row 3 of (12) with g/2, on a whole wagon: the retardation is the same, so mu_w must be twice as large."""
    recording = drive(SHORT, "wagon", NO_MODIFIERS, seed=1)
    printed, ours = (estimate(recording, variant) for variant in ("printed", "without_d"))
    braking = (ours.time_s > 7.0) & (ours.truth.speed_mps > 5.0)
    assert braking.sum() > 50
    assert np.median(ours.adhesion[braking] / ours.truth.adhesion[braking]) == pytest.approx(1.0, abs=0.03)
    assert np.median(printed.adhesion[braking] / printed.truth.adhesion[braking]) == pytest.approx(2.0, abs=0.1)


def test_printed_model_and_its_jacobian_belong_together() -> None:
    settings = campaign_settings("wagon")
    printed = PrintedWagon.from_vehicle(settings.vehicle)
    u = told(printed.inputs(), pressing_force_n=[20_000.0, 20_000.0])
    s = printed.layout
    x = np.zeros(s.size)
    x[: s.deceleration] = [40.0, 40.0, 18.0, 0.35, 0.33, 0.05, 0.05]
    f, a = derivative(printed, x, u), jacobian(printed, x, u)
    for state in (s.speed, s.adhesion.start, s.deceleration):
        step = np.zeros(s.size)
        step[state] = 1e-6
        numeric = (derivative(printed, x + step, u) - derivative(printed, x - step, u)) / 2e-6
        assert a[s.speed, state] == pytest.approx(numeric[s.speed], rel=1e-6, abs=1e-9)
    assert f[s.omega] == pytest.approx(derivative(Wagon.from_vehicle(settings.vehicle), x, u)[s.omega])


def test_the_rig_hears_the_noise_that_its_own_covariance_states() -> None:
    settings = campaign_settings("laboratory")
    noise = {channel.quantity: channel.noise_std for channel in SignalDecoder.from_settings(settings).channels}
    assert noise[Quantity.AXLE_SPEED] == pytest.approx(PAPER_OMEGA_STD_RADPS, rel=0.01)
    assert noise[Quantity.SPEED] == pytest.approx(PAPER_SPEED_STD_MPS, rel=0.01)


@pytest.mark.parametrize(("vehicle", "wheelsets"), [("single", 1), ("wagon", 2), ("bogie", 4)])
def test_every_vehicle_of_the_campaign_has_the_sensors_that_the_targets_speak_of(vehicle: str, wheelsets: int) -> None:
    settings = campaign_settings(vehicle)
    channels = SignalDecoder.from_settings(settings).channels
    speeds = [c for c in channels if c.quantity is Quantity.AXLE_SPEED]
    radii_m = settings.vehicle.wheel_radius_m
    assert len(speeds) == wheelsets
    for channel, radius_m in zip(speeds, radii_m, strict=True):
        assert channel.noise_std * radius_m == pytest.approx(0.01, rel=0.01)
    (speed,) = [c for c in channels if c.quantity is Quantity.SPEED]
    assert speed.noise_std == pytest.approx(0.02, rel=0.01)
    assert not [c for c in channels if c.quantity is Quantity.LOAD_FORCE]


def test_who_is_told_the_rest_errs_less_and_never_asks_for_friction() -> None:
    recording = drive(SHORT, "wagon", NO_MODIFIERS, seed=2)
    ours, informed = (estimate(recording, variant) for variant in ("wagon", "informed"))
    pressed = informed.truth.pressing_force_n > 5000.0
    friction_error = informed.friction - informed.truth.friction
    assert np.abs(friction_error[pressed]).max() < 0.002  # told at each sample; pads warm up in between
    judged = ours.time_s > 3.0
    own, limit = (np.square(s.adhesion - s.truth.adhesion)[judged].mean() for s in (ours, informed))
    assert limit < own


def test_who_never_holds_friction_corrects_it_with_the_pads_off_the_disc_as_well() -> None:
    released = replace(SHORT, demand=steps((2.0, 0.6), (7.0, 0.0)))
    recording = drive(released, "wagon", NO_MODIFIERS, seed=2)
    for variant, moves in (("wagon", False), ("without_hold", True)):
        told = estimate(recording, variant)
        rolling = told.truth.pressing_force_n.max(axis=1) == 0.0
        assert bool(np.ptp(told.friction[rolling & (told.time_s > 9.0)], axis=0).max() > 0.0) is moves


def test_the_first_seed_of_what_is_to_be_drawn_brings_its_series_along() -> None:
    sanding, leaf = (Case("single", scenario, "as_modelled", "wagon") for scenario in ("sanding", "leaf"))
    for seed, drawn, comes in ((0, {sanding}, True), (0, {leaf}, False), (1, {sanding}, False)):
        (outcome,) = Task((sanding,), seed).judge(drawn)
        assert (outcome.series is not None) is comes


def test_the_same_run_gives_the_same_numbers() -> None:
    first, again = (estimate(drive(SHORT, "single", NO_MODIFIERS, seed=2), "wagon") for _ in range(2))
    assert np.array_equal(first.adhesion, again.adhesion)
    assert np.array_equal(first.truth.adhesion, again.truth.adhesion)


def test_frames_are_lost_only_where_they_should_be() -> None:
    whole, lossy = (Case("single", "leaf", name, "wagon") for name in ("as_modelled", "frame_loss"))
    (task,) = tasks([whole, lossy], seeds=1)
    series = task.series()
    assert len(series[lossy].time_s) / len(series[whole].time_s) == pytest.approx(0.8, abs=0.03)
    assert series[lossy].truth.speed_mps[0] == pytest.approx(series[whole].truth.speed_mps[0], rel=1e-3)
