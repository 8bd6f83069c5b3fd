"""The schemas: generated from the types, kept in the repository, and true of the bytes that are published."""

import json
from pathlib import Path
from typing import Any

import jsonschema
import msgspec
import pytest

from brake_monitor.cli import main
from brake_monitor.monitoring.brake_units.brakes import Brakes, BrakeUnit
from brake_monitor.monitoring.brake_units.wear import PadUse, PadWear
from brake_monitor.processing.pipeline import Outputs, Pipeline
from brake_monitor.publishing.about import about
from brake_monitor.publishing.health import intake_of
from brake_monitor.publishing.payload_schemas import KEYS, TYPES, schema
from brake_monitor.publishing.publisher import Publisher
from brake_monitor.samples import Quantity
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.settings.wear_settings import WearSettings
from brake_monitor.settings.zenoh_settings import ZenohSettings
from brake_monitor.value_names import UNITS
from estimates import alarm, estimate
from network import is_answered, session
from program import until

KEPT = Path(__file__).parents[2] / "docs" / "schema"
WITHOUT_UNIT = {  # numbers that are counts, numbers of something, or coefficients
    "adhesion", "adhesion_std", "friction", "friction_std", "friction_nominal", "slip", "nis", "reset_count",
    "sequence", "wheelset", "wheelsets", "remaining_stops", "stops", "frames", "mapped_frames", "decode_errors",
    "lost_frames", "dropped_frames", "bus_failures", "frames_waiting", "late_samples", "outliers", "filter_resets",
    "estimates_sent", "estimates_replaced", "events_sent", "events_waiting", "events_lost", "queries_answered",
    "queries_refused", "publish_failures", "latency_counts",
}  # fmt: skip


def published() -> dict[str, tuple[str, Any, bytes]]:
    """What a get on everything returns from a publisher that has published everything: encoding and bytes by key."""
    settings = example_settings("wagon")
    pipeline = Pipeline.from_settings(settings)
    pads = PadWear.new(WearSettings()).used(PadUse(2e6, 6e6, 1.0, 3.0, 400.0))
    brakes = Brakes(1700000000.0, (BrakeUnit(pads, 80.0),) * 2, ())
    everything: dict[str, tuple[str, Any, bytes]] = {}
    for format in ("json", "msgpack"):
        zenoh = ZenohSettings(encoding=format)
        publisher = Publisher(zenoh, "wagon-1", about=about(settings, 1700000000.0))
        publisher.start()
        try:
            unknown = frozenset({(quantity, 0) for quantity in Quantity})
            broken = estimate(adhesion=float("nan"), reasons=("speed awaited",), unknown=unknown)
            publisher.publish(Outputs(broken, (alarm(), alarm(kind="hot_disc", wheelset=2))))
            publisher.publish_wear(brakes, settings.wear)
            publisher.publish_health(intake_of(pipeline, ("can0",), 1, 3))
            with session(publisher.endpoints[0]) as other:
                until(lambda other=other: is_answered(other, "brake/v1/wagon-1/health"))  # the last of it
                for reply in other.get("brake/v1/wagon-1/**"):
                    assert reply.ok is not None
                    key = f"{format} {reply.ok.key_expr}"
                    everything[key] = (str(reply.ok.encoding), format, reply.ok.payload.to_bytes())
        finally:
            publisher.close()
    return everything


def schema_of(key: str) -> dict[str, Any]:
    below = key.partition("wagon-1/")[2].split("/")
    name = "alarm" if below[0] == "alarm" else "-".join(chunk for chunk in below if not chunk.isdigit())
    return json.loads((KEPT / f"{name}.json").read_text())


def test_what_is_published_is_what_the_kept_schemas_say() -> None:
    everything = published()
    below = sorted({key.partition("wagon-1/")[2] for key in everything})
    assert below == [
        "adhesion", "alarm/hot_disc/2", "alarm/low_adhesion", "axle/1/adhesion", "axle/1/friction", "axle/1/wear",
        "axle/2/adhesion", "axle/2/friction", "axle/2/wear", "health", "meta",
    ]  # fmt: skip
    for key, (encoding, format, payload) in everything.items():
        assert encoding == f"application/{format}"
        message = json.loads(payload) if format == "json" else msgspec.msgpack.decode(payload)
        jsonschema.validate(message, schema_of(key), jsonschema.Draft202012Validator)
        assert {"time_s", "publish_time_s", "sequence"} <= message.keys()
    adhesion = msgspec.msgpack.decode(everything["msgpack brake/v1/wagon-1/adhesion"][2])
    assert (adhesion["adhesion"], adhesion["speed_mps"]) == (None, None)  # in MessagePack as well


def test_a_schema_refuses_what_is_not_published() -> None:
    wrong = json.loads(msgspec.json.encode({"adhesion": "0.1"}))
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(wrong, json.loads(schema("adhesion")), jsonschema.Draft202012Validator)


@pytest.mark.parametrize("name", TYPES)
def test_the_kept_schemas_are_those_of_the_types(name: str) -> None:
    """Else: brake-monitor schema -o docs/schema."""
    jsonschema.Draft202012Validator.check_schema(json.loads(schema(name)))
    assert (KEPT / f"{name}.json").read_bytes() == schema(name)


def test_the_command_writes_what_is_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema", "-o", str(tmp_path / "new")]) == 0
    written = {path.name: path.read_bytes() for path in (tmp_path / "new").iterdir()}
    assert written == {path.name: path.read_bytes() for path in KEPT.iterdir()}
    assert main(["schema", "alarm"]) == 0
    assert capsys.readouterr().out.encode() == written["alarm.json"]


@pytest.mark.parametrize("name", KEYS.values())
def test_every_number_says_its_unit(name: str) -> None:
    document = json.loads(schema(name))
    (root,) = (d for n, d in document["$defs"].items() if n == TYPES[name].__name__)
    for field, described in root["properties"].items():
        kinds = {described.get("type")} | {option.get("type") for option in described.get("anyOf", [])}
        items = described.get("items", {})
        if kinds & {"number", "integer"} or (isinstance(items, dict) and items.get("type") in {"number", "integer"}):
            assert field in WITHOUT_UNIT or field.rpartition("_")[2] in UNITS, f"{name}: {field} has no unit"
