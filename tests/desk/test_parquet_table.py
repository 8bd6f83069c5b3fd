"""The Parquet table: the columns of the CSV with types and units, in full precision."""

import csv
import math
import subprocess
import sys
from pathlib import Path

import pytest

from brake_monitor.cli import main
from brake_monitor.desk import parquet_table
from brake_monitor.estimation.estimate import Status
from brake_monitor.processing.estimate_table import header, line
from brake_monitor.settings.example_vehicles import example_config
from brake_monitor.value_names import unit_of
from estimates import estimate

pq = pytest.importorskip("pyarrow.parquet")

LOG = Path(__file__).parents[1] / "golden" / "slide.log.gz"
REPLAY = ["replay", "-c", str(example_config("wagon")), str(LOG), "-o"]


def test_it_holds_what_the_csv_holds(tmp_path: Path) -> None:
    assert main([*REPLAY, str(tmp_path / "out.csv")]) == 0
    assert main([*REPLAY, str(tmp_path / "out.parquet")]) == 0
    table = pq.read_table(tmp_path / "out.parquet")
    with (tmp_path / "out.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert table.column_names == list(rows[0])
    assert table.num_rows == len(rows)
    for name in table.column_names:
        for value, text in zip(table[name].to_pylist(), (one[name] for one in rows), strict=True):
            if isinstance(value, str):
                assert value == text
            elif not math.isnan(float(value)):
                assert float(value) == pytest.approx(float(text), rel=1e-6, abs=1e-6)


def test_capitals_name_it_too(tmp_path: Path) -> None:
    assert main([*REPLAY, str(tmp_path / "OUT.PARQUET")]) == 0
    assert pq.read_table(tmp_path / "OUT.PARQUET").num_rows > 0


def test_every_column_has_its_type_and_unit(tmp_path: Path) -> None:
    with parquet_table.parquet_table(tmp_path / "t.parquet", 2) as write:
        write([estimate(status=Status.HELD, reasons=("a", "b"))])
    schema = pq.read_schema(tmp_path / "t.parquet")
    units = {field.name: field.metadata[b"unit"].decode() for field in schema}
    assert units["time_s"] == "s"
    assert units["speed_mps"] == "m/s"
    assert units["omega_2_radps"] == "rad/s"
    assert units["pressing_force_1_n"] == "N"
    assert units["deceleration_std_mps2"] == "m/s²"
    assert units["adhesion"] == units["slip_1"] == units["status"] == ""
    (told,) = pq.read_table(tmp_path / "t.parquet").to_pylist()
    assert (told["saturated"], told["wsp_2"], told["status"], told["reasons"]) == (True, True, "held", "a; b")
    assert told["time_s"] == 1700000000.25


def test_it_is_written_in_parts_that_do_not_grow(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parquet_table, "ROWS_AT_ONCE", 10)
    with parquet_table.parquet_table(tmp_path / "t.parquet", 2) as write:
        for k in range(35):
            write([estimate(time_s=float(k))])
    file = pq.ParquetFile(tmp_path / "t.parquet")
    assert [file.metadata.row_group(k).num_rows for k in range(file.num_row_groups)] == [10, 10, 10, 5]
    assert file.read()["time_s"].to_pylist() == [float(k) for k in range(35)]


def test_without_the_extra_it_says_what_to_install(tmp_path: Path) -> None:
    program = (
        "import sys; sys.modules['pyarrow'] = None; from brake_monitor.cli import main; sys.exit(main(sys.argv[1:]))"
    )
    command = [sys.executable, "-c", program, *REPLAY, str(tmp_path / "out.parquet")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 2
    assert "Parquet needs the extra 'parquet'" in done.stderr


def test_the_csv_is_written_as_agreed() -> None:
    cells = dict(zip(header(2), line(estimate()).split(","), strict=True))
    assert (cells["time_s"], cells["saturated"], cells["wsp_2"]) == ("1700000000.250000", "1", "1")
    assert (cells["speed_mps"], cells["friction_1"], cells["reset_count"]) == ("18", "0.34", "0")
    assert unit_of("friction_1_status") == unit_of("reasons") == ""
