"""A recording at once: the same samples as frame by frame, and the same that is known, with machine code or without."""

from functools import cache

import numpy as np
import pytest
from msgspec.structs import replace

from brake_monitor.alarm_campaign.drives import Drive
from brake_monitor.decoding.sample_block import SampleBlock
from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.estimation.estimator import Estimator
from brake_monitor.estimation.model.tuning import TRAIN, WAGON, Tuning
from brake_monitor.frame import Frame
from brake_monitor.frame_block import FrameBlock
from brake_monitor.processing import whole_recording
from brake_monitor.processing.whole_recording import Known, all_samples, take_all
from brake_monitor.samples import Quality
from brake_monitor.settings.config import Settings
from machine_code import by_machine_code

BLOCK = 3000
SLIDING = "wagon/wsp/0"
SILENT = "wagon/silent/0"
# Slides; signals that fail, come back, say what cannot be; a bus that is silent for a while.
DRIVES = (SLIDING, "bogie/lost-wheel-speeds/0", SILENT)
FEW = 12_000  # frames


@cache
def driven(path: str) -> tuple[Settings, list[Frame]]:
    vehicle, name, seed = path.split("/")
    recording = Drive(vehicle, name, int(seed)).simulate()
    return recording.settings, list(recording.frames)[:FEW]


@pytest.fixture(scope="module", params=DRIVES)
def drive(request: pytest.FixtureRequest) -> tuple[Settings, list[Frame]]:
    return driven(request.param)


def samples_of(settings: Settings, frames: list[Frame], size: int = BLOCK) -> SampleBlock:
    blocks = [FrameBlock.of(frames[begin : begin + size]) for begin in range(0, len(frames), size)]
    return all_samples(SignalDecoder.from_settings(settings), blocks)


def one_by_one(settings: Settings, frames: list[Frame]) -> list[str]:
    """The samples in words: NaN is not equal to itself."""
    decoder, found = SignalDecoder.from_settings(settings), []
    for frame in frames:
        if decoded := decoder.decode(frame):
            found += [*decoder.expire(frame.time_s), *decoded]
    return [str(sample) for sample in found]


def test_all_samples_are_those_of_frame_after_frame(drive: tuple[Settings, list[Frame]]) -> None:
    assert [str(sample) for sample in samples_of(*drive).samples] == one_by_one(*drive)


def test_nor_does_it_matter_where_a_block_ends() -> None:
    """Here the silence lies between two."""
    settings, frames = driven(SILENT)
    silence = int(np.argmax(np.diff([frame.time_s for frame in frames]))) + 1
    found = samples_of(settings, frames[: 2 * silence], silence)
    assert [str(sample) for sample in found.samples] == one_by_one(settings, frames[: 2 * silence])


def test_some_of_them_are_stale() -> None:
    assert np.count_nonzero(samples_of(*driven(SILENT)).quality == Quality.STALE) >= 3


def known(settings: Settings, frames: list[Frame], every_s: float) -> tuple[Estimator, Known]:
    samples = samples_of(settings, frames)
    estimator = Estimator(settings.vehicle, settings.estimator, samples.channels)
    return estimator, take_all(estimator, samples, every_s)


@pytest.mark.parametrize("every_s", [0.0, 0.05])
def test_machine_code_knows_the_same(
    drive: tuple[Settings, list[Frame]], every_s: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(whole_recording, "with_machine_code", lambda _: None)
    plain, expected = known(*drive, every_s)
    monkeypatch.setattr(whole_recording, "with_machine_code", by_machine_code)
    compiled, found = known(*drive, every_s)
    assert len(expected.rows) > 300
    np.testing.assert_allclose(found.rows, expected.rows, rtol=1e-9, atol=1e-12)
    assert compiled.reset_count == plain.reset_count
    assert compiled.estimate().status is plain.estimate().status


def test_what_is_known_is_what_the_estimator_says_after_each_frame(drive: tuple[Settings, list[Frame]]) -> None:
    settings, frames = drive
    decoder, (_, found) = SignalDecoder.from_settings(settings), known(*drive, 0.0)
    estimator = Estimator(settings.vehicle, settings.estimator, decoder.channels)
    rows = {time_s: row for row, time_s in enumerate(found.wagon("time_s").tolist())}
    fused = 0
    for frame in frames:
        decoded = decoder.decode(frame)
        taken = [estimator.take(sample) for sample in (*(decoder.expire(frame.time_s) if decoded else ()), *decoded)]
        if any(taken):
            fused += 1
            row, said = rows[frame.time_s], estimator.estimate()
            assert found.wagon("adhesion")[row] == pytest.approx(said.adhesion, rel=1e-9)
            assert found.wagon("adhesion_std")[row] == pytest.approx(said.adhesion_std, rel=1e-9)
            assert found.each("friction")[row].tolist() == pytest.approx([w.friction for w in said.wheelsets])
            assert found.each("slip")[row].tolist() == pytest.approx([w.slip for w in said.wheelsets], abs=1e-9)
    assert fused > 0.99 * len(rows)  # the others had outliers alone


def test_with_a_delay_as_much_is_known() -> None:
    """Readings are fused when others have come, at times that no frame has."""
    settings, frames = driven(SLIDING)
    delayed = replace(settings.signals, speed=replace(settings.signals.speed, delay_s=0.05))
    _, at_once = known(settings, frames, 0.0)
    _, found = known(replace(settings, signals=delayed), frames, 0.0)
    times_s = found.wagon("time_s")
    assert np.all(np.diff(times_s) > 0.0)
    assert frames[-1].time_s - times_s[-1] < 0.1
    assert len(times_s) > 0.7 * len(at_once.rows)


def test_machine_code_foretells_the_same_with_any_densities(monkeypatch: pytest.MonkeyPatch) -> None:
    settings, frames = driven(SLIDING)
    samples = samples_of(settings, frames)

    def foretold(tuning: Tuning) -> tuple[int, float]:
        estimator = Estimator(settings.vehicle, settings.estimator, samples.channels, tuning, foretells=True)
        take_all(estimator, samples)
        return estimator.core.foretold.readings, estimator.core.foretold.nats

    tunings = (WAGON, TRAIN, replace(WAGON, friction=1e-3, speed=0.0, deceleration_per_metre=0.0))
    monkeypatch.setattr(whole_recording, "with_machine_code", lambda _: None)
    plain = list(map(foretold, tunings))
    monkeypatch.setattr(whole_recording, "with_machine_code", by_machine_code)
    for (readings, nats), (expected_readings, expected_nats) in zip(map(foretold, tunings), plain, strict=True):
        assert readings == expected_readings > 1000
        assert nats == pytest.approx(expected_nats, rel=1e-9)
    assert len({nats for _, nats in plain}) == len(tunings)
