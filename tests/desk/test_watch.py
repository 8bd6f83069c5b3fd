"""The live view of a fleet: what it knows, what it shows in 80 columns, and that it runs beside a real publisher."""

import fcntl
import json
import os
import pty
import re
import select
import signal
import struct
import subprocess
import sys
import termios
from io import StringIO
from math import isfinite
from typing import Any

import pytest
from msgspec.structs import replace
from rich.console import Console

from brake_monitor.cli import main
from brake_monitor.desk.foreign_message import LARGEST_PAYLOAD
from brake_monitor.desk.watched import FROZEN_S, Watched
from brake_monitor.desk.watched_lines import not_heard, plain_alarm, plain_line
from brake_monitor.desk.watched_panel import panel
from brake_monitor.estimation.estimate import Status
from brake_monitor.monitoring.alarm import Severity
from brake_monitor.monitoring.brake_units.brakes import Brakes
from brake_monitor.processing.pipeline import Outputs
from brake_monitor.publishing.about import about
from brake_monitor.publishing.encoding import encode
from brake_monitor.publishing.health import Counters, health_of
from brake_monitor.publishing.payloads import AdhesionMessage, AlarmMessage, FrictionMessage, WearMessage
from brake_monitor.samples import Quantity
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.settings.wear_settings import WearSettings
from brake_monitor.settings.zenoh_settings import ZenohSettings
from estimates import alarm, estimate, wheelset
from health import INTAKE
from network import running
from program import Program, until

JSON = "application/json"


def hear(watched: Watched, key: str, message: Any, now_s: float = 100.0, format: Any = "json") -> None:
    watched.take(f"brake/v1/{key}", f"application/{format}", encode(message, format), now_s)


def fleet(count: int) -> Watched:
    watched = Watched("brake/v1")
    for number in range(count):
        name = f"wagon-{number:03}"
        watched.lives(f"brake/v1/{name}", True)
        hear(watched, f"{name}/adhesion", AdhesionMessage.of(estimate(), 1, 0.0))
        for i in (1, 2):
            hear(watched, f"{name}/axle/{i}/friction", FrictionMessage.of(estimate(), i, 1, 0.0))
    return watched


def drawn(watched: Watched, now_s: float = 100.0, only: str | None = None, height: int = 24, width: int = 80) -> str:
    console = Console(width=width, height=height, record=True, file=StringIO())
    console.print(panel(watched, now_s, width, height, only))
    text = console.export_text()
    assert max(len(line) for line in text.splitlines()) <= width
    return text


def test_one_wagon_is_shown_in_full() -> None:
    watched = fleet(1)
    hear(watched, "wagon-000/meta", about(example_settings("wagon"), 0.0))
    worn = WearMessage.of(Brakes.new(2, WearSettings()), 2, WearSettings(), 1, 0.0)
    hear(watched, "wagon-000/axle/2/wear", replace(worn, thickness_mm=31.2))
    hear(watched, "wagon-000/alarm/hot_disc/2", AlarmMessage.of(alarm(kind="hot_disc", wheelset=2), 1, 0.0))
    text = drawn(watched)
    for part in ("wagon-000", "live   64.8 km/h   valid", "0.080 ±0.003  the rail gives no more", "0.010 m/s²"):
        assert part in text
    assert "ALARM  hot disc wheelset 2: The rail gives 0.03." in text
    first, second = rows_of(text)
    # 2 % of slip at 64.8 km/h are 63.5 km/h, whatever the radius; 35 mm, of which nobody told, are not made up
    assert re.search(r"│ 1  63\.5 +2\.0 % +41\.0 kN +0\.090 ±0\.004 +0\.340 ±0\.010 valid +│$", first)
    assert re.search(r"│ 2  63\.5 +2\.0 % +41\.0 kN +0\.090 ±0\.004 +0\.310 ±0\.010 held +WSP +31\.2 +│$", second)


def rows_of(text: str) -> list[str]:
    """The lines of the wheelsets' table."""
    return [line for line in text.splitlines() if re.match(r"│ +\d+ .*±", line)]


