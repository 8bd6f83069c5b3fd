"""Recordings spread over processes: each keeps them all and scores one at a time."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial, reduce
from operator import add

from brake_monitor.estimation.model.tuning import Tuning
from brake_monitor.host.processes import Crew
from brake_monitor.tuner.recording import Recording
from brake_monitor.tuner.scores import Judge, Score

_given: list[tuple[Judge, Sequence[Recording]]] = []  # in a worker: what it was started with


@contextmanager
def scoring(judge: Judge, recordings: Sequence[Recording], jobs: int) -> Iterator[Callable[[Tuning], Score]]:
    """Give a function that scores a tuning over all recordings, with at most one process for each."""
    jobs = min(jobs, len(recordings))
    if jobs == 1:
        yield lambda tuning: reduce(add, (judge.score(recording, tuning) for recording in recordings))
        return
    with Crew(jobs, _begin, judge, recordings) as crew:

        def score(tuning: Tuning) -> Score:
            scores = dict(crew.each(partial(_score, tuning), range(len(recordings))))
            return reduce(add, (scores[place] for place in range(len(recordings))))  # floats add up in one order

        yield score


def _begin(judge: Judge, recordings: Sequence[Recording]) -> None:
    _given.append((judge, recordings))


def _score(tuning: Tuning, place: int) -> Score:
    ((judge, recordings),) = _given
    return judge.score(recordings[place], tuning)
