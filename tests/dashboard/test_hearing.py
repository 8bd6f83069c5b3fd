"""A daemon that is too busy to answer is asked again, and what it has told before stays known."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from queue import Empty
from threading import Event

import msgspec
import pytest
import zenoh

from brake_monitor.dashboard import hearing
from brake_monitor.dashboard.fleet import Fleet
from brake_monitor.dashboard.hearing import Hearing, Past
from brake_monitor.desk.fleet_listener import ask
from brake_monitor.publishing.encoding import encode
from brake_monitor.publishing.payloads import AlarmMessage
from estimates import alarm
from network import free_port
from program import PATIENCE_S

WAGON = "brake/v1/wagon-1"
OPEN = AlarmMessage.of(alarm(), 1, 1700000001.0)


class BusyDaemon:
    """Knows one open alarm, and refuses its first questions about the past."""

    def __init__(self, refusals: int) -> None:
        self.refusals = refusals
        self.asked_again = Event()

    def answer(self, query: zenoh.Query) -> None:
        if not query.parameters:
            query.reply(f"{WAGON}/alarm/{OPEN.kind}", encode(OPEN, "json"), encoding="application/json")
        elif self.refusals:
            self.refusals -= 1
            query.reply_err("too many questions wait; ask again later")
        elif "limit" in query.parameters:
            query.reply(f"{WAGON}/alarm/{OPEN.kind}", msgspec.json.encode([OPEN]), encoding="application/json")
        else:  # the past is asked for once the alarms are known
            self.asked_again.set()


@contextmanager
def daemon_at(endpoint: str, daemon: BusyDaemon) -> Iterator[None]:
    config = zenoh.Config()
    for key, value in (("mode", "router"), ("listen/endpoints", [endpoint]), ("scouting/multicast/enabled", False)):
        config.insert_json5(key, json.dumps(value))
    with (
        zenoh.open(config) as session,
        session.declare_queryable(f"{WAGON}/**", daemon.answer),
        session.liveliness().declare_token(WAGON),
    ):
        yield


def test_an_alarm_stays_open_while_its_daemon_refuses_to_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hearing, "ASKED_AGAIN_S", 0.1)
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    fleet, daemon = Fleet("brake/v1"), BusyDaemon(refusals=3)
    seen: list[set[str]] = []
    forget = fleet.take_alarms

    def take_alarms(*arguments: object) -> None:
        forget(*arguments)  # type: ignore[arg-type]
        seen.append({alarm.id for alarm in fleet.watched.wagons["wagon-1"].open_alarms()})

    monkeypatch.setattr(fleet, "take_alarms", take_alarms)
    with daemon_at(endpoint, daemon):
        client = zenoh.Config()
        client.insert_json5("mode", '"client"')
        client.insert_json5("connect/endpoints", json.dumps([endpoint]))
        hears = Hearing(fleet, client)
        hears.start()
        assert daemon.asked_again.wait(PATIENCE_S)
        hears.close()
    assert daemon.refusals == 0
    assert seen == [{OPEN.id}]


def test_who_came_often_and_does_not_answer_is_asked_again_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hearing, "ask", lambda *_: None)
    monkeypatch.setattr(hearing, "ASKED_AGAIN_S", 0.0)
    monkeypatch.setattr(hearing, "TURN_S", 0.0)
    fleet = Fleet("brake/v1")
    hears = Hearing(fleet, zenoh.Config())
    fleet.watched.lives(WAGON, True)
    for _ in range(3):
        hears._ask_now(None, "wagon-1")  # type: ignore[arg-type]
    assert hears._next_to_ask() == "wagon-1"
    with pytest.raises(Empty):
        hears._next_to_ask()


def test_who_comes_and_goes_again_and_again_is_asked_for_its_past_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hearing, "ask", lambda *_: 1)
    fleet = Fleet("brake/v1")
    hears = Hearing(fleet, zenoh.Config())
    fleet.watched.lives(WAGON, True)
    for _ in range(3):
        hears._ask_now(None, "wagon-1")  # type: ignore[arg-type]
    assert len(hears._pasts) == 1


def test_a_question_that_cannot_be_put_is_not_answered() -> None:
    """It ends no thread of whoever asks."""
    config = zenoh.Config()
    config.insert_json5("scouting/multicast/enabled", "false")
    session = zenoh.open(config)
    session.close()
    assert ask(session, f"{WAGON}/**", lambda _: None) is None


def test_the_past_of_the_wagon_that_is_looked_at_is_asked_for_first() -> None:
    fleet = Fleet("brake/v1")
    hears = Hearing(fleet, zenoh.Config())
    hears._pasts |= {name: Past(name, None, 1) for name in ("a", "b", "c", "d")}
    asked = []
    for fleet.looked_at in ("c", "none", None, "d"):
        asked.append(hears._next_past().wagon)
    assert asked == ["c", "a", "b", "d"]
    assert not hears._pasts


def test_who_ends_before_anybody_answered_has_not_failed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hearing, "patient_session", lambda *_: None)
    hears = Hearing(Fleet("brake/v1"), zenoh.Config())
    hears._run()
    assert hears.failure is None
