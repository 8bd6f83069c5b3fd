"""What a `get` is answered, what is refused, and who may acknowledge an alarm."""

import json
from typing import Any

import msgspec
import pytest
import zenoh

from brake_monitor.processing.at_hand import ENTRIES_IN_BLOCK
from brake_monitor.processing.pipeline import Outputs
from brake_monitor.publishing.answers import MOST_ENTRIES, Answerer, QuestionRefusedError, TimeRange, time_range
from brake_monitor.publishing.encoding import encode
from brake_monitor.publishing.handover import ACKNOWLEDGEMENTS_WAITING
from brake_monitor.publishing.payload_schemas import TYPES
from brake_monitor.publishing.payloads import LONGEST_REQUEST, AlarmMessage
from brake_monitor.publishing.published import ALARMS_KEPT, ESTIMATES_KEPT, Payload, Published, PublishedEstimate
from brake_monitor.settings.key_space import KeySpace
from brake_monitor.settings.zenoh_settings import ZenohSettings
from estimates import alarm, estimate
from network import running, session
from program import PATIENCE_S, until

KEYS = KeySpace("brake/v1", "wagon-1")


def published() -> Published:
    """An estimate a second from 0 to 9 s, an alarm from 1 to 3 s, and one that is open since 5 s."""
    found = Published()
    for second in range(10):
        found.add(PublishedEstimate(estimate(time_s=float(second)), second + 1, second + 0.1))
    over = alarm(id="a", raised_time_s=1.0, cleared_time_s=3.0)
    still = alarm(id="b", kind="hot_disc", wheelset=2, raised_time_s=5.0)
    for sequence, one in enumerate((over, still), 1):
        found.add_alarm(KEYS.alarm(one.kind, one.wheelset), AlarmMessage.of(one, sequence, 0.0))
    return found


def lists(meant: str, wanted: TimeRange) -> dict[str, list[dict[str, Any]]]:
    answers = Answerer(KEYS, published(), "json").past(zenoh.KeyExpr(meant).intersects, wanted)
    return {key.removeprefix("brake/v1/wagon-1/"): json.loads(payload.content) for key, payload in answers}


def test_estimates_of_a_range_come_as_one_list_for_every_key_oldest_first() -> None:
    found = lists("brake/v1/wagon-1/axle/*/friction", TimeRange(2.0, 4.0))
    assert found.keys() == {"axle/1/friction", "axle/2/friction"}
    assert [(entry["time_s"], entry["sequence"]) for entry in found["axle/2/friction"]] == [(2, 3), (3, 4), (4, 5)]


def test_a_limit_leaves_the_newest() -> None:
    assert [entry["time_s"] for entry in lists("**/wagon-1/adhesion", TimeRange(limit=3))["adhesion"]] == [7, 8, 9]


@pytest.mark.parametrize(
    ("from_s", "to_s", "ids"),
    [(0, 0.5, []), (0, 1, ["a"]), (3, 4, ["a"]), (3.5, 4, []), (2, 5, ["a", "b"]), (99, 100, ["b"])],
)
def test_alarms_of_a_range_are_those_that_were_open_in_it(from_s: float, to_s: float, ids: list[str]) -> None:
    found = lists("brake/v1/*/alarm/**", TimeRange(from_s, to_s))
    assert sorted(entry["id"] for entries in found.values() for entry in entries) == ids


def test_a_limit_is_of_each_key_by_itself() -> None:
    """The newest alarm of a kind is found however many of other kinds came since."""
    found = lists("**/alarm/**", TimeRange(limit=1))
    assert {key: [entry["id"] for entry in entries] for key, entries in found.items()} == {
        "alarm/low_adhesion": ["a"],
        "alarm/hot_disc/2": ["b"],
    }


def test_what_is_kept_is_bounded() -> None:
    found = Published()
    for number in range(max(ESTIMATES_KEPT, ALARMS_KEPT) + 10):
        found.add(PublishedEstimate(estimate(time_s=float(number)), number, 0.0))
        found.add_alarm("k", AlarmMessage.of(alarm(id=str(number), raised_time_s=float(number)), number, 0.0))
    estimates = found.estimates(0.0, 1e9, 10**9)
    assert ESTIMATES_KEPT <= len(estimates) < ESTIMATES_KEPT + ENTRIES_IN_BLOCK
    assert [entry.sequence for entry in estimates[-2:]] == [ESTIMATES_KEPT + 8, ESTIMATES_KEPT + 9]
    kept = found.alarms(0.0, 1e9)
    assert (len(kept), kept[-1][1].id) == (ALARMS_KEPT, str(max(ESTIMATES_KEPT, ALARMS_KEPT) + 9))


