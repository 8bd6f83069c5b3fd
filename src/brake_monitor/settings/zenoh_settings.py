"""The [zenoh] and [metrics] tables of the configuration: how the outside world reaches what is published."""

from pathlib import Path
from typing import Annotated, Literal

from msgspec import Meta, Struct


class TlsSettings(Struct, frozen=True, forbid_unknown_fields=True):
    """Certificates for mutual TLS: both sides show one. Paths are absolute after loading."""

    root_ca: Path  # what the other side's certificate must be signed by
    certificate: Path  # our own
    private_key: Path
    verify_names: bool = True  # the certificate of a router must name the host that we connect to

    @property
    def files(self) -> dict[str, Path]:
        """By their keys."""
        return {"root_ca": self.root_ca, "certificate": self.certificate, "private_key": self.private_key}


class ZenohSettings(Struct, frozen=True, forbid_unknown_fields=True):
    """How the outside world reaches what is published."""

    enabled: bool = True
    prefix: str = "brake/v1"
    mode: Literal["peer", "client"] = "peer"
    connect: tuple[str, ...] = ()
    listen: tuple[str, ...] = ("tcp/127.0.0.1:0",)
    encoding: Literal["json", "msgpack"] = "json"
    accept_acknowledgements: bool = False  # whether a remote party may acknowledge alarms
    tls: TlsSettings | None = None


class MetricsSettings(Struct, frozen=True, forbid_unknown_fields=True):
    """Health as OpenMetrics over HTTP, on the loopback interface only; needs the extra `metrics`."""

    port: Annotated[int, Meta(ge=0, le=65535)] = 0  # 0: off
