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

import json
import re
from unicodedata import is_normalized

LONGEST_CHUNK = 100  # characters
_MEANS_SOMETHING = re.compile(r"[/*$?#\s]")  # wildcards, separators


def fault_of(chunk: str) -> str | None:
    """Why this cannot be one part of a key; None when it can."""
    if not chunk:
        return "a part of the Zenoh key is empty"
    if len(chunk) > LONGEST_CHUNK:
        return f"a part of the Zenoh key has more than {LONGEST_CHUNK} characters"
    return _unfit_letter(chunk)


def _unfit_letter(chunk: str) -> str | None:
    if chunk.startswith("@"):
        return 'a part of the Zenoh key begins with "@", which would hide it from every wildcard'
    if illegal := _MEANS_SOMETHING.search(chunk):
        return f"{json.dumps(illegal.group())} cannot stand in a Zenoh key (no / * $ ? # nor white space)"
    unseen = next((char for char in chunk if not char.isprintable()), None)
    if unseen is not None:
        return f"{json.dumps(unseen)} is not printed, and cannot stand in a Zenoh key"
    if not is_normalized("NFC", chunk):  # it would look like what a subscriber types, and not match it
        return f"{json.dumps(chunk)} has letters in parts: expected Unicode in its composed form (NFC)"
    return None


class KeySpace:
    """`<prefix>/<wagon>/…`, of a prefix and an id that a configuration may have."""

    def __init__(self, prefix: str, wagon_id: str) -> None:
        self.wagon = f"{prefix}/{wagon_id}"  # also the key of the liveliness token
        self.everything = f"{self.wagon}/**"
        self.adhesion = f"{self.wagon}/adhesion"
        self.health = f"{self.wagon}/health"
        self.meta = f"{self.wagon}/meta"
        self.acknowledge = f"{self.wagon}/acknowledge"

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

    def below(self, key: str) -> str:
        """What follows the wagon's own key."""
        return key.removeprefix(f"{self.wagon}/")

    def under(self, below: str) -> str:
        """The key of which this follows the wagon's own."""
        return f"{self.wagon}/{below}"

    def schema(self, name: str) -> str:
        """Key of the JSON Schema of a payload."""
        return f"{self.wagon}/schema/{name}"
