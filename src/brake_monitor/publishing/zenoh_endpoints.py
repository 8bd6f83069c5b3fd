"""Where Zenoh sessions connect to and listen: whether that makes sense, who reaches it, how it is shown."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from ipaddress import ip_address
from pathlib import Path

import zenoh

from brake_monitor.errors import InputError
from brake_monitor.settings.config_text import place_of
from brake_monitor.settings.zenoh_settings import ZenohSettings

_PROTOCOLS = ("tcp", "udp", "tls", "quic", "ws")
_ENCRYPTED = ("tls", "quic")


class EndpointError(InputError):
    """An endpoint is refused; `key` is where it stands in the configuration."""

    def __init__(self, sentence: str, *key: str | int) -> None:
        super().__init__(sentence)
        self.key = ("zenoh", *key)


@contextmanager
def naming_endpoints(path: Path) -> Iterator[None]:
    """Put the place in the configuration file before what is wrong with an endpoint."""
    try:
        yield
    except EndpointError as error:
        raise InputError(f"{place_of(path, error.key)}: {error}") from None


def check_endpoints(settings: ZenohSettings) -> None:
    """InputError when an endpoint is malformed or missing, or unencrypted where certificates are configured."""
    for name, endpoints in (("connect", settings.connect), ("listen", settings.listen)):
        for place, endpoint in enumerate(endpoints):
            fault = endpoint_fault(endpoint)
            if not fault and settings.tls is not None and not endpoint.startswith(_ENCRYPTED):
                fault = "with [zenoh.tls] expected tls/… or quic/…"
            if fault:
                raise EndpointError(f"[zenoh] {name} {shown(endpoint)!r}: {fault}", name, place)
    if settings.mode == "client" and not settings.connect:
        raise EndpointError(
            "[zenoh] connect: a client needs the endpoint of a router, such as tcp/192.0.2.1:7447", "connect"
        )


def unprotected(settings: ZenohSettings) -> Iterator[str]:
    """Remarks on endpoints that other machines reach or need, and that no certificate protects."""
    if settings.tls is not None or not settings.enabled:
        return
    listen = settings.listen if settings.mode == "peer" else ()
    for endpoint in (*settings.connect, *listen):
        if endpoint.startswith(_ENCRYPTED):
            yield f"zenoh: {shown(endpoint)} needs certificates, and there is no [zenoh.tls]"
    for endpoint in listen:
        protocol, host, _ = _parts(endpoint)
        if protocol not in _ENCRYPTED and not is_loopback(host):
            yield f"zenoh.listen: {shown(endpoint)} lets everybody in who reaches it, see docs/security"


def is_loopback(host: str) -> bool:
    """Whether only this machine reaches what listens there; a host as it is written in an address."""
    try:
        return ip_address(host.strip("[]")).is_loopback
    except ValueError:  # a name
        return host == "localhost"


def chooses_port(settings: ZenohSettings) -> bool:
    """Whether some port that is listened on is only known once it is."""
    return settings.mode == "peer" and any(_parts(endpoint)[2] == "0" for endpoint in settings.listen)


def endpoint_fault(endpoint: str) -> str:
    """What is wrong with an endpoint; nothing, when it is well-formed."""
    protocol, host, port = _parts(endpoint)
    is_port = port.isascii() and port.isdigit() and len(port) <= 5 and int(port) < 2**16
    if protocol not in _PROTOCOLS or not host or not is_port:
        return f"expected <protocol>/<host>:<port> with {', '.join(_PROTOCOLS)}, such as tcp/192.0.2.1:7447"
    try:
        zenoh.Config().insert_json5("connect/endpoints", json.dumps([endpoint]))
    except zenoh.ZError:  # its message shows the whole endpoint
        return "expected ?<name>=<value>;… and #<name>=<value>;… behind the address, or nothing"
    return ""


def _parts(endpoint: str) -> tuple[str, str, str]:
    """Protocol, host and port, as they are written."""
    protocol, _, address = shown(endpoint).partition("/")
    host, _, port = address.rpartition(":")
    return protocol, host, port


def shown(endpoint: str) -> str:
    """Without what may be configured behind the address: a private key may be among it."""
    return endpoint.partition("?")[0].partition("#")[0]


def endpoints_of(settings: ZenohSettings) -> str:
    """The endpoints that the session connects to or listens on, as words for a message."""
    listen, connect = (", ".join(map(shown, endpoints)) for endpoints in (settings.listen, settings.connect))
    if settings.mode == "client":
        return f"with the router at {connect}"
    return " and ".join(part for part in (listen and f"on {listen}", connect and f"to {connect}") if part)
