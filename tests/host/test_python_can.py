"""What python-can loads beside itself: nothing that is not needed, nothing that somebody else would miss."""

import subprocess
import sys

import pytest

pytest.importorskip("asammdf")

WITHOUT = "from brake_monitor.host.python_can import load_without_asammdf, mf4", "load_without_asammdf()", "import can"
A_COMMAND = "from brake_monitor import cli", "cli.main(['check', '-c', 'nothere.toml'])"


def loaded_after(*statements: str) -> list[str]:
    """Which of python-can and asammdf a new process has loaded after these."""
    told = "print(*(name for name in ('can', 'asammdf') if name in sys.modules))"
    script = "\n".join(("import sys", *statements, told))
    return subprocess.run([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True, check=True).stdout.split()


def test_python_can_loads_it() -> None:
    """Else all of this can go."""
    assert loaded_after("import can") == ["can", "asammdf"]


@pytest.mark.parametrize("statements", [WITHOUT, A_COMMAND])
def test_it_is_not_loaded_before_it_is_needed(statements: tuple[str, ...]) -> None:
    assert loaded_after(*statements) == ["can"]


def test_it_is_loaded_for_mf4() -> None:
    assert loaded_after(*WITHOUT, "mf4().MF4Writer('/dev/null')") == ["can", "asammdf"]


def test_who_else_wants_it_gets_it() -> None:
    assert loaded_after(*WITHOUT, "import asammdf", "asammdf.MDF") == ["can", "asammdf"]


def test_what_is_loaded_already_stays_as_it_is() -> None:
    assert loaded_after("import can", "writer = can.MF4Writer", *WITHOUT, "assert mf4().MF4Writer is writer")
