"""A vehicle speed that scatters far beyond its noise, as with an aerial that is covered, in a train.

There d is free to follow a coupler. If it followed a few readings far beyond what any wagon does, the prediction would
leave the readings from one to the next, only those that happen to lie its way would be believed, and it would run away.
"""

from math import inf

import numpy as np
import pytest
from msgspec.structs import replace

from drives import DRY, Judged, drive, play
from faults import changed

FROM_S = 5.0
AS_FAST_MPS2 = 3.0  # beyond its brakes no wagon slows down or gains more
UNCORRECTED_S = 0.15  # three readings, by when even outliers are believed


@pytest.mark.parametrize("std_mps", [0.6, 1.0])
@pytest.mark.parametrize("seed", range(2))
def test_the_speed_of_a_wagon_in_a_train_stays_with_readings_that_scatter(std_mps: float, seed: int) -> None:
    recording = drive(DRY)
    settings = replace(recording.settings, estimator=replace(recording.settings.estimator, preset="train"))
    rng = np.random.default_rng(seed)
    errors_mps: list[float] = []

    def scattered(_: float, speed_mps: float) -> float:
        errors_mps.append(rng.normal(0.0, std_mps))
        return speed_mps + errors_mps[-1]

    frames = changed("GNSS", ("v_ground",), scattered, FROM_S, inf)(list(recording.frames))
    judged = Judged.of(recording, play(settings, frames)).during(FROM_S)
    off_mps = np.abs([e.speed_mps for e in judged.told] - judged.truth.speed_mps)
    assert off_mps.max() <= np.abs(errors_mps).max() + AS_FAST_MPS2 * UNCORRECTED_S
