"""A session on its way: who waits gets it, or why there is none; what nobody wants any more is closed."""

import threading
from types import SimpleNamespace

import pytest
import zenoh

from brake_monitor.publishing import zenoh_opening
from brake_monitor.publishing.zenoh_opening import Opening
from brake_monitor.publishing.zenoh_session import session_config
from brake_monitor.settings.zenoh_settings import ZenohSettings
from program import PATIENCE_S, until


def test_a_session_that_nobody_wants_any_more_is_closed() -> None:
    opening = Opening(session_config(ZenohSettings()))
    session = opening.found(PATIENCE_S)
    assert isinstance(session, zenoh.Session)
    assert not session.is_closed()
    opening.give_up()
    assert session.is_closed()


def test_so_is_one_that_opens_later(monkeypatch: pytest.MonkeyPatch) -> None:
    sessions, goes_on = list[zenoh.Session](), threading.Event()

    def open_late(config: zenoh.Config) -> zenoh.Session:
        assert goes_on.wait(PATIENCE_S)
        sessions.append(zenoh.open(config))
        return sessions[0]

    there = SimpleNamespace(open=open_late, ZError=zenoh.ZError, Session=zenoh.Session)
    monkeypatch.setattr(zenoh_opening, "zenoh", there)
    opening = Opening(session_config(ZenohSettings()))
    assert opening.found(0.0) is None
    opening.give_up()
    goes_on.set()
    until(lambda: sessions and sessions[0].is_closed())


def test_a_fault_of_ours_is_raised_where_the_session_is_awaited(monkeypatch: pytest.MonkeyPatch) -> None:
    """Else it would be awaited for ever, and no watchdog notice."""
    there = SimpleNamespace(open=lambda _: 1 / 0, ZError=zenoh.ZError, Session=zenoh.Session)
    monkeypatch.setattr(zenoh_opening, "zenoh", there)
    opening = Opening(session_config(ZenohSettings()))
    with pytest.raises(ZeroDivisionError):
        opening.found(PATIENCE_S)
