"""A short soak; python tests/benchmarks/soak.py plays the whole day."""

import subprocess
import sys
from pathlib import Path

PATIENCE_S = 1800.0  # for a machine that does other things as well
SOAK = Path(__file__).parents[1] / "benchmarks" / "soak.py"


def test_some_minutes_of_service_through_the_live_path_hold_what_a_day_must() -> None:
    done = subprocess.run(
        [sys.executable, SOAK, "0.2"], capture_output=True, text=True, timeout=PATIENCE_S, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "nothing grows beyond its bounds" in done.stdout
