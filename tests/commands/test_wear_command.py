"""`brake-monitor wear`: a person reads what is left of the pads and enters what was measured."""

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from msgspec.structs import replace

from brake_monitor.cli import main
from brake_monitor.monitoring.brake_units.gauge import Gauge, after_gauge
from brake_monitor.settings.config_file import load_settings
from brake_monitor.settings.example_vehicles import example_config
from brake_monitor.storage.memory_directory import FILE_NAME
from brake_monitor.storage.store import Store
from brake_monitor.storage.store_batch import Batch
from brake_states import WHEELSETS, brakes

VEHICLE = "wagon-8127"
CONFIG = str(example_config("wagon"))
MEGAJOULE = 1_000_000  # in the numbers of brake_states: 1.5 MJ


@pytest.fixture
def state(tmp_path: Path) -> Path:
    with Store.open(tmp_path / FILE_NAME, VEHICLE, WHEELSETS) as store:
        store.write(Batch(brakes(200 * MEGAJOULE)))
    return tmp_path


def wear(state: Path, *arguments: str) -> int:
    action, *rest = arguments
    return main(["wear", action, "-c", CONFIG, "--state", str(state), *rest])


def shown(state: Path, capsys: pytest.CaptureFixture[str]) -> list[str]:
    capsys.readouterr()
    assert wear(state, "show") == 0
    return capsys.readouterr().out.splitlines()


