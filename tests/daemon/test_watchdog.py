"""When systemd's watchdog is fed, by a clock that the test moves, and what the log is told besides."""

from types import SimpleNamespace

import pytest

from brake_monitor.daemon import watchdog
from brake_monitor.daemon.watchdog import Watchdog


@pytest.mark.parametrize(("period_s", "at_most_s"), [(3.0, 1.5), (0.1, 0.05), (600.0, 60.0), (None, 60.0)])
def test_it_is_fed_at_least_twice_within_its_period_and_systemd_is_told_the_state_each_minute(
    period_s: float | None, at_most_s: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    now_s = 1000.0
    monkeypatch.setattr(watchdog, "watchdog_s", lambda: period_s)
    monkeypatch.setattr(watchdog, "time", SimpleNamespace(monotonic=lambda: now_s))
    fed = Watchdog()
    assert fed.is_due()
    assert not fed.is_due()  # not in each turn
    now_s += at_most_s
    assert fed.is_due()


def test_of_dropped_frames_the_log_is_told_how_many_more_they_are(caplog: pytest.LogCaptureFixture) -> None:
    told = Watchdog()
    for dropped in (0, 5, 5, 12, 12):
        told.note_dropped(dropped)
    assert [message.split(":")[0] for message in caplog.messages] == [
        "the kernel dropped 5 frames",
        "the kernel dropped 7 frames",
    ]
