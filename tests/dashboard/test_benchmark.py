"""What the benchmark of the page says of what it is given; tests/benchmarks/dashboard.py looks on for an hour."""

import subprocess
import sys
from pathlib import Path

import pytest

BENCHMARK = Path(__file__).parents[1] / "benchmarks" / "dashboard.py"


@pytest.mark.parametrize("given", [("2", "1"), ("2", "0"), ("2", "2", "2")])
def test_a_time_that_has_no_minute_for_each_half_is_refused(given: tuple[str, ...]) -> None:
    done = subprocess.run([sys.executable, BENCHMARK, *given], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert done.stderr == "expected [WAGONS] [MINUTES], at least one minute for each half, two in all\n"
