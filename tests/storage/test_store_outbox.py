"""Events in the daemon's memory: another run finds them, and a disk that failed is tried anew."""

import socket
import threading
from errno import EIO
from pathlib import Path

import pytest

from brake_monitor.errors import InputError, WorkError
from brake_monitor.processing.pipeline import Outputs
from brake_monitor.publishing.publisher import Publisher
from brake_monitor.settings.zenoh_settings import ZenohSettings
from brake_monitor.storage import store_outbox
from brake_monitor.storage.store import Store
from brake_monitor.storage.store_batch import Batch
from brake_monitor.storage.store_file import log_of
from brake_monitor.storage.store_outbox import StoreOutbox
from estimates import alarm, estimate
from network import running, session
from program import PATIENCE_S, until


def test_events_outlive_the_publisher_in_the_memory(tmp_path: Path) -> None:
    path = tmp_path / "memory.db"
    Store.open(path, "wagon-1", 2).close()
    outbox = StoreOutbox(path, "wagon-1")
    with running(outbox=outbox) as first:
        first.publish(Outputs(None, (alarm(), alarm(kind="hot_disc", wheelset=1))))
        until(lambda: first.counters.events_sent == 2)
    outbox.close()
    again = StoreOutbox(path, "wagon-1")
    with running(outbox=again) as second, session(second.endpoints[0]) as other:
        second.publish(Outputs(None, (alarm(cleared_time_s=1700000009.0),)))
        until(lambda: second.counters.events_sent == 3)  # two that were kept, one new
        (reply,) = other.get("brake/v1/wagon-1/alarm/**")
        assert reply.ok is not None
        assert str(reply.ok.key_expr) == "brake/v1/wagon-1/alarm/hot_disc/1"
    assert len(list(again.kept())) == 3
    again.close()


def test_events_are_kept_while_a_router_accepts_the_session_and_says_nothing(tmp_path: Path) -> None:
    """As where packets are lost on their way, in a tunnel: opening a client's session takes ten seconds each time."""
    path = tmp_path / "memory.db"
    Store.open(path, "wagon-1", 2).close()
    outbox, kept = StoreOutbox(path, "wagon-1"), StoreOutbox(path, "wagon-1")
    with socket.create_server(("127.0.0.1", 0)) as router:
        router.settimeout(PATIENCE_S)
        settings = ZenohSettings(mode="client", connect=(f"tcp/127.0.0.1:{router.getsockname()[1]}",))
        publisher = Publisher(settings, "wagon-1", outbox=outbox)
        publisher.give_up_waiting()
        publisher.start()
        silent, _ = router.accept()
        publisher.publish(Outputs(None, (alarm(),)))
        until(lambda: list(kept.kept()))
        publisher.publish(Outputs(None, (alarm(cleared_time_s=1700000009.0),)))
        publisher.close()
        assert len(list(kept.kept())) == 2
        assert not publisher._thread.is_alive()
        silent.close()
    kept.close()


def hanging_disk(monkeypatch: pytest.MonkeyPatch) -> threading.Event:
    """A disk that takes nothing more until it is let go on."""
    goes_on, write = threading.Event(), Store.write

    def hang(store: Store, batch: Batch) -> None:
        assert goes_on.wait(PATIENCE_S)
        write(store, batch)

    monkeypatch.setattr(Store, "write", hang)
    return goes_on


