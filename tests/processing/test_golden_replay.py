"""Fifteen seconds around the first slide, replayed: estimates must not drift unnoticed.

tests/golden/slide.log.gz is a candump recording of the example wagon (scenario wsp), tests/golden/slide.csv what
`replay` made of it. When estimates are meant to change, say why in the commit and renew the table with

    python tests/processing/test_golden_replay.py

which also makes the recording anew where there is none.
"""

import csv
from pathlib import Path

import pytest

from brake_monitor.cli import main
from brake_monitor.settings.example_vehicles import example_config, example_settings
from brake_monitor.simulator.files import write_log
from brake_monitor.simulator.simulate import EPOCH_S, run

GOLDEN = Path(__file__).parents[1] / "golden"
LOG = GOLDEN / "slide.log.gz"
TABLE = GOLDEN / "slide.csv"
FROM_S, TO_S = 37.0, 52.0  # the stop brake comes at 42 s, the first slide right after it
TOLERANCE = 1e-6  # another processor's linear algebra rounds differently, but not by more


def replay(table: Path) -> None:
    """Write the estimates of the recording, through the command that a user gives."""
    assert main(["replay", "-c", str(example_config("wagon")), str(LOG), "-o", str(table)]) == 0


def rows(table: Path) -> list[dict[str, str]]:
    """The estimates, row by row."""
    with table.open(newline="") as stream:
        return list(csv.DictReader(stream))


def test_estimates_are_those_of_the_golden_table(tmp_path: Path) -> None:
    replay(tmp_path / "now.csv")
    now, golden = rows(tmp_path / "now.csv"), rows(TABLE)
    assert len(now) == len(golden)
    for found, expected in zip(now, golden, strict=True):
        assert found.keys() == expected.keys()
        for name, value in expected.items():
            at = f"{name} at {expected['time_s']}"
            if name.endswith(("status", "reasons")) or not value:
                assert found[name] == value, at
            else:
                assert float(found[name]) == pytest.approx(float(value), rel=TOLERANCE, abs=TOLERANCE), at


def test_the_golden_recording_has_a_slide_in_it() -> None:
    golden = rows(TABLE)
    assert max(float(row["slip_1"]) for row in golden) > 0.08
    assert {row["saturated"] for row in golden} == {"0", "1"}
    assert {"held", "valid"} <= {row["friction_1_status"] for row in golden}


def renew() -> None:
    """Write the golden table, and the recording where there is none."""
    if not LOG.exists():
        GOLDEN.mkdir(exist_ok=True)
        recording = run("wsp", example_settings("wagon"), seed=1)
        write_log(LOG, [frame for frame in recording.frames if FROM_S <= frame.time_s - EPOCH_S < TO_S])
    replay(TABLE)


if __name__ == "__main__":
    renew()
