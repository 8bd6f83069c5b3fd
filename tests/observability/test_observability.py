"""What can be told from [y, ẏ]: ranks by counting equations, the inverse (17), and the command that shows it."""

import re
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import cantools
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec import structs

from brake_monitor.cli import main
from brake_monitor.estimation.model.wagon import GRAVITY_MPS2, Inputs, Wagon
from brake_monitor.observability.analysis import (
    Observability,
    OperatingPoint,
    Prior,
    Sensors,
    Variant,
    analyse,
    scaled_map,
    stacked_map,
    unknowns,
    variants,
    worst,
)
from brake_monitor.observability.survey import Survey
from brake_monitor.settings.config import Settings
from brake_monitor.settings.example_vehicles import example_config, example_settings
from wagons import AXLES, derivative, make_wagon, of_each, told

WINDOW_S = 0.5
BRAKED = OperatingPoint(40_000.0, 20.0, 0.08)

# The lines of [y, ẏ] and of the unknowns, counted: directions without a trace with the brakes applied, of N wheelsets.
LOST: dict[str, Callable[[int], int]] = {
    "one mu_w, no d (the paper's)": lambda _: 0,
    "one mu_w, with d": lambda _: 1,
    "one mu_w, no d; coasting, then braking": lambda _: 0,
    "one mu_w, with d; coasting, then braking": lambda _: 0,
    "mu_w per wheelset, no d": lambda n: n - 1,
    "mu_w per wheelset, with d": lambda n: n,
    "mu_w per wheelset, with d; coasting, then braking": lambda n: n - 1,
    "mu_w per wheelset, no d; each released in turn": lambda _: 0,
    "mu_w per wheelset, with d; each released in turn": lambda _: 0,
}
CASES = [pytest.param(n, v, id=f"{n}: {v.name}") for n in AXLES for v in variants(n)]
COMPLETE = [pytest.param(n, v, id=f"{n}: {v.name}") for n in AXLES for v in variants(n) if LOST[v.name](n) == 0]


def make_sensors(n: int) -> Sensors:
    return Sensors(np.array([*[0.0225] * n, 0.02]), np.array([*[0.02] * n, 0.05]))


def look(wagon: Wagon, variant: Variant, point: OperatingPoint) -> Observability:
    return analyse(wagon, variant, point, make_sensors(wagon.layout.wheelset_count).map_std(WINDOW_S), Prior())


def named(n: int, name: str) -> Variant:
    return next(variant for variant in variants(n) if variant.name == name)


def database(settings: Settings) -> cantools.database.Database:
    return cantools.database.load_file(settings.can[0].dbc[0])


# -- rank -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("n", "variant"), CASES)
def test_the_rank_is_what_counting_equations_says(n: int, variant: Variant) -> None:
    seen = look(make_wagon(n), variant, BRAKED)
    assert seen.states == len(unknowns(variant))
    assert seen.states - seen.rank == LOST[variant.name](n)
    assert (seen.smallest_singular_value > 0.0) is (seen.rank == seen.states)


@pytest.mark.parametrize(("n", "variant"), CASES)
def test_without_pressing_force_exactly_the_frictions_are_lost(n: int, variant: Variant) -> None:
    """With more lost than frictions while braking, the rank is no lower at zero force: other directions are lost."""
    seen = look(make_wagon(n), variant, BRAKED._replace(pressing_force_n=0.0))
    assert seen.states - seen.rank == n
    assert seen.smallest_singular_value == 0.0
    assert seen.weakest == ("mu_b" if n == 1 else "all mu_b, each by itself")


@given(
    n=st.sampled_from((1, 2, 4)),
    force_n=st.floats(1.0, 200_000.0),
    speed_mps=st.floats(0.0, 80.0),
    adhesion=st.floats(0.0, 0.4),
)
def test_the_papers_states_are_seen_wherever_the_pads_press(
    n: int, force_n: float, speed_mps: float, adhesion: float
) -> None:
    """(17): all 6 states of (13), all 4 of the rig's (19)."""
    seen = look(make_wagon(n), variants(n)[0], OperatingPoint(force_n, speed_mps, adhesion))
    assert seen.rank == seen.states == 2 * n + 2
    assert seen.smallest_singular_value > 0.0


