"""Example vehicles whose messages come as often as wanted."""

import re
import shutil
from collections.abc import Mapping
from pathlib import Path

from brake_monitor.settings.example_vehicles import example_config

SLOW_MS = {288: 50, 416: 100, 672: 200}  # the wagon's BCU, WSP and GNSS on a slow bus


def with_cycles(dbc: str, cycles_ms: Mapping[int, int]) -> str:
    """A DBC file's text with these cycle times, by identifier as it is written there."""
    for can_id, cycle_ms in cycles_ms.items():
        dbc, changed = re.subn(rf'(GenMsgCycleTime" BO_ {can_id}) \d+;', rf"\1 {cycle_ms};", dbc)
        assert changed == 1
    return dbc


def vehicle_with_cycles(name: str, folder: Path, cycles_ms: Mapping[int, int]) -> Path:
    """The configuration of an example vehicle in a folder of its own, with these cycle times."""
    example = example_config(name)
    dbc = example.with_name(f"{name}.dbc").read_text()
    (folder / f"{name}.dbc").write_text(with_cycles(dbc, cycles_ms))
    return Path(shutil.copy(example, folder / f"{name}.toml"))
