"""The report of a recording: one file, of which every number is the pipeline's."""

import base64
import csv
import gzip
import json
import os
import re
import shutil
import zlib
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from brake_monitor.cli import main
from brake_monitor.dashboard.recent import WHEELSET_COLUMNS
from brake_monitor.estimation.estimate import Status
from brake_monitor.monitoring.brake_units.application_record import ApplicationRecord, WheelsetRecord
from brake_monitor.report import tables
from brake_monitor.report.curves import Curves, to_draw
from brake_monitor.report.page import STEPS, page
from brake_monitor.report.recording import Recording
from brake_monitor.report.summary import TELL_OF_SLIDES, summary
from brake_monitor.report.track_map import EARTH_RADIUS_M, TrackMap, drawing
from brake_monitor.report.words import described, duration, elapsed, number
from brake_monitor.samples import Quantity
from brake_monitor.settings.config_file import load_settings
from brake_monitor.settings.example_vehicles import example_config
from estimates import alarm, estimate, wheelset

GOLDEN = Path(__file__).parent.parent / "golden" / "slide.log.gz"
CONFIG = example_config("wagon")


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("report")
    assert main(["report", "-c", str(CONFIG), str(GOLDEN), "-o", str(folder / "slide.html")]) == 0
    assert main(["replay", "-c", str(CONFIG), str(GOLDEN), "-o", str(folder / "slide.csv")]) == 0
    return folder


def data_of(report: str) -> dict[str, Any]:
    found = re.search(r'<script type="application/json" id="packed">(.*?)</script>', report, re.DOTALL)
    assert found
    data: dict[str, Any] = json.loads(found[1])
    return data


def unpacked(column: dict[str, Any]) -> np.ndarray:
    plain = zlib.decompress(base64.b64decode(column["packed"]))
    if column["bits"] == 64:
        return np.frombuffer(plain, "<f8")
    whole = np.frombuffer(plain, "<u2")
    return np.where(whole == 65_535, np.nan, column["least"] + whole * column["step"])