def test_one_released_pad_loses_its_own_friction_alone() -> None:
    seen = look(make_wagon(2), Variant("front only", True, False, ((1.0, 0.0),)), BRAKED)
    assert seen.rank == 5
    assert seen.weakest == "mu_b,2"


def test_braking_longer_at_the_same_force_does_not_reveal_d_and_another_force_does() -> None:
    wagon = make_wagon(1)
    same = look(wagon, Variant("same", True, True, ((1.0,), (1.0,))), BRAKED)
    other = look(wagon, Variant("other", True, True, ((1.0,), (0.5,))), BRAKED)
    assert same.states - same.rank == 1
    assert other.rank == other.states


@pytest.mark.parametrize("n", [2, 4])
def test_no_pressure_common_to_all_wheelsets_tells_their_frictions_apart(n: int) -> None:
    levels = tuple((level,) * n for level in (0.0, 0.25, 0.5, 0.75, 1.0, 1.2))
    seen = look(make_wagon(n), Variant("levels", False, True, levels), BRAKED)
    assert seen.states - seen.rank == n - 1
    assert seen.weakest.startswith("mu_b,1")
    assert " against mu_b," in seen.weakest


def test_coasting_and_releasing_all_but_one_wheelset_would_do_it() -> None:
    patterns = ((0.0, 0.0), (1.0, 1.0), (0.0, 1.0))
    seen = look(make_wagon(2), Variant("patterns", False, True, patterns), BRAKED)
    assert seen.rank == seen.states


# -- singular values --------------------------------------------------------------------------------------------------


def state_of(wagon: Wagon, variant: Variant, values: np.ndarray, instant: int) -> np.ndarray:
    """The model's state at one instant from the unknowns, in their order."""
    s = wagon.layout
    x = np.zeros(s.size)
    for column, value in zip(unknowns(variant), values, strict=True):
        match column.kind:
            case "omega" if column.instant == instant:
                x[s.omega.start + column.wheelset] = value
            case "v" if column.instant == instant:
                x[s.speed] = value
            case "mu_b":
                x[s.friction.start + column.wheelset] = value
            case "mu_w" if column.instant == instant and variant.one_adhesion:
                x[s.adhesion] = value
            case "mu_w" if column.instant == instant:
                x[s.adhesion.start + column.wheelset] = value
            case "d":
                x[s.deceleration] = value
    return x


def forward_map(wagon: Wagon, x: np.ndarray, u: Inputs) -> np.ndarray:
    """Return z = [y, ẏ] of (16), cut after the first derivative, shape (2N+2,)."""
    measured = wagon.layout.speed + 1
    return np.concatenate([x[:measured], derivative(wagon, x.tolist(), u)[:measured]])


def inverse_map(wagon: Wagon, z: np.ndarray, u: Inputs, deceleration_mps2: float = 0.0) -> np.ndarray:
    """Return x from z, shape (2N+2,): (17), (18) with one mu_w and d known.

    The printed (17), (18) corrected: m g instead of m g/2, brake-positive signs, wheel loads from the measured
    v̇ without gravity and d, and the known wheel torques kept. Raises ValueError where a pad does not press or a
    wheelset does not turn: mu_b,i has no trace in z there.
    """
    s, n = wagon.layout, wagon.layout.wheelset_count
    force_n = of_each(u, "pressing_force_n")
    if min(force_n) <= 0.0 or not all(of_each(u, "has_equation")):
        raise ValueError("the map has no inverse: a pad does not press, or a wheelset does not turn")
    speed, omega_dot, acceleration = float(z[n]), z[n + 1 : 2 * n + 1], float(z[2 * n + 1])
    pitching_mps2 = acceleration + deceleration_mps2 + GRAVITY_MPS2 * u.gradient
    creep_n = -(u.mass_kg * pitching_mps2 + wagon.vehicle.resistance_n(speed))  # (18), with its sign
    adhesion = creep_n / (u.mass_kg * GRAVITY_MPS2)
    load_n = np.array(wagon.wheel_load_n(pitching_mps2, u.mass_kg))
    inertia_kgm2, wheel_m, brake_m, *_ = np.array(wagon.wheelsets).T
    creep_torque = adhesion * load_n * wheel_m
    x = np.zeros(s.size)
    x[: n + 1] = z[: n + 1]
    torque_nm = of_each(u, "wheel_torque_nm")
    x[s.friction] = (creep_torque + torque_nm - inertia_kgm2 * omega_dot) / (brake_m * force_n)
    x[s.adhesion] = adhesion
    x[s.deceleration] = deceleration_mps2
    return x


