"""What is loaded of python-can and with it: nothing that is not needed, nothing that somebody else would miss."""

import subprocess
import sys

import pytest

pytest.importorskip("asammdf")

WITHOUT = "from brake_monitor.host.python_can import load_without_asammdf, mf4", "load_without_asammdf()", "import can"
NO_ASAMMDF = "sys.modules['asammdf'] = None"  # which takes a second, and is not looked for
A_COMMAND = "from brake_monitor import cli", "cli.main(['check', '-c', 'nothere.toml'])"
THE_DAEMON = (
    "from brake_monitor import cli",
    "cli.main(['run', '-c', 'nothere.toml'])",  # with all that the command loads
    "from brake_monitor.processing.pipeline import Pipeline",
    "from brake_monitor.settings.example_vehicles import example_settings",
    "Pipeline.from_settings(example_settings('wagon'))",
)
A_VIRTUAL_BUS = (
    "from brake_monitor.bus.can_source import open_bus",
    "from brake_monitor.settings.config import CanBus",
    "open_bus(CanBus('virtual', 'a', (), 'a'), []).close()",
)


def loaded_after(*statements: str) -> list[str]:
    """Which of python-can, asammdf and OpenSSL, which comes with both, a new process has loaded after these."""
    told = "print(*(name for name in ('can', 'asammdf', '_hashlib') if name in sys.modules))"
    script = "\n".join(("import sys", *statements, told))
    return subprocess.run([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True, check=True).stdout.split()


def test_python_can_loads_it() -> None:
    """Else all of this can go."""
    assert loaded_after("import can") == ["can", "asammdf", "_hashlib"]


@pytest.mark.parametrize("statements", [WITHOUT, A_COMMAND])
def test_it_is_not_loaded_before_it_is_needed(statements: tuple[str, ...]) -> None:
    assert loaded_after(*statements) == ["can", "_hashlib"]


def test_it_is_loaded_for_mf4() -> None:
    assert loaded_after(*WITHOUT, "mf4().MF4Writer('/dev/null')") == ["can", "asammdf", "_hashlib"]


def test_who_else_wants_it_gets_it() -> None:
    assert loaded_after(*WITHOUT, "import asammdf", "asammdf.MDF") == ["can", "asammdf", "_hashlib"]


def test_what_is_loaded_already_stays_as_it_is() -> None:
    assert loaded_after("import can", "writer = can.MF4Writer", *WITHOUT, "assert mf4().MF4Writer is writer")


def test_the_daemon_reads_its_dbc_without_any_of_it() -> None:
    assert loaded_after(*THE_DAEMON) == []


def test_the_daemon_loads_it_for_a_bus_that_needs_it() -> None:
    assert loaded_after(*THE_DAEMON, *A_VIRTUAL_BUS) == ["can", "_hashlib"]


def test_who_wants_all_of_cantools_gets_it() -> None:
    wanted = (
        "from brake_monitor.decoding import dbc",
        "import cantools",
        "assert cantools.tester and cantools.__version__",
    )
    same = "assert cantools.database.load_string is dbc.load_string"
    assert "can" in loaded_after(NO_ASAMMDF, *THE_DAEMON, *wanted, same)


def test_a_cantools_that_cannot_be_taken_apart_is_loaded_whole() -> None:
    whole = "import cantools.database", "assert cantools.tester"
    refuses = (
        "sys.modules['cantools.typechecking'] = None",
        "load_cantools_alone()",
        "del sys.modules['cantools.typechecking']",
    )
    asked = "from brake_monitor.host.python_can import load_cantools_alone"
    assert "can" in loaded_after(NO_ASAMMDF, asked, *refuses, *whole)
