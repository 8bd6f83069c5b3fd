"""In steady braking the deceleration changes: line or pads, nothing tells which, so that the intervals have to."""

import numpy as np
import pytest

from brake_monitor.simulator.brake_faults import BrakeFault
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.scenarios import Profile, Scenario, steps
from drives import Judged, drive, play

STEADY_S = 8.0  # from then on
END_S = 28.0
STOP = Scenario(
    name="a long stop",
    summary="coast, brake from 5 s until the end; nothing slides",
    initial_speed_mps=33.0,
    duration_s=30.0,
    demand=steps((5.0, 0.7)),
    rail_over_time=Profile(((0.0, 0.45),)),
)


def stopped(friction: tuple[tuple[float, float], ...]) -> Judged:
    """`friction`: over that of dry pads, over time."""
    recording = drive(STOP, Modifiers(brake_faults=(BrakeFault(friction=Profile(friction)),)))
    return Judged.of(recording, play(recording.settings, list(recording.frames))).during(STEADY_S, END_S)


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
    within = share_within(stopped(friction))
    assert min(within) >= 0.9, within


def test_where_nothing_changes_nothing_is_doubted() -> None:
    seen = stopped(((0.0, 1.0),))
    assert min(share_within(seen)) >= 0.95
    known_std = [own.friction_std for own in seen.told[0].wheelsets]
    assert all(own.friction_std < 1.5 * std for e in seen.told for own, std in zip(e.wheelsets, known_std, strict=True))