def differentiated_map(wagon: Wagon, variant: Variant, point: OperatingPoint) -> np.ndarray:
    """The stacked map by central differences of `forward_map`."""
    start = []
    for column in unknowns(variant):
        part = variant.patterns[column.instant][column.wheelset]
        radius_m = wagon.wheelsets[column.wheelset].wheel_radius_m
        start.append(
            {
                "omega": point.speed_mps / radius_m,
                "v": point.speed_mps,
                "mu_b": 0.35,
                "mu_w": point.adhesion * part,
                "d": 0.0,
            }[column.kind]
        )

    def z(values: np.ndarray) -> np.ndarray:
        rows = []
        for instant, pattern in enumerate(variant.patterns):
            u = told(wagon.inputs(), pressing_force_n=[point.pressing_force_n * part for part in pattern])
            at_point = wagon.settled(state_of(wagon, variant, np.array(start), instant), u)
            rows.append(forward_map(wagon, state_of(wagon, variant, values, instant), at_point))
        return np.concatenate(rows)

    step = 1e-4
    return np.array([(z(start + step * e) - z(start - step * e)) / (2.0 * step) for e in np.eye(len(start))]).T


@pytest.mark.parametrize(("n", "variant"), CASES)
def test_singular_values_are_those_of_the_differentiated_map(n: int, variant: Variant) -> None:
    wagon = make_wagon(n)
    expected = np.linalg.svd(differentiated_map(wagon, variant, BRAKED), compute_uv=False)
    found = np.linalg.svd(stacked_map(wagon, variant, BRAKED), compute_uv=False)
    assert found == pytest.approx(expected, rel=1e-5, abs=1e-7)


@pytest.mark.parametrize(("n", "variant"), COMPLETE)
def test_the_harder_the_pads_press_the_better_the_weakest_direction_is_seen(n: int, variant: Variant) -> None:
    wagon = make_wagon(n)
    seen = [look(wagon, variant, BRAKED._replace(pressing_force_n=f)) for f in np.linspace(0.0, 90_000.0, 10)]
    assert (np.diff([one.smallest_singular_value for one in seen]) > 0.0).all()


@pytest.mark.parametrize(("n", "variant"), [case for case in COMPLETE if case.values[1].has_deceleration])
def test_d_has_its_price(n: int, variant: Variant) -> None:
    wagon = make_wagon(n)
    known = Variant("d known", variant.one_adhesion, False, variant.patterns)
    for force_n in (5_000.0, 40_000.0, 90_000.0):
        point = BRAKED._replace(pressing_force_n=force_n)
        with_d, without = (look(wagon, v, point).smallest_singular_value for v in (variant, known))
        assert 0.0 < with_d < without


def test_a_change_of_one_prior_sigma_shows_as_so_many_sigmas_of_the_sensors() -> None:
    """At low force the weakest direction is one friction: its torque on the wheelset against the noise of a slope.

    The rail balances it (the wheel equation is the sharper one), so what shows is its part of the deceleration.
    """
    wagon, force_n = make_wagon(1), 1000.0
    slope_std = make_sensors(1).map_std(WINDOW_S)[3]
    brake_force_n = 0.05 * force_n * 0.247 / 0.445
    seen = look(wagon, variants(1)[0], OperatingPoint(force_n, 20.0, 0.0))
    assert seen.weakest == "mu_b"
    assert seen.smallest_singular_value == pytest.approx(brake_force_n / 18_000.0 / slope_std, rel=0.01)


def test_sensor_noise_over_a_window_is_that_of_a_straight_line_fit() -> None:
    times_s = np.arange(11) * 0.05 - 0.25
    design = np.column_stack([np.ones(11), times_s])
    covariance = 0.02**2 * np.linalg.inv(design.T @ design)
    std = make_sensors(2).map_std(0.5)
    assert std.shape == (6,)
    assert std[[2, 5]] == pytest.approx(np.sqrt(covariance.diagonal()))
    assert np.isfinite(make_sensors(2).map_std(0.05)).all()  # two samples are enough
    with pytest.raises(ValueError, match="shorter"):
        make_sensors(2).map_std(0.04)