def test_wheel_speeds_are_not_made_up_where_no_radius_was_told() -> None:
    watched = fleet(1)
    hear(watched, "wagon-000/adhesion", AdhesionMessage.of(estimate(speed_mps=0.5), 2, 0.0))  # slip has no meaning
    assert all(re.match(r"│ . +– ", row) for row in rows_of(drawn(watched)))
    hear(watched, "wagon-000/meta", replace(about(example_settings("wagon"), 0.0), wheel_radius_m=(0.445,)))
    first, second = rows_of(drawn(watched))
    assert re.match(r"│ 1  64\.1 ", first)  # 40 rad/s
    assert re.match(r"│ 2 +– ", second)


def test_many_wheelsets_leave_room_for_alarms() -> None:
    told = estimate(wheelsets=(wheelset(),) * 16)
    watched = fleet(1)
    for i in range(1, 17):
        hear(watched, f"wagon-000/axle/{i}/friction", FrictionMessage.of(told, i, 2, 0.0))
    hear(watched, "wagon-000/alarm/hot_disc/2", AlarmMessage.of(alarm(kind="hot_disc", wheelset=2), 1, 0.0))
    lines = drawn(watched, height=24).splitlines()
    assert len(lines) < 24
    shown = len(rows_of("\n".join(lines)))
    assert [line for line in lines if f"… and {16 - shown} more wheelsets" in line]
    assert [line for line in lines if "hot disc wheelset 2" in line]
    assert len(rows_of(drawn(watched, height=40))) == 16


@pytest.mark.parametrize("wheelsets", [1, 4])
@pytest.mark.parametrize("status", list(Status))
def test_nothing_is_cut_off_at_80_columns(wheelsets: int, status: Status) -> None:
    axle = wheelset(
        friction_status=status,
        wsp_active=True,
        slip=-0.999,
        adhesion=-0.123,
        omega_radps=100.0,
        pressing_force_n=99999.0,
    )
    told = estimate(wheelsets=(axle,) * wheelsets, status=status)
    watched = fleet(0)
    hear(watched, "w/adhesion", AdhesionMessage.of(told, 1, 0.0))
    for i in range(1, wheelsets + 1):
        hear(watched, f"w/axle/{i}/friction", FrictionMessage.of(told, i, 1, 0.0))
    rows = rows_of(drawn(watched))
    assert len(rows) == wheelsets
    assert all("…" not in row and f"0.340 ±0.010 {status}" in row and "-0.123" in row and "WSP" in row for row in rows)


@pytest.mark.parametrize(
    ("width", "kept"), [(44, "2.0 %"), (60, "2.0 % 41.0 kN"), (80, "2.0 % 41.0 kN"), (104, "2.0 % ▊ 41.0 kN ████▌")]
)
def test_a_narrow_terminal_keeps_friction_and_status_and_cuts_nothing(width: int, kept: str) -> None:
    text = drawn(fleet(1), width=width)
    first, second = rows_of(text)
    assert kept in words(first)
    assert "0.340 ±0.010 valid" in first
    assert re.search(r"0\.310 ±0\.010 held +WSP", second)
    assert width < 60 or "…" not in text


def test_colour_speaks_of_the_rail_only_when_the_wheels_got_all_there_was() -> None:
    watched = fleet(1)
    steps = ((0.03, False), (0.3, False), (0.03, True), (0.07, True), (0.2, True))
    seen = []
    for adhesion, saturated in steps:
        told = estimate(adhesion=adhesion, saturated=saturated)
        hear(watched, "wagon-000/adhesion", AdhesionMessage.of(told, 1, 0.0))
        seen += styles_of(watched, f"{adhesion:.3f} ±")
    assert seen == ["cyan", "cyan", "bold red", "yellow", "green"]


def test_an_alarm_that_is_over_stands_below_those_that_are_open() -> None:
    watched = alarmed(1)
    for k in range(7):
        over = alarm(id=f"over-{k}", raised_time_s=100.0 + k, cleared_time_s=102.5 + k, message=f"Over {k}.")
        hear(watched, "wagon-000/alarm/low_adhesion", AlarmMessage.of(over, 1, 0.0))
    told = drawn(watched).split("ALARM")[1]
    assert re.findall(r"cleared low adhesion, lasted 2.5 s: Over (\d)", told) == ["6", "5", "4", "3"]


SENTENCE = (
    "Wheelset 2 slid 12 m across the rail, nearly stopped for 11 m of them: look for flats before it goes on. Done"
)


