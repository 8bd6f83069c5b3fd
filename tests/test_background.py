"""What fails beside a test is told at once, not when the test has waited long enough for what it was to do."""

from queue import Queue

import pytest

from background import in_background
from program import PATIENCE_S, next_of, until


def fail() -> None:
    raise ZeroDivisionError


def test_what_ends_a_thread_is_raised_where_something_is_waited_for() -> None:
    with pytest.raises(ZeroDivisionError), in_background(fail, list, PATIENCE_S):
        until(lambda: False)
    with pytest.raises(ZeroDivisionError), in_background(fail, list, PATIENCE_S):
        next_of(Queue())
    until(lambda: True)


def test_what_ends_a_thread_that_nothing_was_waited_for_of_is_raised_at_the_end() -> None:
    with pytest.raises(ZeroDivisionError), in_background(fail, list, PATIENCE_S):
        pass
