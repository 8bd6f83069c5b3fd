"""Noise densities fitted to recordings: what is wrong is found, what is printed can be pasted and does what it says."""

import tomllib
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from math import inf, log10, nan
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec import structs
from msgspec.structs import asdict

from brake_monitor import cli
from brake_monitor.commands import tune
from brake_monitor.decoding.sample_block import SampleBlock
from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.errors import InputError
from brake_monitor.estimation.estimator import Estimator
from brake_monitor.estimation.model.tuning import FITTED_DENSITIES, PRESETS, WAGON, Tuning, resolve
from brake_monitor.frame_block import FrameBlock
from brake_monitor.samples import MEASURED, Quality, Quantity
from brake_monitor.settings.config import EstimatorSettings, Settings, TuningOverrides
from brake_monitor.settings.config_file import load_settings
from brake_monitor.settings.example_vehicles import example_config, example_settings
from brake_monitor.simulator.files import write_log, write_truth
from brake_monitor.simulator.scenarios import Profile, Scenario, steps
from brake_monitor.simulator.simulate import Recording as Run
from brake_monitor.simulator.simulate import run as simulate
from brake_monitor.tuner.fit import fit, fittable, fragment
from brake_monitor.tuner.recording import Recording, read_recording, read_truth
from brake_monitor.tuner.scores import Accuracy, Judge, Likelihood
from brake_monitor.tuner.search import REACH, Found, descend
from brake_monitor.tuner.workers import scoring

SHORT = Scenario(
    name="short",
    summary="a brake application that slides and one that does not",
    initial_speed_mps=22.0,
    duration_s=11.0,
    demand=steps((3.2, 0.9), (6.5, 0.0), (7.5, 0.5)),
    rail_over_time=Profile(((3.5, 0.3), (4.2, 0.06), (5.2, 0.06), (6.0, 0.3))),
)
WRONG = TuningOverrides(adhesion=100.0 * WAGON.adhesion, friction=100.0 * WAGON.friction)


# -- the search -------------------------------------------------------------------------------------------------------


def decades(point: tuple[float, ...]) -> list[float]:
    return [log10(value) for value in point]


def bowl(lowest: tuple[float, ...], coupling: float) -> Callable[[tuple[float, ...]], float]:
    """A quadratic in decades whose axes pull at each other."""

    def cost(point: tuple[float, ...]) -> float:
        away = [here - there for here, there in zip(decades(point), lowest, strict=True)]
        return sum(a * a for a in away) + coupling * sum(a * b for a, b in pairwise(away))

    return cost


places = st.lists(st.floats(-2.0, 2.0), min_size=1, max_size=4).map(tuple)


@settings(max_examples=50)
@given(places, st.floats(-0.5, 0.5))
def test_the_search_finds_the_bottom_and_never_rises(lowest: tuple[float, ...], coupling: float) -> None:
    found = list(descend((1.0,) * len(lowest), bowl(lowest, coupling), 1e-4, 400))
    costs = [step.cost for step in found]
    assert costs == sorted(costs, reverse=True)
    assert decades(found[-1].point) == pytest.approx(lowest, abs=0.15)
    assert [step.evaluations for step in found] == list(range(1, len(found) + 1))


@settings(max_examples=50)
@given(places, st.integers(1, 30))
def test_the_search_keeps_to_its_evaluations(lowest: tuple[float, ...], evaluations: int) -> None:
    asked = []

    def cost(point: tuple[float, ...]) -> float:
        asked.append(point)
        return bowl(lowest, 0.0)(point)

    *_, last = descend((1.0,) * len(lowest), cost, 0.0, evaluations)
    assert len(asked) == last.evaluations <= evaluations
    assert last.cost == min(map(bowl(lowest, 0.0), asked))


@settings(max_examples=50)
@given(places, st.floats(-1.9, 1.9))
def test_in_the_end_no_step_helps_any_more(lowest: tuple[float, ...], coupling: float) -> None:
    """Also where axes pull so hard at each other that one has to move again after the other."""
    cost = bowl(lowest[:2], coupling)
    *_, last = descend((1.0,) * len(lowest[:2]), cost, 1e-3, 10_000)
    for i, value in enumerate(last.point):
        for step in (0.5, -0.25, 0.125, -0.0625):
            moved = float(f"{min(max(value * 10.0**step, 1e-3), 1e3):.1e}")
            assert cost((*last.point[:i], moved, *last.point[i + 1 :])) >= last.cost - 1e-3


