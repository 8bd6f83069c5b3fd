"""A search over positive numbers of unknown magnitude that needs no derivatives.

Coordinate steps that grow on success and turn back shortened on failure, after Rosenbrock, Computer Journal 3 (1960)
175-184, without turning the axes: a density's effect hardly depends on the others', one trial is one evaluation
whatever their number, and the best point so far is never given up.
"""

from collections.abc import Callable, Iterator
from typing import NamedTuple

FIRST_STEP = 0.5  # decades: a factor of about three
LONGEST_STEP = 1.0
LAST_STEP = 0.06  # decades: 15 % more or less make no difference
REACH = 3.0  # decades from the start; beyond, a number says "none" or "any"

Point = tuple[float, ...]


class Found(NamedTuple):
    """The best point so far."""

    point: Point
    cost: float
    evaluations: int  # spent so far


def descend(start: Point, cost: Callable[[Point], float], least_gain: float, evaluations: int) -> Iterator[Found]:
    """Search from `start`; give the best so far after each evaluation, the first of which is the start itself.

    A point is better when it costs less by more than `least_gain`. Ends after so many evaluations, or when no step
    down to LAST_STEP helps any more. All points but the start have two significant digits.
    """
    best, lowest, spent = start, cost(start), 1
    yield Found(best, lowest, spent)
    improved = True
    while improved:
        improved = False
        steps = [FIRST_STEP] * len(start)
        while any(abs(step) >= LAST_STEP for step in steps):
            for i, step in enumerate(steps):
                if abs(step) < LAST_STEP:
                    continue
                if spent == evaluations:
                    return
                tried = (*best[:i], _moved(best[i], step, start[i]), *best[i + 1 :])
                found, spent = cost(tried), spent + 1
                if found < lowest - least_gain:
                    best, lowest, improved = tried, found, True
                    steps[i] = max(-LONGEST_STEP, min(2.0 * step, LONGEST_STEP))
                else:
                    steps[i] = -0.5 * step
                yield Found(best, lowest, spent)


def _moved(value: float, step: float, start: float) -> float:
    """`value` changed by `step` decades, within REACH of the start, rounded to two significant digits."""
    reach = 10.0**REACH
    return float(f"{min(max(value * 10.0**step, start / reach), start * reach):.1e}")
