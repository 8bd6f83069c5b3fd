"""Signals that end a program in an orderly way, and those that it leaves alone."""

import signal
from collections.abc import Iterator

import pytest

from brake_monitor.host.stop_signals import ended_by_signals, stopped_by_signals


@pytest.fixture(autouse=True)
def as_in_a_terminal() -> Iterator[None]:
    """What a shell runs in the background, or nohup, inherits something else."""
    before = {number: signal.signal(number, signal.SIG_DFL) for number in (signal.SIGTERM, signal.SIGHUP)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_program_that_is_ended_exits_as_shells_expect_and_a_second_signal_does_not_hurry_it(
    number: signal.Signals,
) -> None:
    cleaned = []

    def work() -> None:
        with ended_by_signals():
            try:
                signal.raise_signal(number)
            finally:
                for other in (signal.SIGTERM, signal.SIGHUP):
                    signal.raise_signal(other)
                cleaned.append("up")

    with pytest.raises(SystemExit) as ended:
        work()
    assert ended.value.code == 128 + number
    assert cleaned == ["up"]
    assert signal.getsignal(number) == signal.SIG_DFL


def test_what_is_ignored_stays_so() -> None:
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    with ended_by_signals():
        signal.raise_signal(signal.SIGHUP)
    assert signal.getsignal(signal.SIGHUP) == signal.SIG_IGN


def test_a_second_sigterm_does_not_cut_the_stop_short() -> None:
    """`timeout` sends two; whoever is out of patience has Ctrl-C and SIGKILL."""
    stops: list[str] = []
    with stopped_by_signals(lambda: stops.append("stop")):
        for _ in range(3):
            signal.raise_signal(signal.SIGTERM)
    assert stops == ["stop"]


def test_who_cannot_reload_leaves_that_signal_alone() -> None:
    with stopped_by_signals(lambda: None):
        assert signal.getsignal(signal.SIGHUP) == signal.SIG_DFL
    with stopped_by_signals(lambda: None, lambda: None):
        assert callable(signal.getsignal(signal.SIGHUP))


def test_every_wish_to_reload_is_heard() -> None:
    reloads = []
    with stopped_by_signals(lambda: None, lambda: reloads.append("again")):
        for _ in range(2):
            signal.raise_signal(signal.SIGHUP)
    assert reloads == ["again"] * 2
