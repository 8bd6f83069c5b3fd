"""The contract in docs/interface.md names every key and every field, and nothing else."""

import re
from pathlib import Path

import pytest

from brake_monitor.publishing.payload_schemas import KEYS, TYPES
from brake_monitor.settings.key_space import KeySpace

DOCUMENT = (Path(__file__).parents[2] / "docs" / "interface.md").read_text()
IN_EVERY_MESSAGE = {"time_s", "publish_time_s", "sequence"}
QUALITY = {"status", "quality"}
HEADINGS = {
    "adhesion": "adhesion",
    "axle-friction": r"axle/\<i\>/friction",
    "axle-adhesion": r"axle/\<i\>/adhesion",
    "axle-wear": r"axle/\<i\>/wear",
    "alarm": r"alarm/\<kind\>[/\<i\>]",
    "health": "health",
    "meta": "meta",
}


def first_cells(text: str) -> set[str]:
    """What stands in code type in the first column of the tables."""
    cells = re.findall(r"^\| (`[^|]*) \|", text, re.MULTILINE)
    return {name for cell in cells for name in re.findall(r"`([^`]+)`", cell)}


@pytest.mark.parametrize("name", KEYS.values())
def test_every_field_of_a_payload_has_its_line(name: str) -> None:
    section = DOCUMENT.split(f"\n### {HEADINGS[name]}\n")[1].split("\n#")[0]
    fields = set(TYPES[name].__struct_fields__)
    common = IN_EVERY_MESSAGE | (QUALITY if name not in {"alarm", "meta"} else set())
    assert fields >= common
    assert first_cells(section) == fields - common


def test_what_is_in_every_message_is_told_once() -> None:
    section = DOCUMENT.split("\n## In every message\n")[1].split("\n#")[0]
    assert first_cells(section) == IN_EVERY_MESSAGE | QUALITY


def test_every_key_is_in_the_table() -> None:
    keys = KeySpace("<prefix>", "<wagon>")
    expected = {keys.wagon, keys.adhesion, keys.health, keys.meta, keys.acknowledge, keys.schema("<name>")}
    expected |= {key.replace("/0/", "/<i>/") for key in (keys.friction(0), keys.axle_adhesion(0), keys.wear(0))}
    expected |= {keys.alarm("<kind>", None) + "[/<i>]"}
    assert first_cells(DOCUMENT.split("\n## Where\n")[1].split("\n## ")[0]) == expected
