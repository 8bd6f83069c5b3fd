"""What is told before any command runs: the program's own help and version, and who is named there."""

import subprocess
import sys
from pathlib import Path

import pytest

from brake_monitor import cli, commands

NO_COMMANDS = {"__init__", "file_checks", "gauge_check", "options", "playback", "summary"}  # what several of them share


def test_every_command_is_offered() -> None:
    modules = {path.stem for path in Path(commands.__path__[0]).glob("*.py")} - NO_COMMANDS
    assert modules == {name.replace("-", "_") for name in cli.COMMANDS}


@pytest.mark.parametrize("option", ["--help", "--version"])
def test_it_is_told_at_once(option: str) -> None:
    """Without what a command needs: numpy alone takes longer than all that is told."""
    told = f"import sys; from brake_monitor import cli\ntry: cli.main([{option!r}])\nfinally: print(*sys.modules)"
    process = subprocess.run([sys.executable, "-c", told], stdout=subprocess.PIPE, text=True, check=False)
    assert process.returncode == 0
    loaded = process.stdout.splitlines()[-1].split()
    assert "brake_monitor.cli" in loaded
    assert not {"numpy", "can", "cantools", "zenoh", "brake_monitor.commands"} & set(loaded)


def test_from_its_sources_alone_it_runs_as_well() -> None:
    absent = "import importlib.metadata as m\ndef absent(name): raise m.PackageNotFoundError(name)\nm.version = absent"
    told = f"{absent}\nfrom brake_monitor import cli\ncli.main(['--version'])"
    process = subprocess.run([sys.executable, "-c", told], stdout=subprocess.PIPE, text=True, check=False)
    assert (process.returncode, process.stdout) == (0, "brake-monitor (not installed)\n")
