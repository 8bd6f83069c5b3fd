"""The daemon as a gateway has it: installed as systemd/README.md says, in a guest whose first process is systemd."""

import re
import shutil
import subprocess
import sys
import sysconfig
import time
import venv
from collections.abc import Callable
from pathlib import Path

import pytest

import brake_monitor
from brake_monitor.settings.example_vehicles import example_config

UNITS = Path(__file__).parents[1] / "systemd"
SERVICE = "brake-monitor.service"
INSTALLED = Path("/opt/brake-monitor")
ETC = Path("/etc/brake-monitor")
CONFIG = ETC / "config.toml"
STATE = Path("/var/lib/brake-monitor")
ENOUGH_S = 120.0


def run(*command: str | Path) -> str:
    """What a command says that has to succeed."""
    done = subprocess.run(command, capture_output=True, text=True, timeout=ENOUGH_S, check=False)
    if done.returncode:
        journal = subprocess.run(["journalctl", "-n", "30", "-u", SERVICE], capture_output=True, text=True, check=False)
        pytest.fail(f"{command}: {done.stdout}{done.stderr}{journal.stdout}")
    return done.stdout + done.stderr


def shown(what: str) -> str:
    """A property of the unit."""
    return run("systemctl", "show", SERVICE, f"--property={what}", "--value").strip()


def wait_until(condition: Callable[[], bool]) -> None:
    deadline_s = time.monotonic() + ENOUGH_S
    while not condition():
        assert time.monotonic() < deadline_s, run("systemctl", "show", SERVICE)
        time.sleep(0.1)


def install() -> None:
    """Put program, configuration and units where they belong; only once in the guest's life.

    The program goes where the unit looks for it: where the tests are, a dynamic user may not read.
    """
    if INSTALLED.exists():
        return
    venv.create(INSTALLED)
    ours, theirs = (Path(sysconfig.get_path("purelib", vars={"base": base})) for base in (sys.prefix, str(INSTALLED)))
    run("mount", "--bind", ours, theirs)
    shutil.copytree(Path(brake_monitor.__file__).parent, theirs / "brake_monitor")
    script = INSTALLED / "bin" / "brake-monitor"
    shutil.copy(Path(sys.executable).with_name(script.name), script)
    script.write_text(re.sub(r"\A#!.*", f"#!{INSTALLED}/bin/python", script.read_text()))

    ETC.mkdir()
    shutil.copy(example_config("wagon"), CONFIG)
    shutil.copy(example_config("wagon").with_name("wagon.dbc"), ETC)
    for unit in (SERVICE, "vcan@.service"):
        shutil.copy(UNITS / unit, "/etc/systemd/system")
    run("systemctl", "daemon-reload")