def test_its_curves_are_what_replay_writes(written: Path) -> None:
    columns = data_of((written / "slide.html").read_text())["columns"]
    with (written / "slide.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    times_s = [float(row["time_s"]) for row in rows]
    assert unpacked(columns["time_s"]) == pytest.approx(np.array(times_s) - times_s[0], abs=1e-5)
    valid = np.array([row["status"] != "invalid" for row in rows])
    for name in ("speed_mps", "adhesion", "adhesion_std"):
        told = unpacked(columns[name])
        replayed = np.array([float(row[name]) for row in rows])
        assert np.isnan(told[~valid]).all()
        assert np.abs(told - replayed)[valid].max() <= 0.6 * columns[name]["step"] + 1e-6 * np.abs(replayed).max()
        assert columns[name]["step"] <= (replayed[valid].max() - replayed[valid].min()) / STEPS * 1.01
    for i in ("1", "2"):
        assert columns["wheelsets"][i].keys() == set(WHEELSET_COLUMNS)
        force = np.array([float(row[f"pressing_force_{i}_n"]) for row in rows])
        assert unpacked(columns["wheelsets"][i]["pressing_force_n"]) == pytest.approx(force, abs=1.0)
        held = np.array([row[f"friction_{i}_status"] == "held" for row in rows])
        assert (unpacked(columns["wheelsets"][i]["held"]) == held).all()


def test_what_the_rail_gave_is_told_in_words(written: Path) -> None:
    with (written / "slide.csv").open() as stream:
        rows = [row for row in csv.DictReader(stream) if row["saturated"] == "1" and float(row["speed_mps"]) > 1.39]
    given = sorted(float(row["adhesion"]) for row in rows)
    said = next(text for text in summary(played(GOLDEN)) if text.startswith("Where the wheels asked"))
    assert f"it gave {np.median(given):.3f} (median; very low), at least {given[0]:.3f}" in said


def test_what_no_alarm_calls_a_slide_tells_nothing_of_the_rail() -> None:
    """A vehicle speed that jumps as it is believed again makes slip, too."""
    recording = played(GOLDEN)
    recording._alarms = {name: one for name, one in recording._alarms.items() if one.kind not in TELL_OF_SLIDES}
    assert not [text for text in summary(recording) if "it gave" in text or "Wheelsets slid" in text]


def test_the_same_recording_gives_the_same_bytes(written: Path, tmp_path: Path) -> None:
    again = tmp_path / "again.html"
    assert main(["report", "-c", str(CONFIG), str(GOLDEN), "-o", str(again)]) == 0
    assert again.read_bytes() == (written / "slide.html").read_bytes()


def test_it_needs_nothing_else(written: Path) -> None:
    text = (written / "slide.html").read_text()
    markup = re.sub(r"<script.*?</script>", "", text, flags=re.DOTALL)
    assert not re.findall(r'(?:src|href)="(?!#)|url\(|@import', markup)
    assert "default-src 'none'" in text
    assert not re.findall(r"^(?:import|export) ", text, re.MULTILINE)
    assert "Permission is hereby granted" in text  # the licence of what it carries


def test_it_tells_alarms_stops_data_and_settings(written: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = (written / "slide.html").read_text()
    main(["replay", "-c", str(CONFIG), str(GOLDEN), "--alarms", str(written / "alarms.jsonl")])
    alarms = [json.loads(line) for line in (written / "alarms.jsonl").read_text().splitlines()]
    assert alarms
    assert all(one["message"].replace("'", "&#x27;") in text for one in alarms)
    assert text.count("data-from=") == len(alarms)
    for signal in ("GNSS.v_ground", "WSP.n_A", "BCU.p_B"):
        assert signal in text
    assert "friction_nominal&quot;: 0.35" in text  # in force, though nobody wrote it
    assert "An invented example" in text  # the configuration's own comment


def test_it_tells_every_brake_application(tmp_path: Path) -> None:
    log = tmp_path / "leaf.log"
    assert main(["simulate", "leaf", "-o", str(log)]) == 0
    recording = played(log)
    text = page(recording, log.name, "")
    (stop,) = recording.applications
    for value in (number(stop.start_speed_mps * 3.6, 1), number(stop.wheelsets[1].energy_j / 1e6, 2)):
        assert value in text
    begun_s = recording.curves.table()[0, 0]
    assert f'data-from="{stop.start_time_s - 3.0 - begun_s:.1f}"' in text
    assert "1 brake application, 1 of them to standstill" in text
    slid_m = stop.wheelsets[0].sliding_distance_m  # its only application: as much as in all
    assert slid_m > 1.0
    assert "slid on the rail, m" in (wear := tables.wear(recording))
    assert f"<td>{number(slid_m, 1)}</td>" in wear
    assert 'class="map"' in text
    assert text.count("<circle") == sum(one.kind == "low_adhesion" for one in recording.alarms) > 0


def played(log: Path, config: Path = CONFIG) -> Recording:
    from brake_monitor.bus.can_log import open_log  # noqa: PLC0415 - only here

    settings = load_settings(config)
    recording = Recording(settings)
    source = open_log(log, settings.can)
    recording.play(source.blocks(), lambda: source.remarks)
    return recording


def test_what_is_wrong_with_the_data_is_told(tmp_path: Path) -> None:
    lines = gzip.decompress(GOLDEN.read_bytes()).decode().splitlines()
    begun_s = float(lines[0][1:].split(")")[0])
    silent = next(matching.can_id for matching in played(GOLDEN).decoder.matchings if matching.message == "GNSS")
    kept = [
        line for line in lines
        if not (f" {silent:03X}#" in line and 3.0 < float(line[1:].split(")")[0]) - begun_s < 6.0)
    ]  # fmt: skip
    kept += [line.split()[0] + " can0 7AB#00" for line in kept[-50:]]
    log = tmp_path / "gap.log"
    log.write_text("\n".join(sorted(kept)) + "\n")
    recording = played(log)
    text = page(recording, log.name, "")
    assert "<code>0x7AB</code>" in text
    gaps = [line.longest_gap_s for line in recording.traffic.lines(recording.decoder)]
    assert max(gaps) == pytest.approx(3.0, abs=0.2)
    assert "was silent for 3.0 s" in " ".join(summary(recording))
    recording = played(GOLDEN)
    assert "the data are without fault" in " ".join(summary(recording))
    every, valid = sum(recording.statuses.values()), recording.statuses[Status.VALID]
    assert 0 < valid < every
    assert f"{number(100.0 * valid / every, 1)} % of {every} estimates are valid" in " ".join(summary(recording))
    counts = recording.decoder.counts
    counts.lost_frames, counts.error_frames, counts.short_frames, counts.out_of_range = 1, 1, 2, 3
    counts.unknown_multiplexer = 5
    counts.bad_counter, counts.not_available = 4, 1  # a sender that froze is on the bus all the time
    said = (
        "1 frame lost, by the counter in it; 1 error frame; 2 frames too short; "
        "5 frames on a multiplexer page that the DBC does not describe; 3 values out of range; "
        "4 values with a counter that did not advance; 1 value that its sender did not have."
    )
    assert said in " ".join(summary(recording))


def test_data_that_are_remarked_on_are_not_without_fault(tmp_path: Path) -> None:
    lines = gzip.decompress(GOLDEN.read_bytes()).decode().splitlines(keepends=True)
    log = tmp_path / "twice.log"
    log.write_text("".join(lines * 2))
    recording = played(log)
    assert any("time goes back once" in remark for remark in recording.remarks)
    assert " ".join(summary(recording)).endswith("valid; see the remarks on the data.")


@pytest.mark.parametrize(
    ("trouble", "said"),
    [
        ("frozen-speed", "GNSS.v_ground was frozen"),
        ("dead-wheel-speed", "WSP.n_A was contradicted"),
        ("pressure-0", "BCU.p_A was contradicted"),
        ("lost-speed", "GNSS.v_ground is there only from 0 to 30 s"),
    ],
)
def test_a_sensor_that_an_alarm_accuses_is_a_fault_of_the_data(trouble: str, said: str, tmp_path: Path) -> None:
    log = tmp_path / "trouble.log"
    assert main(["simulate", trouble, "-o", str(log)]) == 0
    recording = played(log)
    told = " ".join(summary(recording))
    assert recording.alarms
    assert said in told
    assert told.count(said.split(maxsplit=1)[0]) == 1
    assert "without fault" not in told


def test_where_nothing_is_known_nobody_says_that_the_wheels_never_slid(tmp_path: Path) -> None:
    """On slippery rail without a pressing force, and without a vehicle speed."""
    log = tmp_path / "wsp.log"
    assert main(["simulate", "wsp", "-o", str(log)]) == 0
    lines = log.read_text().splitlines()
    begun_s = float(lines[0][1:].split(")")[0])
    for message, said in (("BCU", "Wheelsets slid, as the alarms say"), ("GNSS", "of the rest nothing is known")):
        lost = next(matching.can_id for matching in played(GOLDEN).decoder.matchings if matching.message == message)
        kept = [
            line for line in lines
            if not (f" {lost:03X}#" in line and float(line[1:].split(")")[0]) - begun_s > 35.0)
        ]  # fmt: skip
        log.write_text("\n".join(kept) + "\n")
        assert said in " ".join(summary(played(log)))


def test_a_clock_that_was_set_back_leaves_a_length_and_a_beginning(tmp_path: Path) -> None:
    lines = gzip.decompress(GOLDEN.read_bytes()).decode().splitlines()
    log = tmp_path / "back.log"
    log.write_text("\n".join(lines[2000:] + lines[:2000]) + "\n")
    in_order, back = played(GOLDEN), played(log)
    assert next(summary(back)).partition(" of ")[0] == next(summary(in_order)).partition(" of ")[0]
    begins = re.search("Begins</dt><dd>.*?</dd>", page(in_order, "x.log", ""))
    assert begins is not None
    report = page(back, "x.log", "")
    assert begins[0] in report
    time_s = unpacked(data_of(report)["columns"]["time_s"])  # else nothing could be drawn over it
    assert (np.diff(time_s) >= 0.0).all()
    assert time_s[0] == 0.0


def test_markup_in_names_stays_text(tmp_path: Path) -> None:
    for name in ("wagon.toml", "wagon.dbc"):
        shutil.copy(CONFIG.with_name(name), tmp_path / name)
    config = tmp_path / "wagon.toml"
    config.write_text(config.read_text().replace('id = "wagon-8127"', 'id = "<script>alert(1)<_script>"'))
    text = page(played(GOLDEN, config), "<img onerror=alert(1)>.log", "# </script><script>alert(2)</script>")
    for hostile in ("<script>alert", "<img"):
        assert hostile not in text
    assert "&lt;script&gt;alert(1)" in text


def test_a_name_that_is_no_utf8_is_shown_as_far_as_it_can_be(tmp_path: Path) -> None:
    log = tmp_path / os.fsdecode(b"side \xff.log.gz")
    shutil.copy(GOLDEN, log)
    assert main(["report", "-c", str(CONFIG), str(log), "-o", str(tmp_path / "out.html")]) == 0
    assert "side ?.log.gz" in (tmp_path / "out.html").read_text()


def test_an_empty_recording_is_a_report_too(tmp_path: Path) -> None:
    log = tmp_path / "other.log"
    log.write_text("(1.0) can0 7AB#00\n(2.0) can0 7AB#00\n")
    assert main(["report", "-c", str(CONFIG), str(log), "-o", str(tmp_path / "other.html")]) == 1
    assert "Nothing could be estimated" in (tmp_path / "other.html").read_text()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["nowhere.log", "-o", "x.html"], "nowhere.log"),
        ([str(GOLDEN), "-o", "no/such/folder/x.html"], "no/such/folder"),
        ([str(GOLDEN), "-o", "x.html", "--figures", __file__], "expected a directory"),
    ],
)
def test_what_cannot_be_is_one_sentence(
    arguments: list[str], said: str, capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["report", "-c", str(CONFIG), *arguments]) in (1, 2)
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