def alarmed(count: int) -> Watched:
    watched = fleet(1)
    for k in range(count):
        told = alarm(id=f"a{k}", kind="slide", wheelset=2, raised_time_s=1700000000.0 - k, message=f"{SENTENCE} {k}.")
        hear(watched, f"wagon-000/alarm/slide/{k}", AlarmMessage.of(told, k, 0.0))
    return watched


def words(text: str) -> str:
    return " ".join(text.replace("│", " ").split())


@pytest.mark.parametrize("wagons", [0, 1, 3])
def test_hardly_any_room_is_no_failure(wagons: int) -> None:
    """A window that was drawn small; rich itself needs two columns for a frame."""
    for width in range(2, 45):
        for height in (1, 5, 24):
            drawn(fleet(wagons), width=width, height=height)


def test_an_estimate_that_says_that_it_is_invalid_is_a_gap_and_says_nothing_of_the_rail() -> None:
    """As in the curves of the dashboard. What it has for a value may be anything."""
    watched = fleet(1)
    (wagon,) = watched.wagons.values()
    assert wagon.level == "low"
    told = estimate(time_s=1700000001.0, status=Status.INVALID, adhesion=0.01, saturated=True)
    hear(watched, f"{wagon.name}/adhesion", AdhesionMessage.of(told, 2, 0.0), now_s=101.0)
    assert wagon.level is None
    assert [moment and isfinite(moment.adhesion) for moment in wagon.history] == [True, False]
    again = AdhesionMessage.of(estimate(time_s=1700000001.1, saturated=True), 3, 0.0)
    hear(watched, f"{wagon.name}/adhesion", again, now_s=101.1)  # within the same second
    assert [moment and isfinite(moment.adhesion) for moment in wagon.history] == [True, True]


@pytest.mark.parametrize(("width", "told"), [(80, "last 56 s"), (200, "last 120 s")])
def test_a_wide_terminal_does_not_tell_of_more_time_than_is_remembered(width: int, told: str) -> None:
    assert told in drawn(fleet(1), width=width)


@pytest.mark.parametrize("width", [60, 100])
def test_what_an_alarm_says_is_wrapped_where_lines_are_free(width: int) -> None:
    text = drawn(alarmed(2), width=width)
    assert all(f"{SENTENCE} {k}." in words(text) for k in range(2))


@pytest.mark.parametrize("count", [3, 8, 30])
@pytest.mark.parametrize("height", [16, 24])
def test_each_alarm_has_a_line_before_any_has_two_and_what_has_none_is_counted(count: int, height: int) -> None:
    text = drawn(alarmed(count), height=height)
    lines = text.splitlines()
    assert len(lines) <= height
    shown = sum("ALARM" in line for line in lines)
    assert shown == count or f"… and {count - shown} more" in text
    assert shown == count or len(lines) == height - 1
    has_spare_lines = (height, count) in {(16, 3), (24, 3), (24, 8)}
    assert (f"{SENTENCE} 0." in words(text)) == has_spare_lines  # the newest is the first to be wrapped


def test_a_fleet_is_one_line_each_the_gravest_first_as_many_as_fit() -> None:
    watched = fleet(200)
    worst = AlarmMessage.of(alarm(severity=Severity.ALARM), 1, 0.0)
    hear(watched, "wagon-150/alarm/low_adhesion", worst)
    lines = drawn(watched).splitlines()
    assert len(lines) <= 24
    assert "200 wagons" in lines[0]
    assert "wagon-150" in lines[2]
    assert "1 alarm" in lines[2]
    assert "more" in lines[-2]
    assert len(rows_of(drawn(watched, only="wagon-007"))) == 2


def test_what_is_old_or_gone_is_said_to_be() -> None:
    watched = fleet(1)
    (wagon,) = watched.wagons.values()
    assert "live" in plain_line(wagon, 100.0 + FROZEN_S)
    assert "frozen 60 s" in plain_line(wagon, 160.0)
    assert "frozen 60 s" in drawn(watched, 160.0)
    watched.lives("brake/v1/wagon-000", False)
    assert "gone" in plain_line(wagon, 100.0)


def test_few_estimates_are_not_old_ones() -> None:
    """One in ten seconds, as meta says."""
    watched = fleet(1)
    (wagon,) = watched.wagons.values()
    meta = about(example_settings("wagon"), 0.0)
    hear(watched, "wagon-000/meta", replace(meta, estimate_rate_hz=0.1))
    assert "live" in plain_line(wagon, 120.0)
    assert "frozen 30 s" in plain_line(wagon, 130.0)


