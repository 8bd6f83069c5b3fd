"""The web server by itself: only reading, only our own page, only under our own name."""

import socket
import subprocess
import sys
from argparse import ArgumentTypeError
from collections.abc import Iterator
from contextlib import ExitStack, closing, suppress
from email.message import Message
from http.client import HTTPConnection
from typing import NamedTuple

import pytest

from brake_monitor.commands.dashboard import address
from brake_monitor.dashboard.server import MOST_CONNECTIONS, page_files
from brake_monitor.dashboard.visitors import is_known_host
from depot import Dashboard, Depot
from live import UPGRADE, first_words
from program import PATIENCE_S, until


@pytest.fixture(scope="module")
def port() -> Iterator[int]:
    with Dashboard("--listen", "127.0.0.1:0", "--name", "Depot.example") as dashboard:
        yield dashboard.port


class Answer(NamedTuple):
    status: int
    headers: Message
    body: bytes


def ask(port: int, path: str = "/", method: str = "GET", **headers: str) -> Answer:
    with closing(HTTPConnection("127.0.0.1", port, timeout=PATIENCE_S)) as connection:
        connection.request(method, path, headers=headers)
        answer = connection.getresponse()
        return Answer(answer.status, answer.headers, b"" if answer.status == 101 else answer.read())


def listen(port: int, path: str = "/live", **headers: str) -> int:
    return ask(port, path, **(UPGRADE | headers)).status


@pytest.mark.parametrize(
    ("text", "where"),
    [
        ("127.0.0.1:8090", ("127.0.0.1", 8090)),
        ("[::1]:0", ("::1", 0)),
        ("depot:65535", ("depot", 65535)),
        ("depot:65536", None),
        ("depot:-1", None),
        ("depot:", None),
        ("depot", None),
        (":8090", None),  # which would be every address of this machine
        ("depot:\u0668", None),
    ],
)
def test_it_listens_where_it_is_told_and_nowhere_else(text: str, where: tuple[str, int] | None) -> None:
    if where is not None:
        assert address(text) == where
        return
    with pytest.raises(ArgumentTypeError, match="expected HOST:PORT"):
        address(text)


def test_everything_it_serves_comes_with_headers_that_keep_a_browser_careful(port: int) -> None:
    assert {"/", "/app.js", "/style.css", "/vendor/uPlot.iife.min.js"} <= page_files().keys()
    for path in page_files():
        answer = ask(port, path)
        assert answer.status == 200, path
        policy = answer.headers["Content-Security-Policy"]
        assert "default-src 'none'" in policy
        assert "unsafe" not in policy
        assert answer.headers["X-Content-Type-Options"] == "nosniff"
        assert answer.body == page_files()[path][0]


def test_nothing_it_serves_asks_anybody_else() -> None:
    for path, (content, _) in page_files().items():
        text = content.decode()
        addresses = {part.split('"')[0].split("'")[0].split("`")[0] for part in text.split("://")[1:]}
        known = ("www.w3.org/2000/svg", "www.w3.org/1999/xhtml", "${location.host}", "github.com/leeoniya/uPlot")
        assert not [address for address in addresses if not address.startswith(known)], path


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "PATCH"])
def test_there_is_nothing_to_change(port: int, method: str) -> None:
    assert ask(port, "/", method).status == 405
    assert ask(port, "/live", method).status == 405


@pytest.mark.parametrize(
    "path", ["/../pyproject.toml", "/%2e%2e/server.py", "/vendor/../../server.py", "/server.py", "/vendor"]
)
def test_only_the_page_is_served(port: int, path: str) -> None:
    assert ask(port, path).status == 404


def test_a_foreign_name_is_turned_away(port: int) -> None:
    """DNS rebinding: a page of somebody else, whose name now leads here, comes with that name."""
    for host in (f"127.0.0.1:{port}", f"localhost:{port}", f"[::1]:{port}", "depot.example", "192.0.2.7"):
        assert ask(port, Host=host).status == 200, host
    for host in ("evil.example", f"evil.example:{port}", "localhost.evil.example", "127.0.0.1.evil.example", "", "[x"):
        answer = ask(port, Host=host)
        assert answer.status in (400, 421), host
        assert b"<" not in answer.body
    assert not is_known_host("evil.example", frozenset({"localhost"}))


