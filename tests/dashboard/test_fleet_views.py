"""What pages are told: the state of wagons in time, only what is new, and nothing of what is hostile."""

import gc
import sys
from typing import Any

import msgspec
import pytest

from brake_monitor.dashboard.fleet import LARGEST_ANSWER, MOST_WAGONS, Fleet
from brake_monitor.dashboard.server import PUSH_S
from brake_monitor.dashboard.views import MOST_LISTED, Viewer
from brake_monitor.desk.foreign_message import LARGEST_PAYLOAD
from brake_monitor.desk.watched import FROZEN_S, LONGEST_NAME
from brake_monitor.monitoring.alarm import Severity
from brake_monitor.publishing.encoding import encode
from brake_monitor.publishing.health import Counters, health_of
from brake_monitor.publishing.payloads import AdhesionMessage, AlarmMessage, FrictionMessage
from brake_monitor.settings.bounds import MOST_WHEELSETS
from estimates import alarm, estimate, wheelset
from health import INTAKE

JSON = "application/json"


def hear(fleet: Fleet, key: str, message: Any, now_s: float = 100.0) -> None:
    fleet.take(f"brake/v1/{key}", JSON, message if isinstance(message, bytes) else encode(message), now_s)


def fleet_of(*names: str) -> Fleet:
    fleet = Fleet("brake/v1")
    for name in names:
        fleet.watched.lives(f"brake/v1/{name}", True)
        hear(fleet, f"{name}/adhesion", AdhesionMessage.of(estimate(), 1, 0.0))
        for i in (1, 2):
            hear(fleet, f"{name}/axle/{i}/friction", FrictionMessage.of(estimate(), i, 1, 0.0))
    return fleet


def news(viewer: Viewer) -> dict[str, Any]:
    told: dict[str, Any] = msgspec.json.decode(viewer.news(100.0))
    return told


def test_the_overview_has_a_line_for_every_wagon() -> None:
    fleet = fleet_of("b", "a")
    hear(fleet, "b/alarm/hot_disc/2", AlarmMessage.of(alarm(kind="hot_disc", wheelset=2), 1, 0.0))
    second, first = news(Viewer(fleet, None))["wagons"]
    assert (first["id"], first["state"], first["speed_mps"], first["adhesion"]) == ("a", "live", 18.0, 0.08)
    assert first["worst"] is None
    assert first["level"] == "low"  # saturated at 0.08
    assert second["alarms"] == {"info": 0, "warning": 0, "alarm": 1}
    assert second["worst"] == {"kind": "hot_disc", "wheelset": 2, "severity": "alarm", "acknowledged": False}


def test_of_more_wagons_than_are_listed_one_with_an_alarm_is_not_left_out() -> None:
    fleet = fleet_of(*(f"a{k:04}" for k in range(MOST_LISTED)), "z")
    assert "z" not in {line["id"] for line in news(Viewer(fleet, None))["wagons"]}
    hear(fleet, "z/alarm/hot_disc/2", AlarmMessage.of(alarm(kind="hot_disc", wheelset=2), 1, 0.0))
    told = news(Viewer(fleet, None))
    assert (told["wagons"][0]["id"], len(told["wagons"]), told["more"]) == ("z", MOST_LISTED, 1)


def test_whether_anybody_ever_answered_is_told() -> None:
    told = news(Viewer(Fleet("brake/v1"), None))
    assert (told["connected"], told["was_connected"], told["heard"]) == (False, False, 0)
    fleet = Fleet("brake/v1")
    told = []
    for is_connected in (False, True, False):
        fleet.note_connection(is_connected=is_connected)
        message = news(Viewer(fleet, None))
        told.append((message["connected"], message["was_connected"]))
    assert told == [(False, False), (True, True), (False, True)]


def test_a_wagon_that_stops_freezes_or_returns_shows_it_within_three_seconds() -> None:
    assert FROZEN_S + max(PUSH_S.values()) < 3.0
    fleet = fleet_of("w")
    wagon = fleet.watched.wagons["w"]
    assert wagon.state(100.0 + FROZEN_S) == "live"
    assert wagon.state(100.0 + FROZEN_S + 0.1) == "frozen"
    hear(fleet, "w/adhesion", AdhesionMessage.of(estimate(), 1, 0.0), now_s=105.0)  # the same again is no sign of life
    assert wagon.state(105.0) == "frozen"
    hear(fleet, "w/adhesion", AdhesionMessage.of(estimate(time_s=1700000001.0), 2, 0.0), now_s=106.0)
    assert wagon.state(106.0) == "live"
    fleet.watched.lives("brake/v1/w", False)
    assert wagon.state(106.0) == "gone"
    assert news(Viewer(fleet, "nobody"))["state"] == "unknown"