def test_better_sensors_and_a_vaguer_prior_count_in_proportion() -> None:
    wagon, variant = make_wagon(2), named(2, "mu_w per wheelset, with d")
    std = make_sensors(2).map_std(WINDOW_S)
    once = scaled_map(wagon, variant, BRAKED, std, Prior())
    assert scaled_map(wagon, variant, BRAKED, std / 3.0, Prior()) == pytest.approx(3.0 * once)
    kinds = np.array([column.kind for column in unknowns(variant)])
    for name, of in {
        "friction": ["mu_b"],
        "adhesion": ["mu_w"],
        "deceleration": ["d"],
        "speed": ["v", "omega"],
    }.items():
        prior = replace(Prior(), **{f"{name}_std": 2.0 * getattr(Prior(), f"{name}_std")})
        vaguer = scaled_map(wagon, variant, BRAKED, std, prior)
        assert vaguer == pytest.approx(once * np.where(np.isin(kinds, of), 2.0, 1.0))


def test_a_wheels_speed_is_as_unknown_at_its_circumference_as_the_wagons() -> None:
    wagon, variant, std = make_wagon(2), variants(2)[0], make_sensors(2).map_std(WINDOW_S)
    scaled = scaled_map(wagon, variant, BRAKED, std, Prior(speed_std=0.5))
    of_wheel, of_wagon = (
        next(k for k, column in enumerate(unknowns(variant)) if column.kind == kind) for kind in ("omega", "v")
    )
    assert scaled[0, of_wheel] * std[0] * wagon.wheelsets[0].wheel_radius_m == pytest.approx(0.5)
    assert scaled[2, of_wagon] * std[2] == pytest.approx(0.5)


def test_the_worst_loses_most_and_of_those_that_lose_as_much_tells_least() -> None:
    lost, little, much = (Observability(4, *of, "mu_b") for of in ((3, 0.0), (4, 0.2), (4, 0.5)))
    assert worst([much, lost, little]) == lost
    assert worst([much, little]) == little


@pytest.mark.parametrize(
    ("name", "weakest"),
    [
        ("one mu_w, no d (the paper's)", "all mu_b with mu_w"),
        ("one mu_w, with d", "all mu_b with mu_w against d"),
        ("mu_w per wheelset, no d", "mu_b,1 with mu_w,1 against mu_b,2 with mu_w,2"),
        ("mu_w per wheelset, with d; each released in turn", "all mu_b with all mu_w against d"),
    ],
)
def test_the_weakest_direction_is_named(name: str, weakest: str) -> None:
    """What one brake does more another does less, or d makes up for: the wagon slows down just the same."""
    assert look(make_wagon(2), named(2, name), BRAKED._replace(pressing_force_n=100_000.0)).weakest == weakest


# -- the survey -------------------------------------------------------------------------------------------------------


def test_a_survey_takes_its_numbers_from_the_configuration_and_its_dbc() -> None:
    settings = example_settings("wagon")
    estimator = structs.replace(settings.estimator, friction_nominal_std=0.07, contact_force_n=1234.0)
    survey = Survey.of(structs.replace(settings, estimator=estimator), WINDOW_S)
    cycles_s = {message.name: message.cycle_time / 1e3 for message in database(settings).messages if message.cycle_time}
    mapped = [*settings.signals.axle_speed, settings.signals.speed]
    assert survey.prior == Prior(friction_std=0.07)
    of_wheel_radps = settings.signals.axle_speed[0].noise_std / 3.6 / settings.vehicle.wheel_radius_m[0]
    noise_std = [of_wheel_radps, of_wheel_radps, settings.signals.speed.noise_std]
    assert survey.sensors.noise_std == pytest.approx(noise_std, rel=0.02)  # their resolution adds a little
    assert survey.sensors.period_s.tolist() == [cycles_s[one.message] for one in mapped]
    assert survey.table_forces_n == [0.0, 1234.0, survey.full_force_n / 4.0, survey.full_force_n]