@pytest.mark.parametrize("suffix", ["svg", "png"])
def test_every_figure_is_a_picture_of_its_own_as_well(suffix: str, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    command = ["report", "-c", str(CONFIG), str(GOLDEN), "-o", str(tmp_path / "r.html"), "--format", suffix]
    for folder in ("one", "two"):
        assert main([*command, "--figures", str(tmp_path / folder)]) == 0
    names = {path.name for path in (tmp_path / "one").iterdir()}
    wanted = ("adhesion", "speeds", "pressing_forces", "slip", "friction_1", "friction_2", "adhesion_over_slip", "map")
    assert names == {f"{name}.{suffix}" for name in wanted}
    magic = {"svg": b"<?xml", "png": b"\x89PNG"}[suffix]
    for name in names:
        content = (tmp_path / "one" / name).read_bytes()
        assert content.startswith(magic)
        assert content == (tmp_path / "two" / name).read_bytes()


def test_without_positions_there_is_no_map(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    nowhere = tmp_path / "nowhere.toml"
    lines = CONFIG.read_text().replace('dbc = ["', f'dbc = ["{CONFIG.parent}/').splitlines()
    nowhere.write_text("\n".join(line for line in lines if not line.startswith(("latitude", "longitude"))))
    assert (
        main(["report", "-c", str(nowhere), str(GOLDEN), "-o", str(tmp_path / "r.html"), "--figures", str(tmp_path)])
        == 0
    )
    assert (tmp_path / "adhesion_over_slip.svg").exists()
    assert not (tmp_path / "map.svg").exists()


@given(st.integers(3, 400), st.integers(10, 60), st.randoms(use_true_random=False))
def test_of_too_many_rows_every_peak_stays(rows: int, most: int, random: Any) -> None:
    values = np.array([[float(k), random.uniform(-1.0, 1.0), random.choice([np.nan, 1.0])] for k in range(rows)])
    thin = to_draw(values, most)
    assert len(thin) <= most
    assert (np.diff(thin[:, 0]) > 0).all()
    assert (thin[:, 1].min(), thin[:, 1].max()) == (values[:, 1].min(), values[:, 1].max())
    width = -(-rows // (most // 2)) if rows > most else 1
    for k, row in enumerate(values):  # wherever one looks, the picture reaches as far
        near = thin[np.abs(thin[:, 0] - k) <= width]
        assert near[:, 1].min() <= row[1] <= near[:, 1].max()


def test_over_days_what_stays_of_the_rows_is_no_row_of_gaps() -> None:
    """The page draws a gap where rows are three periods apart."""
    recording = Recording(load_settings(CONFIG))
    begin = estimate(time_s=0.0)
    recording.curves.take(begin, lambda *_: True)
    rows = np.repeat(recording.curves.table(), 100_000, axis=0)
    rows[:, 0] = np.arange(100_000) * 4.0
    recording.curves = SimpleNamespace(table=lambda: rows, columns=recording.curves.columns)  # type: ignore[assignment]
    data = data_of(page(recording, "x.log", ""))
    apart_s = np.diff(unpacked(data["columns"]["time_s"]))
    assert apart_s.max() < 3.0 * data["period_s"]


def test_of_too_many_rows_what_the_rail_gave_is_not_mistaken_for_what_was_used_besides() -> None:
    curves = Curves(2)
    for k in range(100):
        slides = k == 55
        curves.take(estimate(time_s=float(k), saturated=slides, adhesion=0.03 if slides else 0.1), lambda *_: True)
    available = curves.columns(to_draw(curves.table(), 10))["adhesion_available"]
    assert available[np.isfinite(available)].tolist() == [0.03, 0.03]


def test_an_invalid_estimate_is_a_gap_in_the_curves_and_so_is_an_input_that_is_not_told() -> None:
    curves = Curves(2)
    held = wheelset(friction_status=Status.INVALID)
    for told in ([], [Quantity.SPEED], [Quantity.AXLE_SPEED], [Quantity.SPEED, Quantity.AXLE_SPEED]):
        curves.take(estimate(status=Status.INVALID, wheelsets=(held, wheelset())), lambda q, _, told=told: q in told)
    columns = curves.columns(curves.table())
    names = ("speed_mps", "adhesion", "adhesion_std", "adhesion_available")
    assert all(np.isnan(columns[name]).all() for name in names)
    first, second = (columns["wheelsets"][i] for i in (1, 2))
    for name in ("friction", "friction_std", "adhesion"):
        assert np.isnan(first[name]).all()
        assert np.isfinite(second[name]).all()
    for name, is_gap in (("slip", [1, 1, 1, 0]), ("omega_radps", [1, 1, 0, 0]), ("pressing_force_n", [1, 1, 1, 1])):
        assert np.isnan(second[name]).tolist() == is_gap


def test_the_map_is_true_to_scale_and_north_is_up() -> None:
    north = np.linspace(52.0, 52.01, 50)
    track = TrackMap(north, np.full(50, 10.0))
    (x0, y0), (x1, y1) = track.place(52.0, 10.0), track.place(52.01, 10.0)
    assert x0 == pytest.approx(x1)
    metres = np.radians(0.01) * EARTH_RADIUS_M
    assert (y0 - y1) / track.scale == pytest.approx(metres)
    east = track.place(52.0, 10.01)
    assert (east[0] - x0) / track.scale == pytest.approx(metres * np.cos(np.radians(52.005)), rel=1e-6)


def test_places_of_low_adhesion_are_on_the_map_and_no_position_is_no_map() -> None:
    settings = load_settings(CONFIG)
    columns = {
        "latitude_deg": np.linspace(52.0, 52.01, 100),
        "longitude_deg": np.linspace(10.0, 10.01, 100),
        "adhesion_available": np.repeat([np.nan, 0.03], 50),
    }
    evidence = {"latitude_deg_start": 52.005, "longitude_deg_start": 10.005}
    drawn = drawing(columns, (alarm(evidence=evidence, message="<b>"), alarm(kind="hot_disc")), settings, 0.0)
    assert drawn is not None
    assert drawn.count("<circle") == 1
    assert "&lt;b&gt;" in drawn
    very_low = re.search(r'class="very-low-way" d="([^"]*)"', drawn)
    assert very_low
    assert len(re.findall("[ML]", very_low[1])) == 50
    nowhere = columns | {"latitude_deg": np.full(100, np.nan)}
    assert drawing(nowhere, (), settings, 0.0) is None


def test_numbers_are_written_for_people() -> None:
    assert number(-0.0004, 3) == "0.000"
    assert number(-0.5, 1) == "−0.5"
    assert number(float("nan"), 1) == number(None, 1) == "–"
    assert elapsed(62.34) == "1:02.3"
    assert elapsed(3723.0) == "1:02:03.0"
    assert [duration(s) for s in (42.0, 116.6, 3725.0)] == ["42 s", "1 min 57 s", "1 h 2 min"]
    assert described("speed_start_mps", 21.3) == ("speed start", "21.3 m/s")
    assert described("latitude_deg_start", 52.005) == ("latitude start", "52.005000 °")
    assert described("started_time_s", 1700000000.0) == ("started time", "2023-11-14 22:13:20 UTC")
    assert described("wsp_actions", 8.0) == ("wsp actions", "8")
    assert described("level", "very low") == ("level", "very low")


@pytest.mark.parametrize(
    ("name", "value", "words", "text"),
    [
        ("energy_j", 3789373.0, "energy", "3.789 MJ"),
        ("energy_j", 45200.0, "energy", "45.2 kJ"),
        ("energy_j", 2.5e9, "energy", "2500 MJ"),
        ("pressing_force_n", 32550.0, "pressing force", "32.5 kN"),
        ("pressing_force_n", 120.5, "pressing force", "120 N"),
        ("torque_nm", 2841.3, "torque", "2.841 kN m"),
        ("torque_apart", -0.406, "torque apart", "−40.6 %"),
        ("change", 0.25, "change", "25 %"),
        ("greatest_slip_2", 0.125, "greatest slip 2", "12.5 %"),
        ("creep", 0.0004, "creep", "0.040 %"),
        ("adhesion", 0.0312, "adhesion", "0.031"),
        ("torque_apart", -0.000004, "torque apart", "0.000 %"),
    ],
)
def test_evidence_has_units_that_people_use(name: str, value: float, words: str, text: str) -> None:
    assert described(name, value) == (words, text)


def stop_of(*wheelsets: tuple[float, float]) -> ApplicationRecord:
    """A brake application of wheelsets with such frictions and their standard deviations."""
    zero = dict.fromkeys(WheelsetRecord.__struct_fields__, 0.0)
    own = [
        zero | {"friction": friction, "friction_std": std, "friction_energy_j": 1e6, "wsp_actions": 0}
        for friction, std in wheelsets
    ]
    wagon = dict.fromkeys(ApplicationRecord.__struct_fields__, 0.0) | {"wheelsets": own, "calibration": 0}
    return msgspec.convert(wagon, ApplicationRecord)


@pytest.mark.parametrize(
    ("second", "kind", "force_apart", "is_hinted"),
    [
        (0.268, "uneven_braking", 0.01, True),
        (0.268, "uneven_braking", -0.38, False),  # it presses less: no friction is shared
        (0.17, "uneven_braking", 0.01, False),
        (0.268, "hot_disc", 0.01, False),
    ],
)
def test_frictions_that_are_shared_do_not_speak_against_an_alarm(
    second: float, kind: str, force_apart: float, is_hinted: bool
) -> None:
    recording = Recording(load_settings(CONFIG))
    recording.curves.take(estimate(), lambda quantity, wheelset: True)
    recording.applications = [stop_of((0.268, 0.01), (second, 0.01))]
    evidence = {"torque_apart": -0.4, "pressing_force_apart": force_apart}
    recording.note_alarms([alarm(kind=kind, wheelset=2, evidence=evidence)])
    (said,) = (text for text in summary(recording) if text.startswith("Pad friction"))
    assert f"0.268 on wheelset 1, {second:.3f} on wheelset 2" in said
    assert ("see the alarm “Uneven braking” of wheelset 2." in said) == is_hinted


def test_the_interval_of_a_friction_is_named() -> None:
    """One standard deviation of 0.015 is 0.029 for 95 %."""
    recording = Recording(load_settings(CONFIG))
    recording.curves.take(estimate(time_s=0.0), lambda quantity, wheelset: True)
    recording.applications = [stop_of((0.3, 0.015), (0.31, 0.02))]
    table = tables.applications(recording)
    assert "1: friction ± (95 %)" in table
    assert "<td>0.300 ± 0.029</td>" in table


def test_a_friction_that_is_hardly_known_counts_little() -> None:
    """Four times as unsure, a sixteenth of the weight: (0.55 + 16 * 0.38) / 17 = 0.39."""
    recording = Recording(load_settings(CONFIG))
    recording.curves.take(estimate(), lambda quantity, wheelset: True)
    recording.applications = [stop_of((0.55, 0.2), (0.35, 0.01)), stop_of((0.38, 0.05), (0.37, 0.01))]
    (said,) = (text for text in summary(recording) if text.startswith("Pad friction"))
    assert "0.390 on wheelset 1, 0.360 on wheelset 2" in said
