"""How many processes score."""

from types import SimpleNamespace
from typing import Any

import pytest

from brake_monitor.tuner import workers
from brake_monitor.tuner.scores import Likelihood


@pytest.mark.parametrize(("count", "jobs"), [(3, 1), (1, 4)])
def test_one_job_or_one_recording_needs_no_other_process(
    monkeypatch: pytest.MonkeyPatch, count: int, jobs: int
) -> None:
    monkeypatch.setattr(workers, "Crew", pytest.fail)
    judge: Any = SimpleNamespace(score=lambda recording, tuning: Likelihood(1, recording * tuning))
    recordings: Any = [1.0, 2.0, 4.0][:count]
    with workers.scoring(judge, recordings, jobs) as score:
        tuning: Any = 10.0
        assert score(tuning) == Likelihood(count, 10.0 * sum(recordings))
