"""The normalised innovation, which is published: it tells whether model and sensors agree."""

import numpy as np

from drives import DRY, END_S, drive, play
from faults import changed

AGREE = (0.5, 1.5)  # mean over a drive; its expectation is 1
NOISE_KMH = 0.036  # of a wheel speed, as wagon.toml has it


def test_it_is_about_1_when_model_and_sensors_agree() -> None:
    recording = drive(DRY)
    told = play(recording.settings, list(recording.frames))
    assert AGREE[0] < np.mean([e.nis for e in told]) < AGREE[1]


def test_it_is_larger_where_a_sensor_is_noisier_than_configured() -> None:
    recording = drive(DRY)
    noise_kmh = np.random.default_rng(1).normal(0.0, 3.0 * NOISE_KMH, 30_000)
    noisier = changed("WSP", ("n_B",), lambda time_s, kmh: kmh + noise_kmh[int(time_s * 1000)], 0.0, END_S)
    told = play(recording.settings, noisier(list(recording.frames)))
    assert np.mean([e.nis for e in told]) > AGREE[1]