def test_a_full_application_asks_a_tenth_of_the_rail_of_every_wheelset_in_tens_of_kilonewtons() -> None:
    settings = example_settings("wagon")
    survey, vehicle = Survey.of(settings, WINDOW_S), settings.vehicle
    at_rail = settings.estimator.friction_nominal * vehicle.brake_radius_m[0] / vehicle.wheel_radius_m[0]
    enough_n = 0.1 * vehicle.mass_kg * GRAVITY_MPS2 / 2 / at_rail
    assert survey.full_force_n % 10_000.0 == 0.0
    assert 0.0 <= survey.full_force_n - enough_n < 10_000.0


def test_a_survey_looks_at_speeds_in_kilometres_an_hour() -> None:
    survey = Survey.of(example_settings("wagon"), WINDOW_S)
    point, std = OperatingPoint(40_000.0, 20.0, 0.1), survey.sensors.map_std(WINDOW_S)
    for variant in survey.variants:
        assert survey.at(variant, 40_000.0, 72.0, 0.1) == analyse(survey.wagon, variant, point, std, survey.prior)


# -- the inverse (17) -------------------------------------------------------------------------------------------------


@st.composite
def pressed(draw: st.DrawFn) -> tuple[Wagon, np.ndarray, Inputs]:
    """A wagon with one adhesion and every pad pressing."""
    wagon = make_wagon(draw(st.sampled_from((1, 2, 4))))
    n, s = wagon.layout.wheelset_count, wagon.layout

    def vector(low: float, high: float) -> np.ndarray:
        return np.array(draw(st.lists(st.floats(low, high), min_size=n, max_size=n)))

    x = np.zeros(s.size)
    x[s.omega] = vector(0.0, 180.0)
    x[s.speed] = draw(st.floats(0.0, 80.0))
    x[s.friction] = vector(0.05, 0.7)
    x[s.adhesion] = draw(st.floats(-0.2, 0.4))
    x[s.deceleration] = draw(st.floats(-1.0, 1.0))
    level = wagon.inputs()._replace(
        gradient=draw(st.floats(-0.03, 0.03)), mass_kg=wagon.vehicle.mass_kg * draw(st.floats(0.6, 1.5))
    )
    forces_n, torques_nm = vector(500.0, 90_000.0), vector(-5000.0, 5000.0)
    return wagon, x, told(level, pressing_force_n=forces_n, wheel_torque_nm=torques_nm)


@given(pressed())
def test_the_inverse_gives_back_the_state(situation: tuple[Wagon, np.ndarray, Inputs]) -> None:
    wagon, x, u = situation
    z = forward_map(wagon, x, wagon.settled(x, u))
    assert z.shape == (2 * wagon.layout.wheelset_count + 2,)
    assert inverse_map(wagon, z, u, x[wagon.layout.deceleration]) == pytest.approx(x, rel=1e-8, abs=1e-8)


@pytest.mark.parametrize("n", AXLES)
def test_the_inverse_reads_the_deceleration_with_g_and_not_half_of_it(n: int) -> None:
    """A wagon that slows with 0.981 m/s² beyond its resistances uses 0.1 of its weight, not 0.2."""
    wagon = make_wagon(n)
    u = told(wagon.inputs(), pressing_force_n=np.full(wagon.layout.wheelset_count, 40_000.0))
    z = np.zeros(2 * n + 2)
    z[-1] = -0.981 - wagon.vehicle.track_resistance_n / wagon.vehicle.mass_kg
    x, s = inverse_map(wagon, z, u), wagon.layout
    assert x[s.adhesion] == pytest.approx(0.1)
    radii = np.array([own.brake_radius_m / own.wheel_radius_m for own in wagon.wheelsets])
    brake_force_n = x[s.friction] * of_each(u, "pressing_force_n") * radii  # wheels at constant speed pass it on
    assert brake_force_n.sum() == pytest.approx(0.1 * wagon.vehicle.mass_kg * 9.81)


