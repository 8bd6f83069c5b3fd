"""One simulated run of the plant, and every estimator that is to be judged on it."""

from collections.abc import Container, Iterable
from dataclasses import replace
from itertools import groupby

from msgspec import Struct

from brake_monitor.decoding.sample_block import SampleBlock
from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.frame_block import FrameBlock
from brake_monitor.processing.whole_recording import all_samples, take_all
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.scenarios import Scenario
from brake_monitor.simulator.simulate import Recording
from brake_monitor.simulator.simulate import run as simulate
from brake_monitor.validation.cases import Case
from brake_monitor.validation.scores import Score
from brake_monitor.validation.series import Series
from brake_monitor.validation.variants import variant_estimator
from brake_monitor.validation.vehicles import campaign_settings


class Outcome(Struct, frozen=True):
    """What one run gave for one case."""

    case: Case
    seed: int
    score: Score
    series: Series | None


class Task(Struct, frozen=True):
    """Cases that share one run of the plant: they differ only in estimator and lost frames."""

    cases: tuple[Case, ...]
    seed: int

    def judge(self, drawn: Container[Case]) -> list[Outcome]:
        """Simulate once and judge each case; the same task gives the same numbers.

        The series of the first seed goes along for the cases that are to be `drawn`.
        """
        return [
            Outcome(case, self.seed, Score.of(series), series if self.seed == 0 and case in drawn else None)
            for case, series in self.series().items()
        ]

    def series(self) -> dict[Case, Series]:
        """Simulate once and estimate for each case."""
        first = self.cases[0]
        recording = drive(first.driven(self.seed), first.vehicle, _of_the_plant(first), self.seed)
        found: dict[Case, Series] = {}
        for modifiers, some in groupby(self.cases, key=lambda case: case.modifiers):
            told = replace(recording, modifiers=modifiers)
            samples = _samples(told)
            found |= {case: _estimate(told, samples, case.variant) for case in some}
        return found


def tasks(cases: Iterable[Case], seeds: int) -> list[Task]:
    """All runs that the cases need, each once."""
    by_plant: dict[tuple[str, Scenario, Modifiers], set[Case]] = {}
    for case in cases:
        by_plant.setdefault((case.vehicle, case.driven(0), _of_the_plant(case)), set()).add(case)
    return [Task(tuple(sorted(served)), seed) for served in by_plant.values() for seed in range(seeds)]


def drive(scenario: str | Scenario, vehicle: str, modifiers: Modifiers, seed: int) -> Recording:
    """Run the plant for one of the campaign's vehicles."""
    return simulate(scenario, campaign_settings(vehicle), seed, modifiers)


def estimate(recording: Recording, variant: str) -> Series:
    """Play the recorded frames to a variant of the estimator; one estimate per frame that was fused, no rules."""
    return _estimate(recording, _samples(recording), variant)


def _estimate(recording: Recording, samples: SampleBlock, variant: str) -> Series:
    estimator = variant_estimator(recording, variant, samples.channels)
    return Series.of(take_all(estimator, samples), recording.trace)


def _samples(recording: Recording) -> SampleBlock:
    return all_samples(SignalDecoder.from_settings(recording.settings), [FrameBlock.of(recording.frames)])


def _of_the_plant(case: Case) -> Modifiers:
    """The modifiers without what sensors make of it, and what happens to frames on their way."""
    return replace(case.modifiers, run_out=0.0, frame_loss=0.0)