def test_an_alarm_that_a_daemon_began_anew_without_is_open_no_more() -> None:
    watched = fleet(1)
    (wagon,) = watched.wagons.values()
    for number, name in enumerate(("forgotten", "known", "newer")):
        hear(watched, "wagon-000/alarm/hot_disc", AlarmMessage.of(alarm(id=name), number, 100.0 + number))
    told = health_of(
        INTAKE, Counters(), None, events_waiting=0, open_alarms=["known"], uptime_s=1.0, sequence=1, now_s=101.5
    )
    hear(watched, "wagon-000/health", told)
    assert {alarm.id for alarm in wagon.open_alarms()} == {"known", "newer"}
    assert "2 alarms" in plain_line(wagon, 100.0)


def styles_of(watched: Watched, text: str) -> set[str]:
    """In which styles a text is drawn."""
    console = Console(width=80, file=StringIO())
    segments = console.render(panel(watched, 100.0, 80, 24))
    found = {str(segment.style) for segment in segments if text in segment.text}
    assert found
    return found


def test_what_is_gone_is_dimmed_and_was_valid_is_not_valid_now() -> None:
    watched = fleet(1)
    (wagon,) = watched.wagons.values()
    hear(watched, "wagon-000/alarm/hot_disc/2", AlarmMessage.of(alarm(kind="hot_disc", wheelset=2), 1, 0.0))
    said = ("64.8 km/h", "valid", "held", "WSP", "ALARM", "hot disc wheelset 2", "The rail gives 0.03.")
    assert not any("dim" in style for text in said for style in styles_of(watched, text))
    assert "last:" not in drawn(watched)
    watched.lives("brake/v1/wagon-000", False)
    assert all(styles_of(watched, text) == {"dim"} for text in said)
    assert re.search(r"gone   last: 64\.8 km/h   valid", drawn(watched))
    assert "alarms as last heard:" in drawn(watched)
    assert plain_line(wagon, 100.0).startswith("wagon-000: gone  last: 64.8 km/h")


def test_a_daemon_that_lives_and_has_no_estimate_yet_has_its_alarms_now() -> None:
    watched = Watched("brake/v1")
    watched.lives("brake/v1/wagon-000", True)
    hear(watched, "wagon-000/alarm/bus_silent", AlarmMessage.of(alarm(kind="bus_silent"), 1, 0.0))
    assert styles_of(watched, "bus silent") == {"bold"}


def test_a_plain_line_tells_the_essential() -> None:
    (wagon,) = fleet(1).wagons.values()
    assert plain_line(wagon, 100.0) == (
        "wagon-000: live  64.8 km/h  adhesion 0.080 ±0.003 saturated  valid  friction 1:0.340 2:0.310  0 alarms"
    )
    seen = AlarmMessage.of(alarm(kind="hot_disc", wheelset=2, acknowledged_time_s=1.0), 1, 0.0)
    assert plain_alarm("w", seen) == "w: ALARM hot disc wheelset 2 open, acknowledged: The rail gives 0.03."


def test_messagepack_is_read_as_well_and_what_is_not_a_number_shown_as_a_dash() -> None:
    watched = Watched("brake/v1")
    broken = AdhesionMessage.of(estimate(adhesion=float("nan"), speed_mps=float("nan")), 1, 0.0)
    hear(watched, "w/adhesion", broken, format="msgpack")
    (wagon,) = watched.wagons.values()
    assert "– km/h  adhesion – ±0.003" in plain_line(wagon, 100.0)


def test_a_wagon_that_was_not_heard_for_a_while_has_a_gap_in_its_line() -> None:
    watched = fleet(2)
    hear(watched, "wagon-001/adhesion", AdhesionMessage.of(estimate(time_s=1700000005.25), 2, 0.0), 105.0)
    rows = [line for line in drawn(watched, 105.0, width=120).splitlines() if "wagon-00" in line]
    assert [len(re.findall("[▁-█]", row)) for row in rows] == [1, 2]
    assert re.search("[▁-█] {4}[▁-█]", rows[1])


