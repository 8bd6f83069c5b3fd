"""The Zenoh side of whoever watches a fleet: a session that waits for its router, and what is subscribed to."""

import json
import re
import sys
import threading
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Protocol

import zenoh
from zenoh import ext

from brake_monitor.errors import InputError, WorkError
from brake_monitor.publishing.zenoh_callback import AwaitedCallback
from brake_monitor.publishing.zenoh_endpoints import endpoint_fault, shown
from brake_monitor.publishing.zenoh_opening import Opening
from brake_monitor.publishing.zenoh_session import reason_of

STATES = ("adhesion", "health", "meta", "axle/*/friction")
RETRY_S = 1.0
LOOK_AROUND_S = 0.1  # for a signal to stop
ANSWERS_WITHIN_S = 2.0
LONGEST_REASON = 120  # characters


class Hears(Protocol):
    """Whoever is told what a fleet says; called from Zenoh's threads."""

    def hear(self, sample: zenoh.Sample) -> None:
        """A message."""

    def lives(self, sample: zenoh.Sample) -> None:
        """A liveliness token that came (PUT) or went."""


def watcher_config(connect: str, file: Path | None) -> zenoh.Config:
    """A client of the endpoint, or what the file says; InputError when it makes no sense."""
    if file is not None:
        try:
            file.open("rb").close()
            configured = zenoh.Config.from_file(file)
        except OSError as error:
            raise InputError(f"{file}: cannot be read: {error.strerror}") from None
        except zenoh.ZError as error:
            raise InputError(f"{file}: not a Zenoh configuration: {_fault_in_file(str(error))}") from None
        _check_certificates(file, configured)
        return configured
    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("scouting/multicast/enabled", "false")
    config.insert_json5("transport/shared_memory/enabled", "false")  # it takes 16 MB for every neighbour
    if fault := endpoint_fault(connect):
        raise InputError(f"--connect {shown(connect)}: {fault}")
    config.insert_json5("connect/endpoints", json.dumps([connect]))
    return config


def _check_certificates(file: Path, configured: zenoh.Config) -> None:
    """InputError when one is not there: Zenoh says of it no more than that nobody answers."""
    tls = json.loads(configured.get_json("transport/link/tls"))
    for name in ("root_ca_certificate", "connect_certificate", "connect_private_key"):
        path = Path(tls[name] or file)
        try:
            path.open("rb").close()
        except OSError as error:
            raise InputError(f"{file}: {name}: {path} cannot be read here: {error.strerror}") from None


def _fault_in_file(said: str) -> str:
    """The reason and the line, out of the error messages of Zenoh's readers of JSON5, YAML and TOML.

    These draw a picture of the place, print the whole file, or list every key that there is.
    """
    said = said.rpartition(" at /")[0] or said  # behind it a place in Zenoh's source code
    quoted = re.search(r'\b(?:msg|message): "((?:[^"\\]|\\.)*)"', said)
    drawn = re.search(r"^ *= (.*)", said, re.MULTILINE)
    place = re.search(r"--> (\d+):\d+|\bline:? (\d+)", said)
    told = quoted or drawn
    reason = told[1].replace('\\"', '"') if told else " ".join(said.split())
    if len(reason) > LONGEST_REASON:
        reason = reason.partition(", expected one of")[0][:LONGEST_REASON]
    return reason if place is None else f"line {place[1] or place[2]}: {reason}"


def patient_session(config: zenoh.Config, stopping: threading.Event) -> zenoh.Session | None:
    """The session, as soon as somebody answers; None when told to stop before."""
    told = False
    while not stopping.is_set():
        opened = _opened(config, stopping)
        if not isinstance(opened, zenoh.ZError):
            return opened
        if "Unable to connect" not in str(opened):
            raise WorkError(f"no Zenoh session: {reason_of(opened)}")
        if not told:
            told = True
            print(f"nobody answers{_asked(config)} yet; still trying", file=sys.stderr, flush=True)
        stopping.wait(RETRY_S)
    return None


def _asked(config: zenoh.Config) -> str:
    """` at tcp/127.0.0.1:7447`; nothing where a file has endpoints for each mode."""
    endpoints = json.loads(config.get_json("connect/endpoints"))
    return f" at {', '.join(endpoints)}" if isinstance(endpoints, list) and endpoints else ""


def _opened(config: zenoh.Config, stopping: threading.Event) -> zenoh.Session | zenoh.ZError | None:
    """A session, or why there is none; None when told to stop before."""
    opening = Opening(config)
    while (found := opening.found(LOOK_AROUND_S)) is None:
        if stopping.is_set():
            opening.give_up()
            return None
    return found


def listen(session: zenoh.Session, keys: str, listener: Hears, stack: ExitStack) -> None:
    """Subscribe to the STATES below `keys`, alarms, wear and life until the stack unwinds, and ask for last values."""
    history = ext.HistoryConfig(detect_late_publishers=True, max_samples=1)
    stack.enter_context(session.liveliness().declare_subscriber(keys, _awaited(listener.lives, stack), history=True))
    for key in STATES:
        stack.enter_context(session.declare_subscriber(f"{keys}/{key}", _awaited(listener.hear, stack)))
    for key in ("alarm/**", "axle/*/wear"):
        heard = _awaited(listener.hear, stack)
        stack.enter_context(ext.declare_advanced_subscriber(session, f"{keys}/{key}", heard, history=history))
    ask(session, f"{keys}/**", listener.hear)


def _awaited(call: Callable[[zenoh.Sample], None], stack: ExitStack) -> "zenoh.handlers.Callback[zenoh.Sample]":
    callback = AwaitedCallback(call)
    stack.callback(callback.join)  # after what is declared with it has been undeclared
    return callback.handler


def ask(session: zenoh.Session, selector: str, hear: Callable[[zenoh.Sample], None]) -> int | None:
    """Put a question and hear each answer; how many came, None where somebody refuses to answer or is late.

    So it is where the question cannot be put.
    """
    answers, is_whole = 0, True
    try:
        replies = session.get(selector, timeout=ANSWERS_WITHIN_S)
    except zenoh.ZError:  # nobody can be asked at the moment
        return None
    for reply in replies:
        if reply.ok is None:
            is_whole = False
        else:
            hear(reply.ok)
            answers += 1
    return answers if is_whole else None