def test_a_page_is_told_everything_once_and_then_what_is_new() -> None:
    fleet = fleet_of("w")
    viewer = Viewer(fleet, "w")
    first = news(viewer)
    assert first["rows"]["time_s"] == [1700000000.25]
    assert first["rows"]["anew"]
    assert first["adhesion"]["speed_mps"] == 18.0
    assert first["alarms"] == []
    again = news(viewer)
    assert not {"rows", "adhesion", "alarms", "wear", "names"} & again.keys()
    assert again["state"] == "live"
    later = estimate(time_s=1700000000.35, speed_mps=17.5)
    hear(fleet, "w/adhesion", AdhesionMessage.of(later, 2, 0.0))
    for i in (1, 2):
        hear(fleet, f"w/axle/{i}/friction", FrictionMessage.of(later, i, 2, 0.0))
    then = news(viewer)
    assert (then["rows"]["anew"], then["rows"]["speed_mps"]) == (False, [17.5])


def test_a_page_forgets_what_was_before_a_clock_was_set_back() -> None:
    """At once, not only when the first estimate is there as a whole."""
    fleet = fleet_of("w")
    viewer = Viewer(fleet, "w")
    news(viewer)
    back = estimate(time_s=1700000000.25 - 3600.0)
    hear(fleet, "w/adhesion", AdhesionMessage.of(back, 2, 0.0))
    rows = news(viewer)["rows"]
    assert (rows["anew"], rows["time_s"]) == (True, [])
    for i in (1, 2):
        hear(fleet, f"w/axle/{i}/friction", FrictionMessage.of(back, i, 2, 0.0))
    rows = news(viewer)["rows"]
    assert (rows["anew"], rows["time_s"]) == (False, [back.time_s])


def test_alarms_appear_and_clear_and_one_that_its_daemon_forgot_goes() -> None:
    fleet = fleet_of("w")
    hear(fleet, "w/alarm/low_adhesion", AlarmMessage.of(alarm(), 1, 0.0))
    viewer = Viewer(fleet, "w")
    assert [told["state"] for told in news(viewer)["alarms"]] == ["open"]
    cleared = AlarmMessage.of(alarm(updated_time_s=1700000009.0, cleared_time_s=1700000009.0), 2, 0.0)
    hear(fleet, "w/alarm/low_adhesion", cleared)
    assert [told["state"] for told in news(viewer)["alarms"]] == ["cleared"]
    hear(fleet, "w/alarm/low_adhesion", AlarmMessage.of(alarm(), 1, 0.0))  # an old answer comes late
    assert "alarms" not in news(viewer)
    other = AlarmMessage.of(alarm(id="hot_disc-1", kind="hot_disc", severity=Severity.WARNING), 3, 0.0)
    hear(fleet, "w/alarm/hot_disc", other)
    assert len(news(viewer)["alarms"]) == 2
    newer = AlarmMessage.of(alarm(id="hot_disc-2", kind="hot_disc"), 4, 2.0)
    hear(fleet, "w/alarm/hot_disc", newer)
    told = health_of(INTAKE, Counters(), None, events_waiting=0, uptime_s=1.0, sequence=1, now_s=1.0)
    hear(fleet, "w/health", told)  # published before the newer one
    assert [told["id"] for told in news(viewer)["alarms"]] == [newer.id, cleared.id]


def test_the_past_is_put_before_what_was_heard() -> None:
    fleet = fleet_of("w")
    past = [estimate(time_s=1700000000.25 - k / 10) for k in range(50, 0, -1)]
    answers = [("brake/v1/w/adhesion", JSON, encode([AdhesionMessage.of(e, 1, 0.0) for e in past]))]
    answers += [
        (f"brake/v1/w/axle/{i}/friction", JSON, encode([FrictionMessage.of(e, i, 1, 0.0) for e in past]))
        for i in (1, 2)
    ]
    assert fleet.take_past("w", answers) == past[0].time_s
    never = AdhesionMessage.of(estimate(time_s=-1.0), 1, 0.0)
    assert fleet.take_past("w", [("brake/v1/w/adhesion", JSON, encode([never]))]) is None
    assert fleet.watched.not_understood == 1
    rows = news(Viewer(fleet, "w"))["rows"]
    assert len(rows["time_s"]) == 51
    assert None not in rows["wheelsets"]["2"]["friction"]