def test_what_was_never_told_is_a_dash() -> None:
    watched = fleet(1)
    unknown = frozenset({(Quantity.AXLE_SPEED, 0), (Quantity.PRESSING_FORCE, 0), (Quantity.WSP_ACTIVE, 0)})
    hear(watched, "wagon-000/axle/1/friction", FrictionMessage.of(estimate(unknown=unknown), 1, 2, 0.0))
    assert re.match(r"│ 1 +– +– % +– kN +0\.090 ±0\.004 +0\.340 ±0\.010 valid +– ", rows_of(drawn(watched))[0])


def test_a_count_beyond_all_measure_is_not_understood() -> None:
    sound = health_of(INTAKE, Counters(), None, events_waiting=0, uptime_s=1.0, sequence=1, now_s=1.0)
    for memory_bytes, not_understood in ((7_000_000, 0), (10**400, 1)):
        watched = fleet(1)
        message = json.loads(encode(sound, "json")) | {"memory_bytes": memory_bytes}
        watched.take("brake/v1/wagon-000/health", JSON, json.dumps(message).encode(), 100.0)
        assert watched.not_understood == not_understood
        assert ("7 MB" in drawn(watched)) == (not_understood == 0)


@pytest.mark.parametrize(
    "payload",
    [b"", b"{}", b"[]", b"\xff", b"[" * 5000, b" " * (LARGEST_PAYLOAD + 1)],
)
def test_what_is_not_understood_is_counted_and_changes_nothing(payload: bytes) -> None:
    watched = fleet(1)
    before = drawn(watched)
    assert watched.take("brake/v1/wagon-000/adhesion", JSON, payload, 100.0) is None
    assert watched.not_understood == 1
    watched.not_understood = 0
    assert drawn(watched) == before


@pytest.mark.parametrize(("length", "not_understood"), [(LARGEST_PAYLOAD, 0), (LARGEST_PAYLOAD + 1, 1)])
def test_what_is_larger_than_anything_of_ours_is_not_read(length: int, not_understood: int) -> None:
    watched = fleet(1)
    message = encode(AdhesionMessage.of(estimate(), 1, 0.0), "json").ljust(length)
    watched.take("brake/v1/wagon-000/adhesion", JSON, message, 100.0)
    assert watched.not_understood == not_understood


def test_text_from_outside_does_nothing_to_the_terminal() -> None:
    watched = Watched("brake/v1")
    hear(watched, "w/alarm/x", AlarmMessage.of(alarm(message="\x1b]0;owned\x07"), 1, 0.0))
    hear(watched, "\x1b[2J/adhesion", AdhesionMessage.of(estimate(), 1, 0.0))
    assert watched.not_understood == 2
    assert "\x1b" not in drawn(watched)


def test_brackets_in_a_name_are_no_markup() -> None:
    watched = Watched("brake/v1")
    hear(watched, "wagon[a]/adhesion", AdhesionMessage.of(estimate(), 1, 0.0))
    assert "wagon[a]" in drawn(watched)


def test_an_alarm_is_news_once() -> None:
    watched = Watched("brake/v1")
    payload = encode(AlarmMessage.of(alarm(), 1, 0.0))
    assert watched.take("brake/v1/w/alarm/low_adhesion", JSON, payload, 0.0)
    assert watched.take("brake/v1/w/alarm/low_adhesion", JSON, payload, 0.0) is None


def watching(*arguments: str) -> Program:
    return Program(sys.executable, "-m", "brake_monitor", "watch", *arguments)


@pytest.mark.parametrize("encoding", ["json", "msgpack"])
def test_beside_a_publisher_it_tells_last_values_alarms_and_the_end(encoding: Any) -> None:
    with running(ZenohSettings(encoding=encoding)) as publisher:
        publisher.publish(Outputs(estimate(), (alarm(),)))  # before it watches
        until(lambda: publisher.counters.estimates_sent)
        with watching("--connect", publisher.endpoints[0]) as watch:
            watch.wait_for("live  64.8 km/h")
            watch.wait_for("ALARM low adhesion open")
            publisher.close()
            watch.wait_for("gone")
            status, _ = watch.end()
            assert status == 0


@pytest.mark.parametrize("arguments", [("--prefix", "a//b"), ("--prefix", "brake/**"), ("wag*n",), ("a/b",)])
def test_what_cannot_stand_in_a_key_is_one_sentence(
    arguments: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["watch", *arguments])
    assert ended.value.code == 2
    assert "Zenoh key" in capsys.readouterr().err.splitlines()[-1]