def test_a_disk_that_hangs_holds_no_publication_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Else nobody heard that the memory fails, and the watchdog would have the daemon started anew."""
    path = tmp_path / "memory.db"
    Store.open(path, "wagon-1", 2).close()
    outbox, kept = StoreOutbox(path, "wagon-1"), StoreOutbox(path, "wagon-1")
    goes_on = hanging_disk(monkeypatch)
    with (
        running(outbox=outbox) as publisher,
        session(publisher.endpoints[0]) as other,
        other.declare_subscriber("brake/v1/wagon-1/*") as heard,
    ):
        for number in (1, 2):
            publisher.publish(Outputs(None, (alarm(id=f"a-{number}"),)))
            until(lambda number=number: publisher.counters.events_sent == number)
        until(lambda: publisher.publish(Outputs(estimate())) or heard.try_recv())
        assert publisher.counters.publish_failures == 2
        assert publisher.heartbeat_age_s() < 5.0
        assert outbox.is_writing
        publisher.close()
        assert not publisher._thread.is_alive()
        with pytest.raises(WorkError, match="no more events are kept"):
            outbox.keep({3: b"of a run that is over"})
        goes_on.set()
        until(lambda: not outbox.is_writing)
        assert outbox._store is None
    assert len(list(kept.kept())) == 1  # which the disk had begun with
    kept.close()


def test_what_a_disk_that_hung_has_not_kept_is_kept_with_what_comes_next(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(store_outbox, "KEPT_WITHIN_S", 0.0)
    path = tmp_path / "memory.db"
    Store.open(path, "wagon-1", 2).close()
    outbox = StoreOutbox(path, "wagon-1")
    goes_on = hanging_disk(monkeypatch)
    for messages in ({1: b"a"}, {1: b"a", 2: b"b"}):
        with pytest.raises(WorkError, match="the disk does not answer"):
            outbox.keep(messages)
    goes_on.set()
    until(lambda: not outbox.is_writing)
    monkeypatch.setattr(store_outbox, "KEPT_WITHIN_S", PATIENCE_S)
    outbox.keep({1: b"a", 2: b"b", 3: b"c"})
    assert list(outbox.kept()) == [b"a", b"b", b"c"]
    outbox.close()


def test_a_memory_that_is_not_there_is_found_when_it_comes(tmp_path: Path) -> None:
    path = tmp_path / "memory.db"
    outbox = StoreOutbox(path, "wagon-1")
    with pytest.raises(InputError):
        list(outbox.kept())
    with pytest.raises(InputError):
        outbox.keep({1: b"a"})
    Store.open(path, "wagon-1", 2).close()
    outbox.keep({1: b"a", 2: b"b"})
    assert list(outbox.kept()) == [b"a", b"b"]
    outbox.close()


def test_a_disk_that_fails_is_told_and_tried_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "memory.db"
    Store.open(path, "wagon-1", 2).close()
    outbox = StoreOutbox(path, "wagon-1")
    outbox.keep({1: b"a"})

    def fail(*_: object, **__: object) -> None:
        raise OSError(EIO, "Input/output error")

    with monkeypatch.context() as patched:
        patched.setattr(Path, "stat", fail)
        for attempt in (lambda: outbox.keep({2: b"b"}), lambda: list(outbox.kept())):
            with pytest.raises(WorkError, match="Input/output error"):
                attempt()
    outbox.keep({2: b"b"})
    assert list(outbox.kept()) == [b"a", b"b"]
    outbox.close()


def test_where_no_more_threads_may_be_begun_it_is_tried_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "memory.db"
    Store.open(path, "wagon-1", 2).close()
    outbox = StoreOutbox(path, "wagon-1")

    def fail(_: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    with monkeypatch.context() as patched:
        patched.setattr(threading.Thread, "start", fail)
        with pytest.raises(WorkError, match="can't start new thread"):
            outbox.keep({1: b"a"})
    outbox.keep({1: b"a", 2: b"b"})
    assert list(outbox.kept()) == [b"a", b"b"]
    outbox.close()


def test_a_memory_that_was_set_aside_gets_no_more_messages(tmp_path: Path) -> None:
    path = tmp_path / "memory.db"
    Store.open(path, "wagon-1", 2).close()
    outbox = StoreOutbox(path, "wagon-1")
    outbox.keep({1: b"a"})
    for name in (path, log_of(path)):
        name.rename(name.with_name(f"refused-{name.name}"))
    Store.open(path, "wagon-1", 2).close()
    outbox.keep({2: b"b"})
    assert list(outbox.kept()) == [b"b"]
    outbox.close()
    another = StoreOutbox(path, "wagon-1")  # through a log that is gone one may read what is in no file
    assert list(another.kept()) == [b"b"]
    another.close()
