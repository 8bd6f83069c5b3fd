"""The configuration of our Zenoh session: it finds routers when they come, and speaks to nobody else."""

import json
from typing import Any

import zenoh

from brake_monitor.publishing.zenoh_endpoints import EndpointError, check_endpoints, chooses_port
from brake_monitor.settings.zenoh_settings import TlsSettings, ZenohSettings

LEASE_MS = 2500  # after so much silence we count as gone
LARGEST_MESSAGE = 1 << 20  # bytes that we take from outside; everything that we expect is far smaller
BLOCKED_US = 1_000_000  # a neighbour that blocks an event for longer is cut off; it recovers from the cache


def session_config(settings: ZenohSettings, session_id: str | None = None) -> zenoh.Config:
    """A session that opens without a router and finds it when it comes; it neither scouts nor can be administered.

    `session_id` (hexadecimal) stays the same over restarts when given: advanced subscribers then know what they had.
    InputError when `check_endpoints` finds fault or a certificate cannot be read.
    """
    check_endpoints(settings)
    peer = settings.mode == "peer"
    config = zenoh.Config()
    values: dict[str, Any] = {
        "mode": settings.mode,
        "connect/endpoints": settings.connect,
        "connect/timeout_ms": -1 if peer else 0,  # a peer connects later; a client's session needs its router
        "connect/exit_on_failure": False,
        "connect/retry": {"period_init_ms": 100, "period_max_ms": 500, "period_increase_factor": 1.5},
        "listen/endpoints": settings.listen if peer else (),
        "listen/exit_on_failure": True,
        # Gossip stays on: it only uses links that exist, and without it peers behind one router hear nothing.
        "scouting/multicast/enabled": False,
        "scouting/delay": 0,
        # It keeps a file open for each session of a program, that of before a reload too, and 16 MB for each neighbour.
        "transport/shared_memory/enabled": False,
        "timestamping/enabled": True,  # what subscribers order events by
        "transport/link/tx/lease": LEASE_MS,
        "transport/link/rx/max_message_size": LARGEST_MESSAGE,
        "transport/link/tx/queue/congestion_control/block/wait_before_close": BLOCKED_US,
        "adminspace/enabled": chooses_port(settings),  # nothing else about us is worth publishing
        "adminspace/permissions": {"read": True, "write": False},
    }
    if session_id is not None:
        values["id"] = session_id
    if settings.tls is not None:
        values["transport/link/tls"] = _tls(settings.tls)
    for key, value in values.items():
        config.insert_json5(key, json.dumps(value))
    return config


def _tls(tls: TlsSettings) -> dict[str, Any]:
    for name, path in tls.files.items():
        try:
            path.open("rb").close()
        except OSError as error:
            raise EndpointError(f"[zenoh.tls] {name}: {path} cannot be read: {error.strerror}", "tls", name) from None
    certificate, private_key = str(tls.certificate), str(tls.private_key)
    return {
        "root_ca_certificate": str(tls.root_ca),
        "enable_mtls": True,
        "verify_name_on_connect": tls.verify_names,
        "connect_certificate": certificate,
        "connect_private_key": private_key,
        "listen_certificate": certificate,
        "listen_private_key": private_key,
        "close_link_on_expiration": True,
    }


def reason_of(error: zenoh.ZError) -> str:
    """Zenoh's own words without the places in its source code that it adds: `…: [ADDRESS: REASON at /…`."""
    return str(error).partition(" at /")[0].rpartition(": [")[2].strip()