def test_a_terminal_without_rich_is_told_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    monkeypatch.setitem(sys.modules, "rich", None)
    with running() as publisher:
        assert main(["watch", "--connect", publisher.endpoints[0]]) == 2
    assert "pip install '.[desk]'" in capsys.readouterr().err


def test_a_wrong_endpoint_is_one_sentence() -> None:
    with watching("--connect", "nonsense") as watch:
        assert watch.wait() == 2
        assert "--connect nonsense" in watch.lines[0]


def in_a_terminal(*arguments: str) -> tuple[subprocess.Popen[bytes], int]:
    """Watching as over SSH: a terminal whose other end is the file descriptor."""
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
    command = [sys.executable, "-m", "brake_monitor", "watch", *arguments]
    env = os.environ | {"TERM": "xterm-256color"}
    child = subprocess.Popen(command, stdin=theirs, stdout=theirs, stderr=theirs, env=env, start_new_session=True)
    os.close(theirs)
    return child, ours


def news(terminal: int) -> bytes:
    """What comes next, if anything comes within a second; it may begin and end in the midst of a character."""
    if not select.select([terminal], [], [], 1.0)[0]:
        return b""
    try:
        return os.read(terminal, 65536)
    except OSError:  # the other end is closed
        return b""


def test_in_a_terminal_of_80_columns_the_view_is_live_and_leaves_it_as_it_was() -> None:
    with running() as publisher:
        child, terminal = in_a_terminal("--connect", publisher.endpoints[0], "wagon-1")
        try:
            told = b""

            def shows(*texts: str) -> bool:
                nonlocal told
                publisher.publish(Outputs(estimate()))
                told += news(terminal)
                return all(text.encode() in told for text in texts)

            publisher.publish(Outputs(None, (alarm(),)))
            until(lambda: shows("wagon-1", "live", "64.8 km/h", "held", "low adhesion", "The rail gives"))
            assert b"\x1b[1;37;41m ALARM " in told  # bold white on red
            publisher.publish(Outputs(None, (alarm(cleared_time_s=1700000009.0),)))
            until(lambda: shows("no alarms"))
            child.send_signal(signal.SIGTERM)
            until(lambda: (shows() or True) and child.poll() is not None)
            while last := news(terminal):
                told += last
        finally:
            child.kill()
            child.wait()
            os.close(terminal)
    assert child.returncode == 0
    text = told.decode()
    assert text.rindex("\x1b[?25h") > text.rindex("\x1b[?25l")  # the cursor is back
    plain = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", text)
    assert max(len(line) for line in re.split(r"[\r\n]+", plain)) == 80


@pytest.mark.parametrize("cleared_s", [1700000010.0, 1699996400.0])
def test_an_alarm_that_was_cleared_before_the_last_that_was_heard_of_it_is_cleared_all_the_same(
    cleared_s: float,
) -> None:
    """The estimate's time is behind a person's word where a signal has a delay, and goes back with the clock."""
    watched = fleet(1)
    seen = alarm(acknowledged_time_s=1700000010.2, updated_time_s=1700000010.2)
    gone = alarm(acknowledged_time_s=1700000010.2, cleared_time_s=cleared_s, updated_time_s=cleared_s)
    messages = [AlarmMessage.of(seen, 2, 1700000010.3), AlarmMessage.of(gone, 3, 1700000010.4)]
    for message in (*messages, messages[0]):  # at last an answer that was on its way
        hear(watched, "wagon-000/alarm/low_adhesion", message)
    assert [one.state for one in watched.wagons["wagon-000"].alarms.values()] == ["cleared"]


def test_a_daemon_that_counts_its_events_anew_is_believed() -> None:
    watched = fleet(1)
    for message in (
        AlarmMessage.of(alarm(), 90, 1700000010.0),
        AlarmMessage.of(alarm(cleared_time_s=1700000020.0, updated_time_s=1700000020.0), 1, 1700000020.0),
    ):
        hear(watched, "wagon-000/alarm/low_adhesion", message)
    assert [one.state for one in watched.wagons["wagon-000"].alarms.values()] == ["cleared"]


def test_it_is_said_who_is_not_heard() -> None:
    assert (not_heard(None), not_heard("wagon-7")) == ("nobody is heard yet", "wagon-7 is not heard yet")