def test_an_open_alarm_is_not_forgotten_for_a_thousand_that_are_over() -> None:
    found = Published()
    found.add_alarm("k", AlarmMessage.of(alarm(id="open"), 1, 0.0))
    for number in range(2 * ALARMS_KEPT):
        found.add_alarm("k", AlarmMessage.of(alarm(id=str(number), cleared_time_s=1.7e9), 2, 0.0))
    assert [*found.open_alarms()] == ["open"]
    assert len(found.alarms(0.0, 1e12)) == ALARMS_KEPT


@pytest.mark.parametrize(
    ("given", "wanted"),
    [
        ({}, None),
        ({"_anyke": ""}, None),  # Zenoh's own
        ({"from_s": "1.5"}, TimeRange(from_s=1.5)),
        ({"from_s": "1", "to_s": "2", "limit": "10"}, TimeRange(1.0, 2.0, 10)),
        ({"limit": str(MOST_ENTRIES)}, TimeRange(limit=MOST_ENTRIES)),
    ],
)
def test_parameters(given: dict[str, str], wanted: TimeRange | None) -> None:
    assert time_range(given) == wanted


@pytest.mark.parametrize(
    "given",
    [
        {"from_s": "yesterday"}, {"from_s": "nan"}, {"from_s": "inf"}, {"to_s": ""},
        {"limit": "0"}, {"limit": "-1"}, {"limit": "1e3"},
        {"limit": str(MOST_ENTRIES + 1)}, {"limit": "9" * 400}, {"limit": "²"}, {"since": "1"},
        {"from_s": "1", "x": ""}, {"from_s": "5", "to_s": "1"},
    ],
)  # fmt: skip
def test_parameters_that_make_no_sense_are_refused_by_name(given: dict[str, str]) -> None:
    with pytest.raises(QuestionRefusedError, match=r"from_s|to_s|limit"):
        time_range(given)


def test_schemas_are_answered_to_who_asks_for_them() -> None:
    answerer = Answerer(KEYS, Published(), "msgpack")

    def keys(asked: str) -> list[str]:
        return [key for key, _ in answerer.newest(asked, zenoh.KeyExpr(asked).intersects)]

    assert keys("brake/v1/wagon-1/**") == []  # they are no news
    assert keys("brake/v1/wagon-1/schema/*") == [KEYS.schema(name) for name in TYPES]
    ((key, payload),) = answerer.newest(KEYS.schema("alarm"), zenoh.KeyExpr(KEYS.schema("alarm")).intersects)
    assert (key, payload.encoding) == ("brake/v1/wagon-1/schema/alarm", "json")
    assert json.loads(payload.content)["title"] == "alarm"


def ask(other: zenoh.Session, key: str, payload: bytes | None = None, **more: Any) -> tuple[list[Any], list[str]]:
    """Answers decoded, and refusals."""
    replies = list(other.get(key, payload=payload, timeout=PATIENCE_S, **more))
    answers = [msgspec.json.decode(reply.ok.payload.to_bytes()) for reply in replies if reply.ok]
    return answers, [reply.err.payload.to_string() for reply in replies if reply.err]


def test_over_zenoh_a_range_is_answered_and_nonsense_refused_with_a_sentence() -> None:
    with running() as publisher, session(publisher.endpoints[0]) as other:
        publisher.publish(Outputs(estimate(time_s=100.0), (alarm(),)))
        until(lambda: publisher.counters.estimates_sent)
        ((answer,), refused) = ask(other, "brake/v1/wagon-1/adhesion?from_s=99;to_s=101")
        assert ([entry["time_s"] for entry in answer], refused) == ([100.0], [])
        assert ask(other, "brake/v1/wagon-1/adhesion?to_s=99") == ([], [])
        answers, (sentence,) = ask(other, "brake/v1/wagon-1/**?from=99")
        assert (answers, sentence) == ([], "unknown parameter 'from': expected from_s, to_s or limit")
        answers, (sentence,) = ask(other, f"brake/v1/wagon-1/**?from_s={'1' * LONGEST_REQUEST}")
        assert sentence == f"expected parameters of at most {LONGEST_REQUEST} bytes"
        assert (publisher.counters.queries_answered, publisher.counters.queries_refused) == (2, 2)


