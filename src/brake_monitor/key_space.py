"""Every key of one wagon, made here and nowhere else. Wheelsets count from 1.

| key                                     | what                                          | how                      |
|-----------------------------------------|-----------------------------------------------|--------------------------|
| `<prefix>/<wagon>`                      | the daemon lives                              | liveliness token         |
| `<prefix>/<wagon>/adhesion`             | the wagon's estimate                          | state: newest wins       |
| `<prefix>/<wagon>/axle/<i>/friction`    | a wheelset and its brake                      | state                    |
| `<prefix>/<wagon>/axle/<i>/adhesion`    | what a wheelset uses of the rail              | state                    |
| `<prefix>/<wagon>/axle/<i>/wear`        | its pads, after each brake application        | event: none is lost      |
| `<prefix>/<wagon>/alarm/<kind>[/<i>]`   | an alarm at each change                       | event                    |
| `<prefix>/<wagon>/health`               | how the daemon does, once a second            | state                    |
| `<prefix>/<wagon>/meta`                 | what is published, in which units, from what  | state                    |
| `<prefix>/<wagon>/schema/<name>`        | the JSON Schema of a payload                  | answers a `get` only     |
| `<prefix>/<wagon>/acknowledge`          | acknowledges an alarm, where that is allowed  | answers a `get` only     |
"""

import re

from brake_monitor.errors import InputError

_NOT_IN_CHUNK = re.compile(r"[/*$?#\s\x00-\x1f]")  # wildcards, separators and what is not printed


class KeySpace:
    """`<prefix>/<wagon>/…`. InputError when the prefix or the wagon's id cannot stand in a Zenoh key."""

    def __init__(self, prefix: str, wagon_id: str) -> None:
        for chunk in prefix.split("/"):
            _check_chunk(chunk, f"[zenoh] prefix {prefix!r}")
        _check_chunk(wagon_id, f"[vehicle] id {wagon_id!r}")
        self.wagon = f"{prefix}/{wagon_id}"  # also the key of the liveliness token
        self.everything = f"{self.wagon}/**"
        self.adhesion = f"{self.wagon}/adhesion"
        self.health = f"{self.wagon}/health"
        self.meta = f"{self.wagon}/meta"
        self.acknowledge = f"{self.wagon}/acknowledge"
        self.alarms = f"{self.wagon}/alarm/**"

    def friction(self, wheelset: int) -> str:
        """Key of the pad friction of one wheelset."""
        return f"{self.wagon}/axle/{wheelset}/friction"

    def axle_adhesion(self, wheelset: int) -> str:
        """Key of the adhesion that one wheelset uses."""
        return f"{self.wagon}/axle/{wheelset}/adhesion"

    def wear(self, wheelset: int) -> str:
        """Key of the pads of one wheelset."""
        return f"{self.wagon}/axle/{wheelset}/wear"

    def alarm(self, kind: str, wheelset: int | None) -> str:
        """Key of an alarm; None when it concerns the wagon."""
        return f"{self.wagon}/alarm/{kind}" + ("" if wheelset is None else f"/{wheelset}")

    def schema(self, name: str) -> str:
        """Key of the JSON Schema of a payload."""
        return f"{self.wagon}/schema/{name}"


def _check_chunk(chunk: str, where: str) -> None:
    # A chunk that begins with @ would be hidden from every wildcard subscription.
    if not chunk or chunk.startswith("@") or _NOT_IN_CHUNK.search(chunk):
        raise InputError(f"{where}: expected a name that can stand in a Zenoh key (no / * $ ? # nor white space)")
