"""The [store] table of the configuration: what outlives the daemon."""

from pathlib import Path
from typing import Annotated

from msgspec import Meta, Struct

from brake_monitor.settings.bounds import NonNegative

MOST_EVIDENCE_S = 450.0  # before and after an alarm together: so much is always at hand


class StoreSettings(Struct, frozen=True, forbid_unknown_fields=True):
    """Where the daemon keeps its memory, and how much evidence of alarms."""

    enabled: bool = True
    directory: Path | None = None  # relative to the configuration file; else systemd's $STATE_DIRECTORY, else none
    evidence_before_s: NonNegative = 120.0  # a stop from 120 km/h, and what led to it
    evidence_after_s: NonNegative = 10.0
    evidence_max_bytes: Annotated[int, Meta(ge=0)] = 200_000_000