def test_an_hour_is_remembered_in_no_more_room_than_its_last_minutes() -> None:
    fleet = fleet_of("w")
    viewers = [Viewer(fleet, None), Viewer(fleet, "w")]

    def pieces_of_memory_after(first: int, end: int) -> int:
        for k in range(first, end):  # ten a second, an alarm every four
            now = estimate(time_s=1700000001.0 + k / 10)
            hear(fleet, "w/adhesion", AdhesionMessage.of(now, k, 0.0), now_s=100.0 + k / 10)
            for i in (1, 2):
                hear(fleet, f"w/axle/{i}/friction", FrictionMessage.of(now, i, k, 0.0))
            if k % 40 == 0:
                hear(fleet, "w/alarm/hot_disc", AlarmMessage.of(alarm(id=f"a{k:06}"), k, 0.0))
            for viewer in viewers:
                viewer.news(100.0 + k / 10)
        gc.collect()
        return sys.getallocatedblocks()

    settled = pieces_of_memory_after(0, 4000)  # five minutes of curves and fifty alarms are there
    assert pieces_of_memory_after(4000, 12_000) < settled + 200  # one for forty estimates would be as many


HOSTILE = {
    "no JSON": b"<script>alert(1)</script>",
    "another type": b'{"adhesion": "0.1"}',
    "NaN": encode(AdhesionMessage.of(estimate(), 1, 0.0)).replace(b"18.0", b"NaN"),
    "deep": b"[" * 50_000,
    "a megabyte": encode(AdhesionMessage.of(estimate(reasons=("x" * 1_000_000,)), 1, 0.0)),
    "long text": encode(AdhesionMessage.of(estimate(reasons=("x" * 5000,)), 1, 0.0)),
    "control characters": encode(AdhesionMessage.of(estimate(reasons=("\x1b[2J",)), 1, 0.0)),
    "a time that is none": encode(AdhesionMessage.of(estimate(time_s=1e300), 1, 0.0)),
    "a time before all": encode(AdhesionMessage.of(estimate(time_s=-1.0), 1, 0.0)),
}


@pytest.mark.parametrize("payload", HOSTILE.values(), ids=HOSTILE)
def test_what_is_hostile_is_counted_and_changes_nothing(payload: bytes) -> None:
    assert len(HOSTILE["a megabyte"]) > LARGEST_PAYLOAD
    fleet = fleet_of("w")
    before = news(Viewer(fleet, "w"))
    hear(fleet, "w/adhesion", payload)
    after = news(Viewer(fleet, "w"))
    assert (before.pop("not_understood"), after.pop("not_understood")) == (0, 1)
    assert after.pop("heard") == before.pop("heard") + 1
    assert after == before


@pytest.mark.parametrize("name", ["x" * (LONGEST_NAME + 1), "\x1b[2J", ""])
def test_a_name_that_is_none_makes_no_wagon(name: str) -> None:
    fleet = fleet_of("w")
    hear(fleet, f"{name}/adhesion", AdhesionMessage.of(estimate(), 1, 0.0))
    fleet.watched.lives(f"brake/v1/{name}", True)
    assert list(fleet.watched.wagons) == ["w"]


def test_what_it_remembers_is_bounded_whoever_publishes() -> None:
    fleet = fleet_of("w")
    far = estimate(wheelsets=(wheelset(),) * (MOST_WHEELSETS + 1))
    hear(fleet, "w/axle/33/friction", FrictionMessage.of(far, MOST_WHEELSETS + 1, 1, 0.0))
    assert fleet.recent["w"].wheelsets == [1, 2]
    for k in range(MOST_WAGONS + 20):
        hear(fleet, f"x{k}/adhesion", AdhesionMessage.of(estimate(), 1, 0.0))
    assert len(fleet.recent) == MOST_WAGONS
    for k in range(500):
        hear(fleet, "w/alarm/hot_disc", AlarmMessage.of(alarm(id=f"a{k}"), 1, 0.0))
    assert len(fleet.watched.wagons["w"].alarms) <= 50
    understood = fleet.watched.not_understood
    assert fleet.take_past("w", [("brake/v1/w/adhesion", JSON, b" " * (LARGEST_ANSWER + 1))]) is None
    assert fleet.watched.not_understood == understood + 1
