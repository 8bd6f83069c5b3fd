"""Friction and adhesion where the line does what d does to the filter: a random walk of the way.

There the filter's own P, linearised at its estimate, is the posterior Cramér-Rao bound: who does not know the line can
do no better on average. A plant that shares no code with the filter drives it; a filter that were over-confident, or
left something of what the sensors tell unused, would err by more than it says.
"""

from functools import cache

import numpy as np
import pytest

from brake_monitor.validation.cases import Case
from brake_monitor.validation.runs import Task
from brake_monitor.validation.scores import Sums, judged, pressed

SEEDS = {"as_modelled": 4, "undulating": 20}  # a line of its own each
WITHIN = 1.2  # of the bound


@cache
def slides(condition: str) -> tuple[Sums, Sums, float]:
    """Errors of adhesion, those of friction, and the root mean square of the deviations stated for these."""
    case = Case("wagon", "wsp", condition, "wagon")
    adhesion, friction, variances = Sums(), Sums(), []
    for seed in range(SEEDS[condition]):
        (series,) = Task((case,), seed).series().values()
        then, where = judged(series), pressed(series)
        adhesion += Sums.of((series.adhesion - series.truth.adhesion)[then], series.adhesion_std[then])
        friction += Sums.of((series.friction - series.truth.friction)[where], series.friction_std[where])
        variances.append(series.friction_std[where] ** 2)
    return adhesion, friction, float(np.sqrt(np.mean(np.concatenate(variances))))


@pytest.mark.parametrize("condition", SEEDS)
def test_friction_is_known_as_well_as_the_line_lets_it_be(condition: str) -> None:
    _, friction, bound = slides(condition)
    assert friction.rmse <= WITHIN * bound


def test_the_intervals_hold_the_truth_as_often_as_they_say() -> None:
    adhesion, friction, _ = slides("undulating")
    assert 0.90 <= adhesion.coverage <= 0.99
    assert 0.90 <= friction.coverage <= 0.995  # the bound allows for more than what is left of it
