"""No thread of Zenoh's outlives what it was made for: one that is left when Python ends aborts the process."""

import threading
from contextlib import ExitStack

import pytest
import zenoh

from brake_monitor.desk.fleet_listener import listen
from brake_monitor.publishing import publisher, zenoh_callback
from brake_monitor.publishing.publisher import Publisher
from brake_monitor.settings.zenoh_settings import ZenohSettings
from network import free_port, session
from program import PATIENCE_S

LINGERS_S = 0.5


class Listener:
    def hear(self, sample: zenoh.Sample) -> None: ...

    def lives(self, sample: zenoh.Sample) -> None: ...


@pytest.fixture
def lingering(monkeypatch: pytest.MonkeyPatch) -> None:
    """Threads without a name, which are Zenoh's, take long to end, as on a busy machine; who waits has all the time."""
    run = threading.Thread.run

    def run_and_linger(thread: threading.Thread) -> None:
        run(thread)
        if thread.name.startswith("Thread-"):
            threading.Event().wait(LINGERS_S)

    monkeypatch.setattr(threading.Thread, "run", run_and_linger)
    monkeypatch.setattr(publisher, "CLOSE_S", PATIENCE_S)
    monkeypatch.setattr(zenoh_callback, "ENDS_WITHIN_S", PATIENCE_S)


@pytest.mark.usefixtures("lingering")
def test_a_publisher_that_is_closed_leaves_no_thread() -> None:
    before = set(threading.enumerate())
    with Publisher(ZenohSettings(), "w"):
        assert set(threading.enumerate()) - before
    assert set(threading.enumerate()) <= before


@pytest.mark.usefixtures("lingering")
def test_who_watches_a_fleet_leaves_no_thread() -> None:
    before = set(threading.enumerate())
    with ExitStack() as stack:
        peer = stack.enter_context(session(f"tcp/127.0.0.1:{free_port()}", "peer"))
        listen(peer, "brake/*", Listener(), stack)
        assert set(threading.enumerate()) - before
    assert set(threading.enumerate()) <= before