def test_steps_that_help_grow_up_to_a_decade() -> None:
    found = list(descend((1.0,), lambda point: -point[0], 0.0, 5))
    assert decades(tuple(step.point[0] for step in found)) == pytest.approx([0.0, 0.5, 1.5, 2.5, 3.0], abs=0.05)


@pytest.mark.parametrize(("elsewhere", "least_gain"), [(1.0, 0.0), (inf, 0.0), (nan, 0.0), (0.9, 0.2)])
def test_a_start_that_nothing_beats_is_returned_as_it_is(elsewhere: float, least_gain: float) -> None:
    start = (1.2345e-3, 7.0)
    *_, last = descend(start, lambda point: 1.0 if point == start else elsewhere, least_gain, 100)
    assert last == Found(start, 1.0, last.evaluations)
    assert last.evaluations < 20


def test_the_search_does_not_run_away() -> None:
    *_, last = descend((1.0,), lambda point: point[0], 0.0, 100)
    assert last.point == (10.0**-REACH,)


# -- the settings -----------------------------------------------------------------------------------------------------


def configuration(tmp_path: Path, estimator: str) -> Path:
    """The example wagon with another [estimator.tuning]."""
    example = Path(example_config("wagon"))
    text = example.read_text().replace('"wagon.dbc"', f'"{example.resolve().with_name("wagon.dbc")}"')
    path = tmp_path / "wagon.toml"
    path.write_text(f"{text}\n{estimator}\n")
    return path


def table(overrides: TuningOverrides) -> str:
    given = {name: value for name, value in asdict(overrides).items() if value is not None}
    return "\n".join(["[estimator.tuning]", *(f"{name} = {value!r}" for name, value in given.items())])


def test_what_is_given_takes_the_place_of_the_presets_value(tmp_path: Path) -> None:
    given = load_settings(configuration(tmp_path, "[estimator.tuning]\nomega = 1e-3\ndeceleration_onset_std = 0"))
    tuning, preset = asdict(resolve(given.estimator)), asdict(WAGON)
    assert tuning == preset | {"omega": 1e-3, "deceleration_onset_std": 0.0}
    assert resolve(EstimatorSettings(preset="train")) == PRESETS["train"]


def test_every_override_is_one_of_the_tuning() -> None:
    assert set(TuningOverrides.__struct_fields__) < set(Tuning.__struct_fields__)
    assert set(FITTED_DENSITIES) < set(TuningOverrides.__struct_fields__)


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        ("omegga = 1.0", 'estimator.tuning.omegga: unknown key, did you mean "omega"?'),
        ("speed = -1e-9", "estimator.tuning.speed: expected a number not less than 0, got -1e-09"),
        ('speed = "low"', 'estimator.tuning.speed: expected a number not less than 0, got "low"'),
        ("literal = true", "estimator.tuning.literal: unknown key"),
    ],
)
def test_a_wrong_override_is_named(tmp_path: Path, line: str, sentence: str) -> None:
    path = configuration(tmp_path, f"[estimator.tuning]\n{line}")
    with pytest.raises(InputError) as caught:
        load_settings(path)
    number = path.read_text().splitlines().index(line) + 1
    assert str(caught.value).startswith(f"{path}:{number}: {sentence}")


def test_densities_that_are_off_or_not_to_be_told_apart_are_left_alone() -> None:
    assert fittable(WAGON, 2) == list(FITTED_DENSITIES)
    assert fittable(WAGON, 1) == [name for name in FITTED_DENSITIES if not name.endswith("_own")]
    assert fittable(PRESETS["rig"], 1) == ["omega", "speed", "friction", "adhesion"]


def likelihood(tuning: Tuning) -> Likelihood:
    """The best where each of two densities is a hundredth of what it is with the preset `train`."""
    away = [log10(getattr(tuning, name) / getattr(PRESETS["train"], name)) + 2.0 for name in ("omega", "adhesion")]
    return Likelihood(1, -100.0 * sum(a * a for a in away), 0.0)


def test_a_fit_keeps_what_is_not_fitted_and_scores_nothing_twice() -> None:
    start = structs.replace(PRESETS["train"], speed=1.5e-4, friction=3.3e-5)
    scored: list[Tuning] = []

    def score(tuning: Tuning) -> Likelihood:
        scored.append(tuning)
        return likelihood(tuning)

    *_, last = fit(start, ["omega", "adhesion"], score, 200)
    assert structs.replace(last.tuning, omega=start.omega, adhesion=start.adhesion) == start
    assert (last.before, last.after) == (likelihood(start), likelihood(last.tuning))
    assert last.after.cost < 2.0
    assert len(scored) == len(set(scored))
    assert tomllib.loads(fragment(last, "train", ["a.log"])) == {
        "estimator": {
            "tuning": {
                "omega": last.tuning.omega,
                "adhesion": last.tuning.adhesion,
                "speed": 1.5e-4,
                "friction": 3.3e-5,
            }
        }
    }


