"""What a fit goes by: each figure from numbers made by hand."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.estimation.core.readout import width
from brake_monitor.estimation.model.tuning import WAGON
from brake_monitor.processing.whole_recording import Known
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.tuner import scores
from brake_monitor.tuner.recording import Recording, Truth
from brake_monitor.tuner.scores import Accuracy, Judge, Likelihood
from brake_monitor.validation.scores import Sums


def test_a_likelihood_is_told_as_means_of_a_reading() -> None:
    assert list(Likelihood(4, 8.0, -1.0).told().values()) == ["2.000", "1.750"]


def of_errors(rmse: float, coverage: float) -> Sums:
    """Of a hundred alike, of whose intervals so many hold the truth."""
    std = np.where(np.arange(100) < 100 * coverage, 1.0, 1e-6)
    return Sums.of(np.full(100, rmse), std)


@pytest.mark.parametrize(
    ("adhesion", "friction", "cost"),
    [
        (of_errors(0.002, 0.95), Sums(), 1.0),
        (of_errors(0.004, 0.95), of_errors(0.010, 0.95), 3.0),
        (of_errors(0.002, 0.95), of_errors(0.010, 0.80), 3.0),
        (of_errors(0.002, 1.0), Sums(), 1.1),
    ],
)
def test_an_accuracy_costs_its_errors_in_their_aims_and_what_its_intervals_lack(
    adhesion: Sums, friction: Sums, cost: float
) -> None:
    assert Accuracy(adhesion, friction).cost == pytest.approx(cost)


def estimated(wagon: dict[str, object], each: dict[str, object], count: int) -> Known:
    """So many instants of a wagon with two wheelsets."""
    rows = np.zeros((count, width(2)))
    known = Known(rows)
    for name, values in wagon.items():
        known.wagon(name)[:] = values
    for name, values in each.items():
        known.each(name)[:] = values
    return known


@pytest.mark.parametrize(("truth_from_s", "count"), [(0.0, 3), (4.5, 2)])
def test_estimates_are_judged_within_the_truths_time_once_settled_while_the_wagon_moves_and_pads_press(
    monkeypatch: pytest.MonkeyPatch, truth_from_s: float, count: int
) -> None:
    time_s = np.array([0.0, 2.9, 3.0, 4.0, 5.0, 6.0, 7.0])
    is_judged = np.array([False, False, True, False, True, True, False])
    presses = np.array([is_judged, is_judged & (time_s != 5.0)]).T
    truth = Truth(Path("a.csv"), np.array([truth_from_s, 6.5]), np.array([0.1, 0.1]), np.array([[0.3, 0.4]] * 2))
    known = estimated(
        {
            "time_s": time_s,
            "speed_mps": np.where(time_s == 4.0, 1.5, 20.0),
            "adhesion": 0.1 + np.where(is_judged, 0.002, 1.0),
            "adhesion_std": 0.01,
        },
        {
            "friction": np.array([0.3, 0.4]) + np.where(presses, [0.01, 0.02], 1.0),
            "friction_std": [0.1, 0.001],
            "pressing_force_n": np.where(presses, 40_000.0, 4000.0),
        },
        len(time_s),
    )
    monkeypatch.setattr(scores, "take_all", lambda *_: known)
    settings = example_settings("wagon")
    judge = Judge(settings.vehicle, settings.estimator, SignalDecoder.from_settings(settings).channels)
    score = judge.score(Recording(SimpleNamespace(time_s=time_s), truth), WAGON)
    assert isinstance(score, Accuracy)
    assert (score.adhesion.count, score.adhesion.covered) == (count, count)
    assert score.adhesion.rmse == pytest.approx(0.002)
    assert (score.friction.count, score.friction.covered) == (2 * count - 1, count)
    assert score.friction.square == pytest.approx(count * 0.01**2 + (count - 1) * 0.02**2)
