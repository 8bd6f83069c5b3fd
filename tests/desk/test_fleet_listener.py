"""Whoever watches a fleet can stop at any time, whatever its router does."""

import socket
import threading

from brake_monitor.desk.fleet_listener import patient_session, watcher_config


def test_a_router_that_accepts_and_says_nothing_keeps_nobody_from_stopping() -> None:
    stopping = threading.Event()
    with socket.create_server(("127.0.0.1", 0)) as router:
        router.settimeout(60.0)
        config = watcher_config(f"tcp/127.0.0.1:{router.getsockname()[1]}", None)
        sessions: list[object] = []
        watcher = threading.Thread(target=lambda: sessions.append(patient_session(config, stopping)))
        watcher.start()
        silent, _ = router.accept()
        before = threading.active_count()
        stopping.set()
        watcher.join(60.0)
        (opener,) = [thread for thread in threading.enumerate() if thread.name == "opening Zenoh"]
        assert sessions == [None]
        assert threading.active_count() == before - 1
        silent.close()
    opener.join(60.0)
    assert not opener.is_alive()