def test_a_fit_does_not_leave_its_start_for_a_gain_that_means_nothing() -> None:
    train = PRESETS["train"]
    start = structs.replace(train, omega=0.011 * train.omega, adhesion=0.011 * train.adhesion)
    *_, last = fit(start, ["omega", "adhesion"], likelihood, 100)
    assert 0.0 < last.before.cost < Likelihood.least_gain
    assert last.tuning == start


# -- the scores -------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def run() -> Run:
    return simulate(SHORT, example_settings("wagon"), seed=5)


@pytest.fixture(scope="module")
def files(run: Run, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A log and its truth."""
    folder = tmp_path_factory.mktemp("recorded")
    log, truth = folder / "short.log", folder / "short.csv"
    write_log(log, run.frames)
    write_truth(truth, run)
    return log, truth


def recorded(run: Run, truth: Path | None = None) -> tuple[Judge, Recording]:
    decoder = SignalDecoder.from_settings(run.settings)
    truths = read_truth(truth, 2) if truth else None
    recording = read_recording(Path("a.log"), [FrameBlock.of(run.frames)], decoder, truths)
    return Judge(run.settings.vehicle, run.settings.estimator, decoder.channels), recording


def first(samples: SampleBlock, count: int) -> SampleBlock:
    names = ("frame", "time_s", "channel", "value", "quality")
    return replace(samples, **{name: getattr(samples, name)[:count].copy() for name in names})


def test_every_reading_counts_and_the_estimates_stay_the_same(run: Run) -> None:
    judge, recording = recorded(run)
    arguments = (judge.vehicle, judge.settings, judge.channels, WAGON)
    plain, foretelling = Estimator(*arguments), Estimator(*arguments, foretells=True)
    readings = 0
    for sample in recording.samples.samples:
        readings += sample.quantity in MEASURED and sample.quality is Quality.GOOD
        plain.take(sample)
        foretelling.take(sample)
    assert foretelling.core.foretold.readings == readings > 800
    assert foretelling.estimate() == plain.estimate()


def test_an_outlier_costs_the_same_however_sure_the_filter_was(run: Run) -> None:
    """Were it not so, the gate would reward the filter that rejects more."""
    judge, recording = recorded(run)
    one_by_one = enumerate(recording.samples.samples)
    last = next(i for i, s in one_by_one if i > 1000 and s.quantity is Quantity.AXLE_SPEED)
    before, wild = first(recording.samples, last), first(recording.samples, last + 1)
    wild.value[-1] += 15.0

    def loss(tuning: Tuning) -> float:
        without, after = (judge.score(Recording(some, None), tuning) for some in (before, wild))
        return after.cost - without.cost

    sure, unsure = WAGON, resolve(EstimatorSettings(tuning=TuningOverrides(omega=2e-2)))
    assert loss(sure) == pytest.approx(loss(unsure), rel=0.02)
    assert loss(sure) > 10.0


@pytest.mark.parametrize("with_truth", [False, True])
def test_wrong_densities_score_worse(run: Run, files: tuple[Path, Path], with_truth: bool) -> None:
    judge, recording = recorded(run, files[1] if with_truth else None)
    good = judge.score(recording, WAGON)
    wrong = judge.score(recording, resolve(EstimatorSettings(tuning=WRONG)))
    assert isinstance(good, Accuracy if with_truth else Likelihood)
    assert wrong.cost > good.cost + 10.0 * good.least_gain


@pytest.mark.parametrize(("decades_off", "nats"), [((1, 0), 0.02), ((-1, 0), 0.02), ((2, 0), 0.08), ((1, -1), 0.04)])
def test_to_leave_the_preset_costs_so_many_nats_per_reading(
    run: Run, decades_off: tuple[int, int], nats: float
) -> None:
    judge, recording = recorded(run)
    judge = structs.replace(judge, settings=EstimatorSettings(preset="train"))
    preset, short = PRESETS["train"], Recording(first(recording.samples, 200), None)
    omega, adhesion = (10.0**number for number in decades_off)
    left = structs.replace(preset, omega=omega * preset.omega, adhesion=adhesion * preset.adhesion, friction_own=0.0)
    kept, score = judge.score(short, preset), judge.score(short, left)
    assert isinstance(kept, Likelihood)
    assert isinstance(score, Likelihood)
    assert kept.cost == -kept.nats
    assert score.nats != kept.nats
    assert score.cost + score.nats == pytest.approx(nats * score.readings)


def test_processes_give_the_sum_that_one_gives(run: Run) -> None:
    judge, recording = recorded(run)
    short = Recording(first(recording.samples, 300), None)
    tuning = WAGON
    with scoring(judge, [short, recording], jobs=1) as alone, scoring(judge, [short, recording], jobs=2) as together:
        assert alone(tuning) == together(tuning)
        assert alone(tuning).judged == sum(judge.score(some, tuning).judged for some in (short, recording))


# -- the command ------------------------------------------------------------------------------------------------------


def pasted(tmp_path: Path, fragment: str) -> Settings:
    return load_settings(configuration(tmp_path, fragment))


@pytest.mark.parametrize("with_truth", [False, True])
def test_what_was_wrong_is_found_and_can_be_pasted(
    run: Run, files: tuple[Path, Path], with_truth: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log, truth = files
    wrong = configuration(tmp_path, table(WRONG))
    options = ["--truth", str(truth)] if with_truth else []
    assert cli.main(["tune", "-c", str(wrong), str(log), "--evaluations", "24", *options]) == 0
    fragment = capsys.readouterr().out
    judge, recording = recorded(run, truth if with_truth else None)
    start, fitted = (resolve(some.estimator) for some in (load_settings(wrong), pasted(tmp_path, fragment)))
    before, after = judge.score(recording, start), judge.score(recording, fitted)
    assert after.cost < before.cost - 10.0 * before.least_gain
    for name, figure in after.told().items():
        assert f"# {name}: {before.told()[name]} -> {figure}\n" in fragment
    changed = [getattr(fitted, name) for name in FITTED_DENSITIES if getattr(fitted, name) != getattr(start, name)]
    assert changed == [float(f"{value:.1e}") for value in changed]


def test_one_evaluation_gives_back_the_start(
    files: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = configuration(tmp_path, table(WRONG))
    assert cli.main(["tune", "-c", str(config), str(files[0]), "--evaluations", "1"]) == 0
    fragment = capsys.readouterr().out
    assert "nothing better was found" in fragment
    assert tomllib.loads(fragment) == {
        "estimator": {"tuning": {"friction": WRONG.friction, "adhesion": WRONG.adhesion}}
    }


def test_each_recording_is_compared_with_its_own_truth(
    run: Run, files: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log, truth = tmp_path / "later.log", tmp_path / "later.csv"
    write_log(log, [frame._replace(time_s=frame.time_s + 1000.0) for frame in run.frames])
    header, *rows = files[1].read_text().splitlines()
    later = [f"{float(time_s) + 1000.0:.6f},{rest}" for time_s, _, rest in (row.partition(",") for row in rows)]
    truth.write_text("\n".join([header, *later]))
    pairs = [str(files[0]), str(log), "--truth", str(files[1]), "--truth", str(truth)]
    options = ["--evaluations", "1", "--jobs", "1"]
    assert cli.main(["tune", "-c", str(example_config("wagon")), *pairs, *options]) == 0
    assert "adhesion RMSE" in capsys.readouterr().out


def test_what_is_printed_goes_with_the_preset_of_the_configuration(
    files: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = configuration(tmp_path, "")
    config.write_text(config.read_text().replace('preset = "wagon"', 'preset = "train"'))
    assert cli.main(["tune", "-c", str(config), str(files[0]), "--evaluations", "1"]) == 0
    fragment = capsys.readouterr().out
    assert 'goes with preset = "train"' in fragment
    assert tomllib.loads(fragment) == {"estimator": {"tuning": {}}}


def test_ctrl_c_ends_with_130(
    files: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Judge, "score", interrupted)
    assert cli.main(["tune", "-c", str(example_config("wagon")), str(files[0])]) == 130
    assert capsys.readouterr().out == ""


def refused(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    assert cli.main(["tune", "-c", str(example_config("wagon")), *arguments]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.count("\n") == 1
    return said.err.removeprefix("brake-monitor: ").rstrip("\n")


HEADER = "time_s,adhesion,friction_1,friction_2\n"


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (None, "{}: cannot be read: No such file"),
        (b"", '{}: expected a truth as CSV with a column "time_s", there is none'),
        (b"(1700000000.0) can0 123#00\n", '{}: expected a truth as CSV with a column "time_s", there is none'),
        (bytes(range(256)), "{}: expected a truth as CSV, this is not text"),
        (b"time_s,adhesion,friction_1\n", '{}: expected a truth as CSV with a column "friction_2"'),
        (HEADER.encode(), "{}: expected rows of numbers, there are none"),
        ((HEADER + "1,0.1,0.3,0.3\n2,0.1,x,0.3\n").encode(), "{}:3: friction_1: expected a number"),
        ((HEADER + "1,0.1\n").encode(), "{}:2: friction_1: expected a number"),
        ((HEADER + "1,0.1,0.3,0.3\n2,0,1,0.3,0.3\n").encode(), "{}:3: expected 4 cells, as the header has, got 5; is"),
        ((HEADER.strip() + ",friction_9\n").encode(), '{}: column "friction_9": the vehicle has 2 wheelsets'),
        ((HEADER + "1,nan,0.3,0.3\n").encode(), "{}:2: adhesion: expected a finite number"),
        ((HEADER + "2,0.1,0.3,0.3\n1,0.1,0.3,0.3\n").encode(), "{}:3: time_s: expected a later time than in"),
        ((HEADER + "2,0.1,0.3,0.3\n2,0.1,0.3,0.3\n").encode(), "{}:3: time_s: expected a later time than in"),
        ((HEADER + "1,0.1,0.3,0.3\n2,0.1,0.3,0.3\n").encode(), "{}: has no time in common with "),
        ((HEADER + "4e9,0.1,0.3,0.3\n5e9,0.1,0.3,0.3\n").encode(), "{}: has no time in common with "),
        (b"time_s,adhesion\n1700000000.0,0.1\n1700000001.0,0.1\n", "{}: nothing to judge within the truth's time"),
    ],
)  # fmt: skip
def test_a_wrong_truth_is_named(
    files: tuple[Path, Path],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    content: bytes | None,
    sentence: str,
) -> None:
    truth = tmp_path / "truth.csv"
    if content is not None:
        truth.write_bytes(content)
    assert refused([str(files[0]), "--truth", str(truth)], capsys).startswith(sentence.format(truth))


def test_a_truth_may_end_with_an_empty_line(tmp_path: Path) -> None:
    truth = tmp_path / "truth.csv"
    truth.write_text(HEADER + "1,0.1,0.3,0.3\n2,0.2,0.3,0.3\n\n")
    assert read_truth(truth, 2).adhesion.tolist() == [0.1, 0.2]


def test_a_device_without_end_is_no_truth() -> None:
    with pytest.raises(InputError, match=r"^/dev/zero:1: expected a truth as CSV, this line has more"):
        read_truth(Path("/dev/zero"), 2)


def test_other_wrong_input_is_named(
    files: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log, truth = map(str, files)
    assert refused([log, log], capsys) == f"{log}: this recording is given 2 times"
    strange = tmp_path / "strange.log"
    strange.write_text("(1700000000.000000) can0 7FF#00\n")
    assert refused([log, str(strange), "--truth", truth], capsys) == "--truth: expected one for each of 2 logs, got 1"
    assert refused([str(strange)], capsys).startswith(f"{strange}: no axle_speed is in this recording")
    unbraked = tmp_path / "unbraked.log"
    unbraked.write_text("".join(line for line in files[0].read_text().splitlines(keepends=True) if " 120#" not in line))
    assert refused([str(unbraked)], capsys).startswith(f"{unbraked}: no pressing_force is in this recording")
    nothing = configuration(tmp_path, table(TuningOverrides(**dict.fromkeys(FITTED_DENSITIES, 0.0))))
    with pytest.raises(InputError, match="every density is 0"):
        tune.run(cli.build_parser("tune").parse_args(["tune", "-c", str(nothing), log]))


def test_columns_of_a_truth_stand_in_any_order_among_others(tmp_path: Path) -> None:
    path = tmp_path / "truth.csv"
    path.write_text("friction_2,more,time_s,adhesion,friction_1\n0.32,x,7.0,0.1,0.31\n")
    truth = read_truth(path, 2)
    assert (truth.time_s.tolist(), truth.adhesion.tolist(), truth.friction.tolist()) == ([7.0], [0.1], [[0.31, 0.32]])


def test_a_truth_without_friction_judges_the_adhesion_alone(run: Run, tmp_path: Path) -> None:
    truth = tmp_path / "adhesion.csv"
    place = run.truth_header().index("adhesion")
    rows = "".join(f"{row[0]:.6f},{row[place]:.6f}\n" for row in run.truth())
    truth.write_text("time_s,adhesion\n" + rows, encoding="utf-8-sig")  # as spreadsheets write it
    judge, recording = recorded(run, truth)
    score = judge.score(recording, WAGON)
    assert isinstance(score, Accuracy)
    assert score.friction.count == 0
    assert score.adhesion.count > 80
    assert set(score.told()) == {"adhesion RMSE", "adhesion inside 95 % interval"}
