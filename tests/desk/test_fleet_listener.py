"""Whoever watches a fleet can stop at any time, whatever its router does."""

import json
import socket
import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from io import StringIO
from pathlib import Path
from types import SimpleNamespace

import pytest
import zenoh

from brake_monitor.cli import main
from brake_monitor.desk.fleet_listener import LONGEST_REASON, ask, listen, patient_session, watcher_config
from brake_monitor.errors import InputError, WorkError
from brake_monitor.publishing import zenoh_opening
from network import running as publishing
from network import session
from program import until


def test_a_router_that_accepts_and_says_nothing_keeps_nobody_from_stopping() -> None:
    stopping = threading.Event()
    with socket.create_server(("127.0.0.1", 0)) as router:
        router.settimeout(60.0)
        config = watcher_config(f"tcp/127.0.0.1:{router.getsockname()[1]}", None)
        sessions: list[object] = []
        watcher = threading.Thread(target=lambda: sessions.append(patient_session(config, stopping)))
        watcher.start()
        silent, _ = router.accept()
        stopping.set()
        watcher.join(60.0)
        (opener,) = [thread for thread in threading.enumerate() if thread.name == "opening Zenoh"]
        assert sessions == [None]
        assert not watcher.is_alive()
        silent.close()
    opener.join(60.0)
    assert not opener.is_alive()


class Retries(threading.Event):
    """Set after so many waits, none of which takes any time."""

    def __init__(self, after: int) -> None:
        super().__init__()
        self._left = after

    def wait(self, _timeout: float | None = None) -> bool:
        self._left -= 1
        if not self._left:
            self.set()
        return self.is_set()


def refusing(monkeypatch: pytest.MonkeyPatch, why: str) -> list[str]:
    """A Zenoh that opens no session; one entry for each attempt."""
    attempts: list[str] = []

    def refuse(_: zenoh.Config) -> zenoh.Session:
        attempts.append(why)
        raise zenoh.ZError(why)

    zenoh_there = SimpleNamespace(open=refuse, ZError=zenoh.ZError, Session=zenoh.Session)
    monkeypatch.setattr(zenoh_opening, "zenoh", zenoh_there)
    return attempts


