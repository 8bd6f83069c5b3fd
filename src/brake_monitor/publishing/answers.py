"""What a `get` is answered. Pure: from what has been published and the question's parameters to payloads by key.

Without parameters the newest under every key that the question means. With `from_s` and `to_s` (Unix seconds, either
may be left out) and `limit`, a list of the newest for every key instead, oldest first: estimates captured, and alarms
that were open, in that time. Any other question is refused with a sentence.
"""

from collections import defaultdict
from collections.abc import Iterable, Mapping
from math import inf, isfinite

from msgspec import Struct

from brake_monitor.publishing.encoding import Format, encode
from brake_monitor.publishing.payload_schemas import TYPES, schema
from brake_monitor.publishing.payloads import Message
from brake_monitor.publishing.published import Meant, Payload, Published
from brake_monitor.settings.key_space import KeySpace

MOST_ENTRIES = 1000  # in a list


class QuestionRefusedError(Exception):
    """The question makes no sense or is not allowed; the text says why."""


class TimeRange(Struct, frozen=True):
    """A part of the past."""

    from_s: float = -inf
    to_s: float = inf
    limit: int = MOST_ENTRIES


def time_range(parameters: Mapping[str, str]) -> TimeRange | None:
    """Read the parameters; None when the newest is asked for. Names that begin with _ are Zenoh's own."""
    given = {name: text for name, text in parameters.items() if not name.startswith("_")}
    unknown = given.keys() - {"from_s", "to_s", "limit"}
    if unknown:
        raise QuestionRefusedError(f"unknown parameter {min(unknown)!r:.40}: expected from_s, to_s or limit")
    if not given:
        return None
    limit = given.get("limit", str(MOST_ENTRIES))
    if not (limit.isascii() and limit.isdigit() and len(limit) < 9 and 1 <= int(limit) <= MOST_ENTRIES):
        raise QuestionRefusedError(f"limit: expected a whole number from 1 to {MOST_ENTRIES}, got {limit!r:.40}")
    from_s, to_s = _seconds("from_s", given, -inf), _seconds("to_s", given, inf)
    if from_s > to_s:
        raise QuestionRefusedError(f"from_s: expected no more than to_s, got {from_s:g} and {to_s:g}")
    return TimeRange(from_s, to_s, int(limit))


def _seconds(name: str, given: Mapping[str, str], default: float) -> float:
    if name not in given:
        return default
    try:
        value = float(given[name])
    except ValueError:
        value = float("nan")
    if not isfinite(value):
        raise QuestionRefusedError(f"{name}: expected a number of Unix seconds, got {given[name]!r:.40}")
    return value


class Answerer:
    """Answers for one wagon."""

    def __init__(self, keys: KeySpace, published: Published, encoding: Format) -> None:
        self._keys = keys
        self._published = published
        self._encoding = encoding

    def newest(self, asked: str, meant: Meant) -> Iterable[tuple[str, Payload]]:
        """The newest under every key that is meant; schemas only when the question says `schema`."""
        for key, payload in self._published.current().items():
            if meant(key):
                yield key, payload
        if "schema" in asked.split("/"):
            for name in TYPES:
                if meant(self._keys.schema(name)):
                    yield self._keys.schema(name), Payload("json", schema(name))

    def past(self, meant: Meant, wanted: TimeRange) -> Iterable[tuple[str, Payload]]:
        """A list for every key that is meant and has something in that time."""
        lists: dict[str, list[Message]] = defaultdict(list)
        for key, alarm in self._published.alarms(wanted.from_s, wanted.to_s):
            if meant(key):
                lists[key].append(alarm)
        for entry in self._published.estimates(wanted.from_s, wanted.to_s, wanted.limit):
            for key, message in entry.messages(self._keys, meant):
                lists[key].append(message)
        for key, messages in lists.items():
            yield key, Payload(self._encoding, encode(messages[-wanted.limit :], self._encoding))
