"""The JSON Schema of every payload, from the types themselves."""

from functools import cache
from inspect import cleandoc
from typing import Any

import msgspec

from brake_monitor.publishing.payloads import (
    AcknowledgeReply,
    AcknowledgeRequest,
    AdhesionMessage,
    AlarmMessage,
    AxleAdhesionMessage,
    FrictionMessage,
    HealthMessage,
    MetaMessage,
    WearMessage,
)

# The schema of what is published under a key: the key's chunks without numbers, joined by "-".
TYPES: dict[str, type] = {
    "adhesion": AdhesionMessage,
    "axle-friction": FrictionMessage,
    "axle-adhesion": AxleAdhesionMessage,
    "axle-wear": WearMessage,
    "alarm": AlarmMessage,
    "health": HealthMessage,
    "meta": MetaMessage,
    "acknowledge-request": AcknowledgeRequest,
    "acknowledge-reply": AcknowledgeReply,
}

KEYS = {  # relative to the wagon's key
    "adhesion": "adhesion",
    "axle/*/friction": "axle-friction",
    "axle/*/adhesion": "axle-adhesion",
    "axle/*/wear": "axle-wear",
    "alarm/**": "alarm",
    "health": "health",
    "meta": "meta",
}


@cache
def schema(name: str) -> bytes:
    """The JSON Schema (2020-12) of one payload, as a document of its own."""
    (root,), definitions = msgspec.json.schema_components((TYPES[name],), ref_template="#/$defs/{name}")
    for definition in definitions.values():  # docstrings, which Python before 3.13 gives as they are indented
        definition["description"] = cleandoc(definition["description"])
    document: dict[str, Any] = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": name,
        **root,
        "$defs": definitions,
    }
    return msgspec.json.format(msgspec.json.encode(document, order="deterministic"), indent=2) + b"\n"
