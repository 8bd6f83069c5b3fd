"""Whoever watches a fleet can stop at any time, whatever its router does."""

import socket
import sys
import threading
from io import StringIO
from pathlib import Path

import pytest

from brake_monitor.cli import main
from brake_monitor.desk.fleet_listener import LONGEST_REASON, patient_session, watcher_config
from brake_monitor.errors import InputError


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