def test_who_does_not_answer_is_asked_again_and_again_and_that_is_said_once(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    config = watcher_config("tcp/127.0.0.1:1", None)
    attempts = refusing(monkeypatch, "Unable to connect to any of [tcp/127.0.0.1:1]")
    assert patient_session(config, Retries(after=3)) is None
    assert len(attempts) == 3
    assert capsys.readouterr().err == "nobody answers at tcp/127.0.0.1:1 yet; still trying\n"


def test_what_no_patience_mends_is_raised(monkeypatch: pytest.MonkeyPatch) -> None:
    config = watcher_config("tcp/127.0.0.1:1", None)
    refusing(monkeypatch, "no such protocol")
    with pytest.raises(WorkError, match="no Zenoh session: no such protocol"):
        patient_session(config, Retries(after=3))


def test_nobody_but_the_endpoint_is_looked_for() -> None:
    config = watcher_config("tcp/192.0.2.1:7447", None)
    told = {
        key: json.loads(config.get_json(key)) for key in ("mode", "connect/endpoints", "scouting/multicast/enabled")
    }
    assert told == {
        "mode": "client",
        "connect/endpoints": ["tcp/192.0.2.1:7447"],
        "scouting/multicast/enabled": False,
    }


class Heard:
    """Notes which keys it hears of, and which wagons come and go."""

    def __init__(self) -> None:
        self.keys: list[str] = []
        self.lives_of: list[tuple[str, bool]] = []

    def hear(self, sample: zenoh.Sample) -> None:
        self.keys.append(str(sample.key_expr))

    def lives(self, sample: zenoh.Sample) -> None:
        self.lives_of.append((str(sample.key_expr), sample.kind == zenoh.SampleKind.PUT))


@contextmanager
def watched_wagon() -> Iterator[tuple[zenoh.Session, zenoh.Session]]:
    """A session that a wagon may speak over, and that of who watches it."""
    with publishing() as publisher, session(publisher.endpoints[0]) as other:
        stopping = threading.Event()
        watching = patient_session(watcher_config(publisher.endpoints[0], None), stopping)
        assert watching is not None
        with watching:
            yield other, watching


SAID = ("adhesion", "health", "meta", "axle/1/friction", "alarm/slide", "alarm/pads/2", "axle/2/wear")


def say_all(wagon: zenoh.Session) -> set[str]:
    """Again and again: what somebody has just subscribed to, a wagon does not know yet."""
    keys = {f"brake/v1/w/{key}" for key in SAID}
    for key in keys:
        wagon.put(key, b"")
    return keys


def test_whatever_a_wagon_says_is_heard_and_when_it_comes_and_goes() -> None:
    with watched_wagon() as (wagon, watching), ExitStack() as stack:
        listen(watching, "brake/v1/*", heard := Heard(), stack)
        token = wagon.liveliness().declare_token("brake/v1/w")
        until(lambda: ("brake/v1/w", True) in heard.lives_of)
        until(lambda: say_all(wagon) <= set(heard.keys))
        token.undeclare()
        until(lambda: heard.lives_of[-1] == ("brake/v1/w", False))


def test_answers_are_counted_and_none_is_sure_where_somebody_refuses() -> None:
    def reply(query: zenoh.Query) -> None:
        for key in ("a", "b"):
            query.reply(f"brake/v1/w/{key}", b"")

    def refuse(query: zenoh.Query) -> None:
        query.reply_err("ask again later")

    with watched_wagon() as (wagon, watching), ExitStack() as stack:
        stack.enter_context(wagon.declare_queryable("brake/v1/w/*", reply))
        until(lambda: ask(watching, "brake/v1/w/*", Heard().hear) == 2)
        stack.enter_context(wagon.declare_queryable("brake/v1/w/c", refuse))
        until(lambda: ask(watching, "brake/v1/w/*", Heard().hear) is None)


@pytest.mark.parametrize("name", ["root_ca_certificate", "connect_certificate", "connect_private_key"])
def test_a_certificate_that_cannot_be_read_is_named(name: str, tmp_path: Path) -> None:
    file, missing = tmp_path / "fleet.json5", tmp_path / "missing.pem"
    file.write_text(json.dumps({"mode": "client", "transport": {"link": {"tls": {name: str(missing)}}}}))
    with pytest.raises(InputError, match=f"{file}: {name}: {missing} cannot be read here: No such file"):
        watcher_config("", file)


class Sentence(StringIO):
    """A stream that tells when a line has been written."""

    def __init__(self) -> None:
        super().__init__()
        self.is_whole = threading.Event()

    def write(self, text: str, /) -> int:
        written = super().write(text)
        if text.endswith("\n"):
            self.is_whole.set()
        return written


def test_it_is_said_where_nobody_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    stopping = threading.Event()
    monkeypatch.setattr(sys, "stderr", said := Sentence())
    with socket.create_server(("127.0.0.1", 0)) as other:
        endpoint = f"tcp/127.0.0.1:{other.getsockname()[1]}"
    watcher = threading.Thread(target=lambda: patient_session(watcher_config(endpoint, None), stopping))
    watcher.start()
    said.is_whole.wait(60.0)
    stopping.set()
    watcher.join(60.0)
    assert said.getvalue() == f"nobody answers at {endpoint} yet; still trying\n"


@pytest.mark.parametrize(
    "endpoint", ["", "tcp", "tcp/127.0.0.1", "tcp/127.0.0.1:99999", "foo/192.0.2.1:1", "tcp/:7447", "tcp/a:1?;"]
)
def test_an_endpoint_that_nobody_could_ever_answer_at_is_refused(endpoint: str) -> None:
    with pytest.raises(InputError, match=r"--connect .*: expected ") as refused:
        watcher_config(endpoint, None)
    assert "\n" not in str(refused.value)


def test_what_stands_behind_an_endpoint_is_never_shown() -> None:
    """Zenoh takes a private key there."""
    with pytest.raises(InputError) as refused:
        watcher_config("xyz/127.0.0.1:1#connect_private_key_base64=secret", None)
    assert "secret" not in str(refused.value)


EXAMPLE = (Path(__file__).parents[2] / "dbc" / "wagon.toml").read_text()


@pytest.mark.parametrize(
    ("name", "text", "reason"),
    [
        ("wagon.toml", EXAMPLE, "unknown field `can`"),
        ("w.json5", EXAMPLE, "line 1: expected array, boolean, null, number, object, or string"),
        ("w.json5", '{\n  connect: {endpoints: [}\n', "line 2: expected array, boolean, null, number"),
        ("w.json5", '{mode: "cliend"}', "line 1: unknown variant `cliend`, expected one of `router`, `peer`, `client`"),
        ("w.json5", "{nonsense: 3}", "line 1: unknown field `nonsense`"),
        ("w.json", '{"connect": {"endpoints": "tcp"}}', 'line 1: invalid type: string "tcp", expected list'),
        ("w.yaml", "mode: client\nnonsense: 3\n", "unknown field `nonsense`"),
        ("w.json5", "", "Empty config file"),
        ("w.txt", "mode", "Unsupported file type '.txt'"),
    ],
)  # fmt: skip
def test_a_file_that_is_no_configuration_of_zenohs_is_one_sentence_that_says_why(
    name: str, text: str, reason: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / name).write_text(text)
    assert main(["watch", "--zenoh-config", str(tmp_path / name)]) == 2
    (said,) = capsys.readouterr().err.splitlines()
    before, is_said, after = said.partition(f"{tmp_path / name}: not a Zenoh configuration: ")
    assert before == "brake-monitor: "
    assert is_said
    assert reason in after
    assert len(after) <= len("line 1: ") + LONGEST_REASON
    assert ".rs" not in after


def test_a_file_that_is_not_there_is_said_to_be_unreadable(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["watch", "--zenoh-config", str(tmp_path / "none.json5")]) == 2
    said = f"brake-monitor: {tmp_path / 'none.json5'}: cannot be read: No such file or directory\n"
    assert capsys.readouterr().err == said