def test_there_is_no_inverse_where_a_pad_does_not_press_or_a_wheelset_is_locked() -> None:
    wagon = make_wagon(2)
    u = told(wagon.inputs(), pressing_force_n=[40_000.0, 0.0])
    with pytest.raises(ValueError, match="no inverse"):
        inverse_map(wagon, np.zeros(6), u)
    u = told(wagon.inputs(), pressing_force_n=[40_000.0, 40_000.0], has_equation=[1.0, 0.0])
    with pytest.raises(ValueError, match="no inverse"):
        inverse_map(wagon, np.zeros(6), u)


# -- the command ------------------------------------------------------------------------------------------------------

WAGON = str(example_config("wagon"))


@pytest.mark.parametrize(("name", "n"), [("rig", 1), ("wagon", 2), ("bogie", 4)])
def test_the_tables_fit_a_terminal_and_show_the_loss_at_zero_force(
    name: str, n: int, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["observability", "-c", str(example_config(name))]) == 0
    out = capsys.readouterr().out
    assert max(len(line) for line in out.splitlines()) <= 100
    for variant in variants(n):
        row = next(line for line in out.splitlines() if line.startswith(variant.name + " "))
        ranks, values = row[len(variant.name) :].split()[::2], row[len(variant.name) :].split()[1::2]
        states = len(unknowns(variant))
        assert ranks[0] == f"{states - n}/{states}"
        assert set(ranks[1:]) == {f"{states - LOST[variant.name](n)}/{states}"}
        assert values[0] == "0"
        assert all(re.fullmatch(r"0|<\.001|0\.\d{3}|[1-9]\.\d{2}|\d{2}\.\d|\d{3,5}", value) for value in values), values
    lost = "all mu_b, each by itself" if n > 1 else "mu_b"
    assert f"\nat 0 kN, whatever else is known, no trace is left of {lost}\n" in out
    grid = [line for line in out.splitlines() if " km/h, adhesion " in line]
    assert len(grid) == 9
    assert out.count("price of d") == (2 if n == 1 else 3)


def test_a_longer_look_tells_more(capsys: pytest.CaptureFixture[str]) -> None:
    seen = []
    for window in ("0.5", "2"):
        assert main(["observability", "-c", WAGON, "--window", window]) == 0
        row = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("one mu_w, no d (the"))
        seen.append(float(row.split()[-1]))
    assert 6.0 < seen[1] / seen[0] <= 8.0  # 4 times as long: 4^1.5, less the one sample that begins the window


def test_the_figure_is_written_whole_and_the_same_each_time(tmp_path: Path) -> None:
    for name in ("one.svg", "two.svg", "three.png"):
        assert main(["observability", "-c", WAGON, "-o", str(tmp_path / name)]) == 0
    assert ElementTree.parse(tmp_path / "one.svg").getroot().tag == "{http://www.w3.org/2000/svg}svg"
    assert (tmp_path / "one.svg").read_bytes() == (tmp_path / "two.svg").read_bytes()
    png = (tmp_path / "three.png").read_bytes()
    assert png.startswith(b"\x89PNG\r\n\x1a\n")
    assert png[-8:-4] == b"IEND"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one.svg", "three.png", "two.svg"]


def test_a_figure_that_cannot_be_written_is_the_works_failure(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "full.svg").symlink_to("/dev/full")
    assert main(["observability", "-c", WAGON, "-o", str(tmp_path / "full.svg")]) == 1
    assert "cannot be written" in capsys.readouterr().err
    assert main(["observability", "-c", WAGON, "-o", str(tmp_path / "missing" / "map.svg")]) == 2
    assert "there is no directory" in capsys.readouterr().err


def test_a_figure_without_the_extra_names_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert main(["observability", "-c", WAGON, "-o", str(tmp_path / "map.svg")]) == 2
    assert "needs the extra 'report': pip install '.[report]' in the checkout" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
    assert main(["observability", "-c", WAGON]) == 0


@pytest.mark.parametrize(
    "options", [["-o", "map.pdf"], ["--window", "0"], ["--window", "soon"], ["--window", "inf"], ["--window", "1e160"]]
)
def test_bad_options_are_refused(options: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["observability", "-c", WAGON, *options])
    assert ended.value.code == 2
    assert options[1] in capsys.readouterr().err


def test_a_window_without_two_samples_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["observability", "-c", WAGON, "--window", "0.03"]) == 2
    assert "--window 0.03: expected at least 0.05" in capsys.readouterr().err