def test_it_shows_what_the_energy_has_worn_off_in_80_columns(state: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lines = shown(state, capsys)
    assert max(map(len, lines)) <= 80
    # 300 MJ on 4 pads of 400 cm² at 0.2 cm³/MJ: 75 MJ each, 15 cm³, 0.375 mm; 50 000 km
    (row,) = (line for line in lines if line.split()[:2] == ["1", "34.6"])
    left_mm, *stops, left_km = row.split()[-5:]
    assert (left_mm, stops) == ("29.6", [">", "10", "M"])
    assert float(left_km.replace(",", "")) == pytest.approx(29.625 / 0.375 * 50e3)
    assert any(line.split()[:2] == ["1", "300.0"] and "50000.0" in line.split() for line in lines)


def test_a_measured_thickness_counts_at_once_and_teaches_the_wear_rate(
    state: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    settings = load_settings(Path(CONFIG)).wear
    with Store.look(state / FILE_NAME, VEHICLE, "rw") as store:  # measured a year ago
        written = store.brakes()
        assert written is not None
        noted = [replace(unit, pads=replace(unit.pads, gauged_time_s=1.0)) for unit in written.units]
        store.write(Batch(replace(written, units=tuple(noted))))
    assert wear(state, "set", "--wheelset", "2", "--thickness-mm", "34.2") == 0
    lines = shown(state, capsys)
    assert any(line.split()[:2] == ["2", "34.2"] for line in lines)
    assert lines[-1] == "entered, not yet taken up by the daemon: wheelset 2, pads measured, 34.2 mm"
    with Store.look(state / FILE_NAME, VEHICLE) as store:
        written, ((_, gauge),) = store.brakes(), store.gauges()
    assert written is not None
    assert written.units == tuple(noted)  # the daemon alone writes wear
    before, after = (b.units[1].pads.specific_wear_cm3_per_mj for b in (written, after_gauge(written, gauge, settings)))
    assert after.value > before.value  # 0.8 mm are more than was expected
    assert after.std < before.std


def test_it_says_of_which_pads_nothing_was_noted_and_what_was_set_aside(
    state: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As after a memory was lost: pads that were gauged at 29 mm the day before are taken for new."""
    told = "\n".join(shown(state, capsys))
    assert "pads of wheelset 1, 2: taken for new, as nobody noted anything of them;" in told
    assert "set aside" not in told
    (state / f"refused-20300317T174601-{FILE_NAME}").touch()
    assert wear(state, "set", "--wheelset", "2", "--thickness-mm", "29") == 0
    told = "\n".join(shown(state, capsys))
    assert "pads of wheelset 1: taken for new" in told
    assert f"an earlier memory was set aside: refused-20300317T174601-{FILE_NAME}" in told
    assert wear(state, "reset", "--all") == 0
    assert "taken for new" not in "\n".join(shown(state, capsys))


def test_new_pads_are_as_thick_as_new_ones(state: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert wear(state, "set", "--wheelset", "2", "--thickness-mm", "9") == 0
    assert wear(state, "reset", "--all") == 0
    rows = [line.split()[:2] for line in shown(state, capsys)]
    assert ["1", "35.0"] in rows
    assert ["2", "35.0"] in rows


@pytest.fixture
def fresh(tmp_path: Path) -> Path:
    """The state of a daemon that has seen no traffic."""
    Store.open(tmp_path / FILE_NAME, VEHICLE, WHEELSETS).close()
    return tmp_path


def test_before_any_traffic_it_shows_what_pads_are_taken_for(fresh: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As new ones, by [wear]; what is measured then counts at once."""
    lines = shown(fresh, capsys)
    assert lines[0] == "wagon-8127, before any traffic: taken for new unless measured; pads are due at 5 mm"
    assert [line.split() for line in lines if line.strip().startswith(("1", "2")) and "(" in line] == [
        ["1", "35.0", "(34.0", "to", "36.0)", "35.0", "30.0", "?", "?"],
        ["2", "35.0", "(34.0", "to", "36.0)", "35.0", "30.0", "?", "?"],
    ]
    assert wear(fresh, "set", "--wheelset", "2", "--thickness-mm", "30") == 0
    lines = shown(fresh, capsys)
    assert any(line.split()[:2] == ["2", "30.0"] for line in lines)
    assert lines[-1] == "entered, not yet taken up by the daemon: wheelset 2, pads measured, 30 mm"
    assert wear(fresh, "set", "--wheelset", "2", "--thickness-mm", "33") == 2
    assert "these pads had 30 mm" in capsys.readouterr().err


def test_a_thickness_of_other_pads_is_taken_once_new_ones_were_noted(
    state: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert wear(state, "set", "--wheelset", "1", "--thickness-mm", "20") == 0
    assert wear(state, "set", "--wheelset", "1", "--thickness-mm", "33") == 2
    assert "say so with `wear reset --wheelset 1` first" in capsys.readouterr().err
    assert wear(state, "reset", "--wheelset", "1") == 0
    assert wear(state, "set", "--wheelset", "1", "--thickness-mm", "33") == 0


def test_a_thickness_that_no_braking_explains_is_mistyped_or_that_of_other_pads(
    state: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """3.49 instead of 34.9, or another wheelset's: alarms that latch would be raised, and a wear rate be learned."""
    assert wear(state, "set", "--wheelset", "1", "--thickness-mm", "30") == 0  # nobody had measured them
    assert wear(state, "set", "--wheelset", "1", "--thickness-mm", "29.8") == 0  # the gauge errs
    assert wear(state, "set", "--wheelset", "1", "--thickness-mm", "3.49") == 2
    refusal = capsys.readouterr().err
    assert "--thickness-mm 3.49: expected 29.8 (29.4 to 30.2) mm; gauge again" in refusal
    assert "if the last entry (29.8 mm) is wrong, take it back with `wear undo --wheelset 1`" in refusal
    assert wear(state, "reset", "--wheelset", "1") == 0
    assert wear(state, "set", "--wheelset", "1", "--thickness-mm", "3.49") == 2
    assert "expected 35.0 (34.0 to 36.0) mm" in capsys.readouterr().err
    assert wear(state, "set", "--wheelset", "1", "--thickness-mm", "3.49", "--sure") == 0


def test_a_wrong_entry_is_taken_back(state: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A reading that was too low: each right one would be refused, as pads do not grow."""
    first = shown(state, capsys)
    assert wear(state, "set", "--wheelset", "1", "--thickness-mm", "16.6") == 0
    assert wear(state, "set", "--wheelset", "1", "--thickness-mm", "30.4") == 2
    assert "if the last entry (16.6 mm) is wrong, take it back with `wear undo" in capsys.readouterr().err
    assert wear(state, "undo", "--wheelset", "1") == 0
    assert "wheelset 1: last entry taken back; noted" in capsys.readouterr().out
    assert shown(state, capsys)[: len(first)] == first
    assert wear(state, "undo", "--wheelset", "1") == 2
    assert "wagon-8127: wheelset 1 has no entry that could be taken back" in capsys.readouterr().err
    assert wear(state, "set", "--wheelset", "1", "--thickness-mm", "30.4") == 0
    assert wear(state, "undo", "--all") == 2  # nobody has noted anything of wheelset 2
    assert "wheelset 2 has no entry" in capsys.readouterr().err
    assert any(line.split()[:2] == ["1", "30.4"] for line in shown(state, capsys))


REFUSED = {
    "no such wheelset": (
        ("set", "--wheelset", "3", "--thickness-mm", "9"),
        "wagon-8127 has 2 wheelsets",
    ),
    "thicker than new": (
        ("set", "--wheelset", "1", "--thickness-mm", "40"),
        "--thickness-mm 40: new pads have 35 mm as it is configured; if yours have more, say so in [wear]",
    ),
    "no pad is so thick": (("set", "--wheelset", "1", "--thickness-mm", "300"), "no pad is thicker than 100 mm"),
    "no reading is so bad": (
        ("set", "--wheelset", "1", "--thickness-mm", "30", "--std-mm", "1e200"),
        "--std-mm: no reading is that uncertain",
    ),
}


@pytest.mark.parametrize(("arguments", "sentence"), REFUSED.values(), ids=REFUSED)
def test_what_makes_no_sense_is_refused(
    state: Path, arguments: tuple[str, ...], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert wear(state, *arguments) == 2
    assert sentence in capsys.readouterr().err
    with Store.look(state / FILE_NAME, VEHICLE) as store:
        assert store.gauges() == []


@pytest.mark.parametrize(("thickness_mm", "code"), [("31.2", 0), ("31.4", 2)])
def test_pads_are_other_ones_when_they_measure_more_than_both_readings_allow(
    state: Path, thickness_mm: str, code: int
) -> None:
    """Two readings of 0.3 mm, one sigma, differ by 1.27 mm at three."""
    reading = ("set", "--wheelset", "1", "--std-mm", "0.3", "--thickness-mm")
    assert wear(state, *reading, "30") == 0
    assert wear(state, *reading, thickness_mm) == code


@pytest.mark.parametrize("arguments", [("set", "--thickness-mm", "9"), ("set", "--wheelset", "1"), ("reset",)])
def test_what_is_left_out_is_not_taken_for_every_wheelset_or_for_new_pads(
    state: Path, arguments: tuple[str, ...]
) -> None:
    with pytest.raises(SystemExit, match="2"):
        wear(state, *arguments)
    with Store.look(state / FILE_NAME, VEHICLE) as store:
        assert store.gauges() == []


@pytest.mark.parametrize("number", ["0", "-3", "nan", "inf", "thick"])
def test_a_thickness_is_a_positive_number(state: Path, number: str) -> None:
    with pytest.raises(SystemExit, match="2"):
        wear(state, "set", "--wheelset", "1", f"--thickness-mm={number}")


def test_an_entry_that_cannot_be_is_told_in_a_sentence(state: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with Store.look(state / FILE_NAME, VEHICLE, "rw") as store:
        store.enter(Gauge(1.7e9, 1, 30.0, 1e200))
    assert wear(state, "show") == 2
    assert "wheelset 1: pads measured, 30 mm: this entry is none that can be" in capsys.readouterr().err


@pytest.mark.parametrize(
    "damage",
    [
        "UPDATE wear SET time_s = 'x'",
        "UPDATE wear SET time_s = 1e300",
        "UPDATE wear SET time_s = -1e12",
        "UPDATE wear SET content = '{}'",
        "DELETE FROM wear WHERE wheelset = 1",
        "DROP TABLE gauges",
    ],
)
def test_a_memory_that_is_damaged_is_named_in_one_sentence(
    state: Path, capsys: pytest.CaptureFixture[str], damage: str
) -> None:
    with closing(sqlite3.connect(state / FILE_NAME)) as db, db:
        db.execute(damage)
    assert wear(state, "show") == 2
    (told,) = capsys.readouterr().err.splitlines()
    assert told.startswith(f"brake-monitor: {state / FILE_NAME}: ")


def test_where_there_is_no_memory_it_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert wear(tmp_path, "show") == 2
    assert "there is no memory here yet" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
    monkeypatch.delenv("STATE_DIRECTORY", raising=False)
    assert main(["wear", "show", "-c", CONFIG]) == 2
    assert "--state DIR" in capsys.readouterr().err


@pytest.mark.parametrize("arguments", [("show",), ("set", "--wheelset", "1", "--thickness-mm", "30")])
def test_the_memory_of_other_wheelsets_is_left_alone(
    tmp_path: Path, arguments: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    with Store.open(tmp_path / FILE_NAME, VEHICLE, WHEELSETS + 1) as store:
        own = brakes(5)
        store.write(Batch(replace(own, units=(*own.units, own.units[0]))))
    assert wear(tmp_path, *arguments) == 2
    told = capsys.readouterr().err
    assert told == f"brake-monitor: {CONFIG}: the vehicle has 2 wheelsets, the daemon's memory holds 3\n"
    with Store.look(tmp_path / FILE_NAME, VEHICLE) as store:
        assert store.gauges() == []


def test_a_file_is_no_state_directory(state: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert wear(state / FILE_NAME, "show") == 2
    assert f"{state / FILE_NAME}: expected the daemon's state directory, this is a file" in capsys.readouterr().err


def test_the_memory_of_another_vehicle_is_left_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with Store.open(tmp_path / FILE_NAME, "wagon-7", WHEELSETS) as store:
        store.write(Batch(brakes(5)))
    assert wear(tmp_path, "reset", "--all") == 2
    assert 'of vehicle "wagon-7", not of "wagon-8127"' in capsys.readouterr().err
