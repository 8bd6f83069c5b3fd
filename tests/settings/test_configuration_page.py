"""docs/configuration.md names every key there is, with the default that it has, and no other."""

import re
import shutil
import tomllib
from pathlib import Path
from typing import Any

import pytest
from msgspec import NODEFAULT, Struct
from msgspec.structs import fields

from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.samples import TRAITS
from brake_monitor.settings.alarm_settings import AlarmSettings, RuleSettings
from brake_monitor.settings.config import (
    CanBus,
    EstimatorSettings,
    OutputSettings,
    Settings,
    SignalMapping,
    Signals,
    TuningOverrides,
    Vehicle,
)
from brake_monitor.settings.config_file import load_settings
from brake_monitor.settings.example_vehicles import example_config
from brake_monitor.settings.store_settings import StoreSettings
from brake_monitor.settings.wear_settings import WearSettings
from brake_monitor.settings.zenoh_settings import MetricsSettings, TlsSettings, ZenohSettings

PAGE = Path(__file__).parents[2] / "docs" / "configuration.md"
TABLES: dict[str, list[type[Struct]]] = {
    "vehicle": [Vehicle],
    "can": [CanBus],
    "signals": [Signals, SignalMapping],
    "estimator": [EstimatorSettings],
    "estimator.tuning": [TuningOverrides],
    "output": [OutputSettings],
    "zenoh": [ZenohSettings],
    "zenoh.tls": [TlsSettings],
    "metrics": [MetricsSettings],
    "store": [StoreSettings],
    "wear": [WearSettings],
}
TABLES_BELOW = {"estimator": {"tuning"}, "zenoh": {"tls"}}

Row = list[str]  # the cells


def sections() -> dict[str, list[list[Row]]]:
    """Section → its tables → their rows."""
    found: dict[str, list[list[Row]]] = {}
    tables: list[list[Row]] = []
    for line in PAGE.read_text().splitlines():
        if heading := re.match(r"##+ \[(.*)\]$", line):
            tables = found.setdefault(heading[1], [])
        elif line.startswith("| key |"):
            tables.append([])
        elif line.startswith("| `"):
            tables[-1].append([cell.strip() for cell in line.strip("|").split(" |")])
    return found


def told(rows: list[Row]) -> dict[str, Any]:
    """Key → its default; NODEFAULT where the page has none."""
    defaults: dict[str, Any] = {}
    for keys, default, *_ in rows:
        names, values = re.findall(r"`([^`]*)`", keys), [value_of(text) for text in re.findall(r"`([^`]*)`", default)]
        values = values or [None if default == "–" else NODEFAULT]
        for place, name in enumerate(names):
            defaults[name] = values[place if len(values) > 1 else 0]
    return defaults


def value_of(text: str) -> Any:
    (value,) = tomllib.loads(f"value = {text}").values()
    return tuple(value) if isinstance(value, list) else value


def real(table: type[Struct]) -> dict[str, Any]:
    return {field.name: field.default for field in fields(table)}


@pytest.mark.parametrize("section", TABLES)
def test_every_key_of_a_table_is_told_with_its_default(section: str) -> None:
    written = sections()[section]
    assert len(written) == len(TABLES[section])
    for rows, table in zip(written, TABLES[section], strict=True):
        below = TABLES_BELOW.get(section, set())
        assert told(rows) == {name: value for name, value in real(table).items() if name not in below}


def test_every_rule_is_told_with_what_differs_from_all() -> None:
    of_all, special = sections()["alarms.*"]
    common = told(of_all)
    assert common == real(RuleSettings)
    expected = {
        f"{kind.name}.{name}": value
        for kind in fields(AlarmSettings)
        for name, value in real(type(getattr(AlarmSettings(), kind.name))).items()
        if name not in common or value != common[name]
    }
    found: dict[str, Any] = {}
    for row in special:
        keys = told([row])
        rule = next(iter(keys)).partition(".")[0]
        found |= {rule + name.removeprefix(rule): value for name, value in keys.items()}
    assert found == expected


def test_no_table_of_the_configuration_is_left_out() -> None:
    tables = {field.name for field in fields(Settings)} - {"path"}
    assert {name.partition(".")[0] for name in sections()} == tables


def test_units_and_assumed_noises_of_the_signals_are_those_of_the_program() -> None:
    for keys, _, units, noise, _ in sections()["signals"][0]:
        for quantity in re.findall(r"`([^`]*)`", keys):
            assert re.findall(r"`([^`]*)`", units) == [unit for unit in TRAITS[quantity].units if unit]
            number = re.match(r"[\d.e-]*", noise)
            assert number is not None
            assert float(number[0] or 0.0) == TRAITS[quantity].noise_std


def test_the_example_of_several_buses_holds(tmp_path: Path) -> None:
    (example,) = re.findall(r"^```toml\n(.*?)^```", PAGE.read_text(), re.DOTALL | re.MULTILINE)
    wagon = example_config("wagon")
    vehicle = re.search(r"^\[vehicle\].*?(?=^\[)", wagon.read_text(), re.DOTALL | re.MULTILINE)
    assert vehicle is not None
    for name in ("wagon", "train"):
        shutil.copy(wagon.with_suffix(".dbc"), tmp_path / f"{name}.dbc")
    (tmp_path / "two.toml").write_text(vehicle[0] + example)
    settings = load_settings(tmp_path / "two.toml")
    channels = SignalDecoder.from_settings(settings).channels
    assert {(channel.message, channel.bus) for channel in channels} == {
        ("GNSS", "train"), ("WSP", "wagon"), ("BCU", "wagon")
    }  # fmt: skip