def test_only_our_own_page_may_listen(port: int) -> None:
    own = f"http://127.0.0.1:{port}"
    assert listen(port, Origin=own) == 101
    assert listen(port, Origin="http://evil.example") == 403
    assert listen(port, Origin="null") == 403
    assert listen(port, Origin="http://[") == 403
    assert listen(port) == 403
    assert listen(port, f"/live?wagon={'x' * 200}", Origin=own) == 400


def test_a_browser_that_talks_is_left(port: int) -> None:
    """There is nothing to tell the server: a page of ours never does."""
    with socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S) as browser:
        head = {"Host": f"127.0.0.1:{port}", "Origin": f"http://127.0.0.1:{port}"} | UPGRADE
        browser.sendall(
            b"GET /live HTTP/1.1\r\n" + b"".join(f"{k}: {v}\r\n".encode() for k, v in head.items()) + b"\r\n"
        )
        assert b"101" in browser.recv(4096)
        browser.sendall(b"\x81\x85\x00\x00\x00\x00hello")
        while browser.recv(65536):
            pass


def test_connections_beyond_the_most_are_closed_and_those_before_serve_on() -> None:
    """Each takes a file descriptor: without an end to them nothing else could be opened, no router either."""
    with Dashboard("--listen", "127.0.0.1:0") as dashboard, ExitStack() as stack:

        def connected() -> socket.socket:
            return stack.enter_context(socket.create_connection(("127.0.0.1", dashboard.port), timeout=PATIENCE_S))

        def asks(browser: socket.socket) -> bytes:
            with suppress(ConnectionResetError, BrokenPipeError):  # it was closed before
                browser.sendall(f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{dashboard.port}\r\n\r\n".encode())
                return browser.recv(12)
            return b""

        first, *_, last = [connected() for _ in range(MOST_CONNECTIONS)]
        assert asks(last) == b"HTTP/1.1 200"  # those before it are counted by then
        assert asks(connected()) == b""
        assert asks(first) == b"HTTP/1.1 200"


def test_it_ends_when_told_and_says_what_is_wrong_in_a_sentence() -> None:
    with Dashboard("--listen", "127.0.0.1:0") as dashboard:
        taken = f"127.0.0.1:{dashboard.port}"

        def listening_on(place: str) -> subprocess.CompletedProcess[str]:
            command = [sys.executable, "-m", "brake_monitor", "dashboard", "--listen", place]
            return subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)

        second = listening_on(taken)
        assert second.returncode == 1
        assert second.stderr.startswith(f"brake-monitor: --listen {taken}: ")
        assert "Traceback" not in second.stderr
        unknown = listening_on("none.invalid:0")
        assert unknown.returncode == 1
        assert "Unknown error" not in unknown.stderr
        assert "name" in unknown.stderr.removeprefix("brake-monitor: --listen none.invalid:0: ").lower()
        wrong = listening_on("nowhere")
        assert wrong.returncode == 2
        assert "expected HOST:PORT" in wrong.stderr
        status, _ = dashboard.end()
        assert status == 0


def test_it_listens_on_this_machine_only_unless_told_otherwise() -> None:
    from brake_monitor.cli import build_parser  # noqa: PLC0415 - as the command line says it

    assert build_parser("dashboard").parse_args(["dashboard"]).listen[0] == "127.0.0.1"


def test_messagepack_is_understood_as_well() -> None:
    with ExitStack() as stack:
        depot = Depot(stack)
        depot.router()
        wagon = depot.wagon("w", "msgpack")
        port = depot.dashboard().port
        until(lambda: first_words(port)["wagons"])
        wagon.says(estimate={"speed_mps": 3.0}, wheelsets=[{}, {}])
        until(lambda: first_words(port)["wagons"][0]["speed_mps"] == 3.0)