def test_an_alarm_is_acknowledged_where_the_configuration_allows_it() -> None:
    key = "brake/v1/wagon-1/acknowledge"
    open_alarm, closed = alarm(id="open one"), alarm(id="closed one", kind="hot_disc", cleared_time_s=1.7e9)
    with (
        running(ZenohSettings(accept_acknowledgements=True)) as publisher,
        session(publisher.endpoints[0]) as other,
    ):
        publisher.publish(Outputs(None, (open_alarm, closed)))
        until(lambda: publisher.counters.events_sent == 2)
        assert ask(other, key, b'{"id": "open one"}') == ([{"id": "open one", "accepted": True}], [])
        packed = msgspec.msgpack.encode({"id": "open one"})
        (reply,) = other.get(key, payload=packed, encoding="application/msgpack", timeout=PATIENCE_S)
        assert reply.ok is not None
        assert msgspec.msgpack.decode(reply.ok.payload.to_bytes())["accepted"] is True
        for payload, why in (
            (b'{"id": "closed one"}', "no open alarm has this id"),
            (b'{"id": "none such"}', "no open alarm has this id"),
            (b'{"id": ""}', "not understood"),
            (b'{"id": "open one", "severity": "info"}', "not understood"),
            (b'{"id": 7}', "not understood"),
            (b"\xff\xfe", "not understood"),
            (b"[" * 1000, "not understood"),
            (b" " * (LONGEST_REQUEST + 1), "at most"),
            (None, "expected a payload"),
        ):
            answers, (sentence,) = ask(other, key, payload)
            assert not answers
            assert why in sentence
        for wild in ("brake/v1/*/acknowledge", "brake/v1/wagon-1/**"):
            refusal = f"expected {key}: one wagon's alarm, no wild cards"
            assert ask(other, wild, b'{"id": "open one"}') == ([], [refusal])
        assert publisher.acknowledged() == ["open one", "open one"]
        assert publisher.acknowledged() == []
        for _ in range(ACKNOWLEDGEMENTS_WAITING):
            ask(other, key, b'{"id": "open one"}')
        assert ask(other, key, b'{"id": "open one"}')[1] == ["too many acknowledgements wait; try again later"]


def test_nobody_acknowledges_unless_the_configuration_says_so_and_a_put_never_does() -> None:
    with running() as publisher, session(publisher.endpoints[0]) as other:
        publisher.publish(Outputs(None, (alarm(id="open one"),)))
        until(lambda: publisher.counters.events_sent)
        _, (sentence,) = ask(other, "brake/v1/wagon-1/acknowledge", b'{"id": "open one"}')
        assert sentence == "the configuration does not let alarms be acknowledged from here"
        other.put("brake/v1/wagon-1/acknowledge", b'{"id": "open one"}')
        other.put("brake/v1/wagon-1/alarm/low_adhesion", b"{}")
        other.delete("brake/v1/wagon-1/alarm/low_adhesion")
        ((told,), _) = ask(other, "brake/v1/wagon-1/alarm/**")
        assert (told["id"], publisher.acknowledged()) == ("open one", [])


def test_a_flood_of_questions_neither_holds_up_nor_is_lost_silently() -> None:
    with running() as publisher, session(publisher.endpoints[0]) as other:
        for second in range(1000):
            publisher._published.add(PublishedEstimate(estimate(time_s=float(second)), second + 1, 0.0))
        pending = [other.get("brake/v1/wagon-1/**?from_s=0", timeout=10.0 * PATIENCE_S) for _ in range(200)]
        publisher.publish(Outputs(None, (alarm(),)))
        until(lambda: publisher.counters.events_sent)  # meanwhile
        told = [reply for replies in pending for reply in replies]
        refused = [reply.err.payload.to_string() for reply in told if reply.err]
    assert set(refused) <= {"too many questions wait; ask again later"}
    answers = sum(str(reply.ok.key_expr).endswith("wagon-1/adhesion") for reply in told if reply.ok)
    assert answers == 200 - len(refused)  # each question has its answer or its refusal


def test_payloads_are_encoded_as_they_are_declared() -> None:
    message = AlarmMessage.of(alarm(evidence={"a": float("nan"), "b": 1.5, "c": "x"}), 1, 2.0)
    as_json, packed = json.loads(encode(message)), msgspec.msgpack.decode(encode(message, "msgpack"))
    assert as_json == packed
    assert as_json["evidence"] == {"a": None, "b": 1.5, "c": "x"}
    assert Payload("json", b"").encoding == "json"
