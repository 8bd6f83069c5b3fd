"""A wagon that reverses is its mirror image, as a speed with a sign tells: braking loads its other end."""

from collections.abc import Callable, Iterable
from functools import cache

import numpy as np
import pytest
from msgspec.structs import replace

from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.estimation.estimate import Estimate
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.samples import Quantity, Sample
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.scenarios import Profile, Scenario, steps
from brake_monitor.simulator.simulate import EPOCH_S
from brake_monitor.simulator.simulate import run as simulate

BRAKED_S = 6.0
PAUSE_S = 3600.0
BRAKING = Scenario(
    name="braking",
    summary="coast, brake from 3 s, slide from 8 s",
    initial_speed_mps=24.0,
    duration_s=14.0,
    demand=steps((3.0, 0.8)),
    rail_over_time=Profile(((8.0, 0.3), (8.5, 0.05))),
)
BOGIE = example_settings("bogie")
SYMMETRIC = {"wheel_radius_m": (0.457,) * 4, "wheelsets_per_bogie": 2, "pivot_height_m": 0.9}
ON_BOGIES = replace(BOGIE, vehicle=replace(BOGIE.vehicle, **SYMMETRIC))
LAST = len(ON_BOGIES.vehicle.axle_positions_m) - 1
OF_WHEELSETS = (Quantity.AXLE_SPEED, Quantity.PRESSING_FORCE)


@cache
def samples() -> tuple[Sample, ...]:
    decoder = SignalDecoder.from_settings(ON_BOGIES)
    return tuple(s for frame in simulate(BRAKING, ON_BOGIES, seed=5).frames for s in decoder.decode(frame))


def told(given: Iterable[Sample], every: int = 50) -> list[Estimate]:
    estimator = Pipeline.from_settings(ON_BOGIES).estimator
    found = []
    for number, sample in enumerate(given):
        estimator.take(sample)
        if number % every == 0:
            found.append(estimator.estimate())
    return found


def turned_round(signed: Callable[[Sample], bool]) -> list[Sample]:
    """The same drive with the last wheelset first; `signed`: whether a sample is told with its sign."""
    turned = []
    for sample in samples():
        wheelset = LAST - sample.wheelset if sample.quantity in OF_WHEELSETS else sample.wheelset
        turned.append(sample._replace(wheelset=wheelset, value=-sample.value if signed(sample) else sample.value))
    return turned


def by_wheelset(estimates: list[Estimate]) -> np.ndarray:
    """Adhesion, its deviation, and friction; shape (K, N, 3)."""
    return np.array([[(w.adhesion, w.adhesion_std, w.friction) for w in e.wheelsets] for e in estimates])


def is_speed(sample: Sample) -> bool:
    return sample.quantity is Quantity.SPEED


SIGNED = {
    "vehicle speed": is_speed,
    "wheel speed": lambda sample: sample.quantity is Quantity.AXLE_SPEED and sample.wheelset == 0,
    "all": lambda sample: sample.quantity in (Quantity.SPEED, Quantity.AXLE_SPEED),
}


def apart(found: list[Estimate], forwards: list[Estimate]) -> float:
    """By how much adhesion of single wheelsets differs at the most."""
    return float(np.abs(by_wheelset(found) - by_wheelset(forwards))[..., 0].max())


@pytest.mark.parametrize("which", SIGNED)
def test_who_reverses_is_told_as_who_runs_forwards_with_the_other_end_first(which: str) -> None:
    forwards, reversing = by_wheelset(told(samples())), by_wheelset(told(turned_round(SIGNED[which])))
    assert reversing[:, ::-1] == pytest.approx(forwards, abs=1e-6)


def test_without_a_sign_a_wheelset_that_leads_seems_to_grip_more() -> None:
    """By more than the published interval allows for: it is loaded more than a wagon that runs forwards loads it."""
    forwards, reversing = by_wheelset(told(samples())), by_wheelset(told(turned_round(lambda sample: False)))
    apart_by = np.abs(reversing[:, ::-1] - forwards)[..., 0]
    assert (apart_by / forwards[..., 1]).max() > 1.96


@pytest.mark.parametrize("which", SIGNED)
def test_who_runs_forwards_again_is_loaded_at_its_first_end_again(which: str) -> None:
    again = [sample._replace(time_s=sample.time_s + PAUSE_S) for sample in samples()]
    after_reversing = told([*turned_round(SIGNED[which]), *again])
    after_forwards = told([*samples(), *again])
    half = len(after_forwards) // 2 + 1
    assert apart(after_reversing[half:], after_forwards[half:]) < 0.001


def test_a_spike_below_zero_turns_no_wagon_round() -> None:
    """Not even as the last thing that its sensor says: it is rejected as one above zero is."""
    until_s = next(sample.time_s for sample in samples() if is_speed(sample) and sample.time_s > EPOCH_S + BRAKED_S)
    told_until = [sample for sample in samples() if not is_speed(sample) or sample.time_s <= until_s]
    below, above = (
        [s._replace(value=times * s.value) if is_speed(s) and s.time_s == until_s else s for s in told_until]
        for times in (-3.0, 3.0)
    )
    assert apart(told(below), told(above)) < 1e-9
