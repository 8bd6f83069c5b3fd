"""In steady braking the deceleration changes: line or pads, nothing tells which, so that the intervals have to."""

import numpy as np
import pytest

from drives import Judged
from test_returning_friction import stopped

STEADY_S = 8.0  # from then on
END_S = 28.0


def share_within(seen: Judged) -> tuple[float, float]:
    """How much of the time the 95 % intervals of adhesion and friction hold the truth."""
    adhesion = np.abs(seen.adhesion_error) < [1.96 * e.adhesion_std for e in seen.told]
    friction = np.abs(seen.friction_error) < [[1.96 * own.friction_std for own in e.wheelsets] for e in seen.told]
    return float(np.mean(adhesion)), float(np.mean(friction))


@pytest.mark.parametrize(
    "friction",
    [((0.0, 0.85), (6.0, 0.85), (14.0, 1.0)), ((0.0, 1.0), (8.0, 1.0), (14.0, 0.88))],
    ids=["discs that dry slowly", "pads that fade"],
)
def test_intervals_hold_the_truth_while_pads_change_slowly(friction: tuple[tuple[float, float], ...]) -> None:
    within = share_within(stopped(friction).during(STEADY_S, END_S))
    assert min(within) >= 0.9, within


def test_where_nothing_changes_nothing_is_doubted() -> None:
    seen = stopped(((0.0, 1.0),)).during(STEADY_S, END_S)
    assert min(share_within(seen)) >= 0.95
    known_std = [own.friction_std for own in seen.told[0].wheelsets]
    assert all(own.friction_std < 1.5 * std for e in seen.told for own, std in zip(e.wheelsets, known_std, strict=True))
