"""Drives of the simulated wagon, and a judge that knows their truth."""

from dataclasses import dataclass
from functools import cache
from itertools import chain

import msgspec
import numpy as np

from brake_monitor.estimation.estimate import Estimate, Status
from brake_monitor.frame import Frame
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.settings.config import Settings
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.scenarios import Profile, Scenario, steps
from brake_monitor.simulator.simulate import EPOCH_S, Recording
from brake_monitor.simulator.simulate import run as simulate
from brake_monitor.validation.scores import longest_s
from brake_monitor.validation.series import Truth

END_S = 27.0
DRY = Scenario(
    name="two brakings",
    summary="coast, brake from 5 to 13 s, coast, brake from 17 s until the end; nothing slides",
    initial_speed_mps=32.0,
    duration_s=END_S,
    demand=steps((5.0, 0.6), (13.0, 0.0), (17.0, 0.6)),
    rail_over_time=Profile(((0.0, 0.45),)),
)
SLIDE = Scenario(
    name="slide",
    summary="coast, brake from 5 s, slide between 6 and 15 s, good rail, release at 17.5 s, brake from 20 s",
    initial_speed_mps=32.0,
    duration_s=END_S,
    demand=steps((5.0, 1.0), (17.5, 0.0), (20.0, 0.5)),
    rail_over_time=Profile(((5.0, 0.3), (6.0, 0.05), (14.0, 0.05), (15.0, 0.3))),
)
SILENCE_TOLD_S = 0.1  # how often the service tells the pipeline that nothing arrived
NO_MODIFIERS = Modifiers()


@cache
def drive(scenario: Scenario, modifiers: Modifiers = NO_MODIFIERS) -> Recording:
    """Simulate with the example wagon, once for all tests."""
    return simulate(scenario, example_settings("wagon"), seed=5, modifiers=modifiers)


def play(settings: Settings, frames: list[Frame]) -> list[Estimate]:
    """What is said of the frames by an estimator that knows nothing yet."""
    return play_to(Pipeline.from_settings(settings), frames)


def play_to(pipeline: Pipeline, frames: list[Frame]) -> list[Estimate]:
    """Feed the frames as the service does: it also tells when nothing arrives."""
    outputs, last_s = [], frames[0].time_s
    for frame in frames:
        if SILENCE_TOLD_S < frame.time_s - last_s < 60.0:
            outputs += [pipeline.advance(t) for t in np.arange(last_s, frame.time_s, SILENCE_TOLD_S).tolist()[1:]]
        outputs.append(pipeline.step(frame))
        last_s = frame.time_s
    return [output.estimate for output in outputs if output.estimate is not None]


@dataclass(frozen=True)
class Judged:
    """What was said beside the truth; shapes (K,) and (K, N). Times count from the drive's beginning."""

    told: list[Estimate]
    time_s: np.ndarray
    truth: Truth
    adhesion_error: np.ndarray
    friction_error: np.ndarray

    @classmethod
    def of(cls, recording: Recording, told: list[Estimate], clock_error_s: np.ndarray | float = 0.0) -> "Judged":
        """`clock_error_s`: by how much the estimates' times are ahead, when the clock was set meanwhile."""
        time_s = np.array([e.time_s for e in told]) - EPOCH_S - clock_error_s
        truth = Truth.at(time_s, recording.trace)
        adhesion = np.array([e.adhesion for e in told])
        friction = np.array([[w.friction for w in e.wheelsets] for e in told])
        return cls(told, time_s, truth, adhesion - truth.adhesion, friction - truth.friction)

    def during(self, from_s: float, to_s: float = END_S) -> "Judged":
        """The part of it in this span."""
        now = (self.time_s >= from_s) & (self.time_s < to_s)
        truth = Truth(**{name: value[now] for name, value in vars(self.truth).items()})
        told = [e for e, kept in zip(self.told, now, strict=True) if kept]
        return Judged(told, self.time_s[now], truth, self.adhesion_error[now], self.friction_error[now])

    @property
    def statuses(self) -> set[Status]:
        return {e.status for e in self.told}

    @property
    def reasons(self) -> set[str]:
        return set(chain.from_iterable(e.reasons for e in self.told))

    @property
    def rmse(self) -> float:
        return float(np.sqrt(np.mean(self.adhesion_error**2)))

    @property
    def worst(self) -> float:
        return float(np.max(np.abs(self.adhesion_error)))

    def friction_statuses(self, wheelset: int) -> set[Status]:
        return {e.wheelsets[wheelset].friction_status for e in self.told}

    def worst_friction(self) -> float:
        """Of what is said to be valid."""
        valid = np.array([[w.friction_status is Status.VALID for w in e.wheelsets] for e in self.told])
        return float(np.max(np.abs(self.friction_error[valid]), initial=0.0))

    def adhesion_dishonest_s(self) -> float:
        """Longest time of adhesion being `valid` and yet wrong by more than three of its standard deviations."""
        valid = np.array([e.status is Status.VALID for e in self.told])
        std = np.array([e.adhesion_std for e in self.told])
        return longest_s(self.time_s, valid & (np.abs(self.adhesion_error) > 3.0 * std))

    def friction_dishonest_s(self) -> float:
        """The same of friction, in the worst wheelset."""
        valid = np.array([[w.friction_status is Status.VALID for w in e.wheelsets] for e in self.told])
        std = np.array([[w.friction_std for w in e.wheelsets] for e in self.told])
        dishonest = valid & (np.abs(self.friction_error) > 3.0 * std)
        return max(longest_s(self.time_s, wheelset) for wheelset in dishonest.T)

    def assert_sound(self) -> None:
        """Every number is finite, every uncertainty bounded."""
        for estimate in self.told:
            assert np.isfinite(numbers(estimate)).all(), estimate
            assert estimate.adhesion_std < 0.2
            assert estimate.deceleration_std_mps2 < 1.0
            assert all(0.0 <= w.friction_std < 0.2 and w.adhesion_std < 0.3 for w in estimate.wheelsets)

    def assert_honest(self) -> None:
        """Never `valid` and wrong by more than three standard deviations for longer than a second."""
        assert self.adhesion_dishonest_s() <= 1.0
        assert self.friction_dishonest_s() <= 1.0


def numbers(estimate: Estimate) -> list[float]:
    """Every number in an estimate."""
    flat = msgspec.to_builtins(estimate)
    every = [*flat.values(), *chain.from_iterable(wheelset.values() for wheelset in flat["wheelsets"])]
    return [value for value in every if isinstance(value, float | int)]
