"""What is thought of each signal in view of all the others, by hand-made readings and estimates."""

from collections.abc import Mapping, Sequence
from math import inf
from types import MappingProxyType

import pytest
from msgspec.structs import replace

from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.estimation.doubts.consistency import Doubt
from brake_monitor.estimation.estimate import Estimate
from brake_monitor.monitoring.creep_meter import CreepMeter
from brake_monitor.monitoring.inputs.dead_forces import DIED_S
from brake_monitor.monitoring.inputs.input_judge import InputJudge
from brake_monitor.monitoring.inputs.scatter_watch import TOLD_S
from brake_monitor.monitoring.inputs.wheel_state import WheelState
from brake_monitor.samples import Channel, InputCondition, Measurand, Quality, Quantity, Sample
from brake_monitor.settings.config import Settings
from brake_monitor.settings.example_vehicles import example_settings
from estimates import estimate, wheelset

GOOD, LOST, REPEATED = InputCondition.GOOD, InputCondition.LOST, InputCondition.REPEATED
OUT_OF_RANGE, SCATTERED = InputCondition.OUT_OF_RANGE, InputCondition.SCATTERED
SPEED: Measurand = (Quantity.SPEED, 0)
WHEELS: list[Measurand] = [(Quantity.AXLE_SPEED, i) for i in range(4)]
FORCES: list[Measurand] = [(Quantity.PRESSING_FORCE, i) for i in range(4)]
FLAG: Measurand = (Quantity.WSP_ACTIVE, 0)
SPEED_MPS, FULL_N = 20.0, 40e3
NOTHING = MappingProxyType[Measurand, float]({})


class Wagon:
    """Its signals, and who judges them; each is good by itself unless `thought` says something else."""

    def __init__(self) -> None:
        self.settings: Settings = example_settings("bogie")
        self.channels: tuple[Channel, ...] = SignalDecoder.from_settings(self.settings).channels
        self.judge = InputJudge(self.settings, self.channels, CreepMeter(self.settings.estimator.contact_force_n))
        self.thought: dict[Measurand, InputCondition] = {}
        self.wheels: tuple[WheelState, ...] = ()

    def see(self, time_s: float, readings: Mapping[Measurand, float], quality: Quality = Quality.GOOD) -> None:
        for (quantity, i), value in readings.items():
            self.judge.see(Sample(time_s, quantity, i, value, quality))

    def roll(self, time_s: float, but: Mapping[Measurand, float] = NOTHING) -> None:
        """Read all speeds and forces of a wagon whose wheelsets roll and whose brakes are released, but for these."""
        radii_m = self.settings.vehicle.wheel_radius_m
        rolling = {place: SPEED_MPS / radius_m for place, radius_m in zip(WHEELS, radii_m, strict=True)}
        self.see(time_s, {SPEED: SPEED_MPS} | rolling | dict.fromkeys(FORCES, 0.0) | dict(but))

    def judged(self, time_s: float, changes: int = 1, **more: object) -> dict[Measurand, InputCondition]:
        """What is thought of each, of a wagon whose wheelsets roll unless it is told otherwise."""
        rolls = wheelset(slip=0.0, pressing_force_n=0.0)
        values = {"time_s": time_s, "speed_mps": SPEED_MPS, "saturated": False, "wheelsets": (rolls,) * 4}
        now: Estimate = estimate(**(values | more))
        reports, self.wheels = self.judge.judge(now, lambda place: self.thought.get(place, GOOD), changes)
        return {report.measurand: report.condition for report in reports}


def test_a_sound_wagon_is_thought_well_of() -> None:
    wagon = Wagon()
    for k in range(300):
        wagon.roll(0.1 * k)
        assert set(wagon.judged(0.1 * k).values()) == {GOOD}
        assert wagon.wheels == (WheelState.ROLLING,) * 4
        assert not wagon.judge.misled_by


def test_why_nothing_good_arrives_is_told_while_something_arrives() -> None:
    """Of what does not come at all nothing more is known than that; nor did the estimator learn of a change."""
    wagon = Wagon()
    wagon.roll(0.0)
    wagon.see(0.1, {WHEELS[0]: 300.0}, Quality.OUT_OF_RANGE)
    wagon.thought[WHEELS[0]] = LOST
    longest_s = max(channel.timeout_s + channel.delay_s for channel in wagon.channels)
    assert wagon.judged(0.11, changes=2)[WHEELS[0]] is OUT_OF_RANGE
    assert wagon.judged(0.11, changes=2)[WHEELS[1]] is GOOD
    assert wagon.judged(0.1 + 2.0 * longest_s, changes=2)[WHEELS[0]] is LOST


@pytest.mark.parametrize("place", [SPEED, *WHEELS, *FORCES])
def test_a_reading_that_is_not_good_says_nothing_of_wheels_and_brakes(place: Measurand) -> None:
    """It is as if it had not come: a wheel speed that is out of its range is none of a wheelset that stands."""
    wagon = Wagon()
    for k in range(100):
        wagon.roll(0.1 * k)
        wagon.see(0.1 * k + 0.01, {place: 90e3 if place in FORCES else 0.0}, Quality.BAD_COUNTER)
        assert set(wagon.judged(0.1 * k + 0.02).values()) == {GOOD}
    assert wagon.wheels == (WheelState.ROLLING,) * 4


def test_speeds_that_are_told_again_say_so_unless_there_is_something_to_say_of_one_alone() -> None:
    wagon = Wagon()
    wagon.thought[WHEELS[1]] = LOST
    found = wagon.judged(1.0, reasons=(Doubt.REPEATED,))
    speeds = dict.fromkeys([SPEED, *WHEELS], REPEATED) | wagon.thought
    assert {place: condition for place, condition in found.items() if condition is not GOOD} == speeds
    assert wagon.judged(2.0)[SPEED] is GOOD


@pytest.mark.parametrize("which", [SPEED, *WHEELS])
def test_a_speed_that_scatters_says_nothing_of_its_wheelset_and_the_others_go_on(which: Measurand) -> None:
    wagon = Wagon()
    for k in range(round(10.0 * TOLD_S) + 5):
        wagon.roll(0.1 * k)
        seen = tuple(wheelset(slip=0.0, pressing_force_n=0.0, speed_scatters=which == place) for place in WHEELS)
        doubts = () if which == SPEED else (Doubt.SCATTERED,)
        found = wagon.judged(0.1 * k, wheelsets=seen, reasons=doubts, speed_scatters=which == SPEED)
    assert found.pop(which) is SCATTERED
    assert set(found.values()) == {GOOD}
    contradicted, rolls = WheelState.CONTRADICTED, WheelState.ROLLING
    assert wagon.wheels == tuple(contradicted if which == place else rolls for place in WHEELS)


def test_a_vehicle_speed_that_leaves_its_wheelsets_is_contradicted_and_nothing_else_is() -> None:
    """It jumps by half, and they go on as before."""
    wagon = Wagon()
    for k in range(100):
        is_wrong = k >= 50
        wagon.roll(0.1 * k, {SPEED: 1.5 * SPEED_MPS} if is_wrong else NOTHING)
        found = wagon.judged(0.1 * k)
        assert is_wrong or set(found.values()) == {GOOD}
    assert found.pop(SPEED) is InputCondition.CONTRADICTED
    assert set(found.values()) == {GOOD}


def driven_n(time_s: float) -> float:
    """Brakes come on from 5 to 8 s and are released from 20 to 23 s; between they dither by a newton."""
    filled = min(max((time_s - 5.0) / 3.0, 0.0), 1.0) - min(max((time_s - 20.0) / 3.0, 0.0), 1.0)
    return FULL_N * filled + (round(10.0 * time_s) % 2) * (filled > 0.0)


def thought_of_a_frozen_force(*, slides: str = "", silent: Sequence[Measurand] = ()) -> set[InputCondition]:
    """From the release on; its sensor froze at 12 s. `slides`: which sign of a slide there is meanwhile."""
    wagon, found = Wagon(), set()
    wagon.thought |= dict.fromkeys(silent, LOST)
    for k in range(400):
        time_s, is_released = 0.1 * k, k > 190
        forces_n = (driven_n(min(time_s, 12.0)), *[driven_n(time_s)] * 3)
        readings = dict(zip(FORCES, forces_n, strict=True))
        own = [wheelset(slip=0.0, pressing_force_n=force_n) for force_n in forces_n]
        if slides == "a wheelset" and is_released:
            omega_radps = 0.9 * SPEED_MPS / wagon.settings.vehicle.wheel_radius_m[1]
            readings[WHEELS[1]] = omega_radps
            own[1] = replace(own[1], slip=0.1)
        if slides == "a flag" and is_released:
            own[1] = replace(own[1], wsp_active=True, is_protected=True)
        wagon.roll(time_s, readings)
        saturated = slides == "an estimate" and is_released
        told = wagon.judged(time_s, wheelsets=tuple(own), saturated=saturated)
        found |= {told[FORCES[0]]} if is_released else set()
    return found


def test_a_force_that_stays_while_all_others_are_released_is_frozen() -> None:
    assert thought_of_a_frozen_force() == {GOOD, InputCondition.FROZEN}


@pytest.mark.parametrize("slides", ["a wheelset", "a flag", "an estimate"])
def test_not_so_while_a_wheelset_slides(slides: str) -> None:
    """Slide protection empties brakes one by one."""
    assert InputCondition.FROZEN not in thought_of_a_frozen_force(slides=slides)


def test_nor_by_forces_that_are_not_told() -> None:
    assert InputCondition.FROZEN not in thought_of_a_frozen_force(silent=FORCES[1:])


@pytest.mark.parametrize(
    ("silent", "is_told"),
    [(None, True), (FORCES[0], False), (WHEELS[0], False), (SPEED, False)],
    ids=["all told", "force", "wheel speed", "speed"],
)
@pytest.mark.parametrize("other_is_dead", [False, True], ids=["", "another wheel speed says 0"])
def test_a_flag_is_stuck_over_a_wheelset_of_which_all_is_known(
    silent: Measurand | None, is_told: bool, other_is_dead: bool
) -> None:
    """Without its force nobody knows whether a brake presses, without its speed whether it slides."""
    wagon = Wagon()
    if silent is not None:
        wagon.thought[silent] = LOST
    for k in range(300):
        wagon.roll(0.1 * k, {FLAG: 1.0} | ({WHEELS[3]: 0.0} if other_is_dead and k >= 20 else {}))
        found = wagon.judged(0.1 * k)
    assert found[FLAG] is (InputCondition.CONTRADICTED if is_told else GOOD)


CREEP_PER_N, RETARDED_MPS2 = 2.5e-8, 0.8


@pytest.mark.parametrize(
    ("silent", "is_dead", "is_told"),
    [(None, False, True), (WHEELS[3], False, False), (SPEED, False, False), (None, True, False)],
    ids=["all told", "a wheel speed is lost", "the speed is lost", "a wheel speed is dead"],
)
def test_a_force_is_contradicted_by_creep_where_all_speeds_are_good(
    silent: Measurand | None, is_dead: bool, is_told: bool
) -> None:
    """The first brake works while its sensor says 0: its wheelset creeps as the others do."""
    wagon = Wagon()
    if silent is not None:
        wagon.thought[silent] = LOST
    stopped_s = 5.0 if is_dead else inf
    found = thought_of_forces(wagon, (0.0, FULL_N, FULL_N, FULL_N), stopped_s=stopped_s)
    assert {told[0] for told in found} == ({GOOD, InputCondition.CONTRADICTED} if is_told else {GOOD})


@pytest.mark.parametrize("how", ["sound", "lost", "died"])
def test_what_a_force_that_died_says_counts_for_as_little_as_if_it_was_not_told(how: str) -> None:
    """The first brake's sensor says 0 as well. By creep both are contradicted, where the other one is a witness."""
    wagon = Wagon()
    if how == "lost":
        wagon.thought[FORCES[1]] = LOST
    if how == "died":
        braked = wheelset(slip=0.0, pressing_force_n=FULL_N)
        wagon.thought[FORCES[1]] = InputCondition.IMPOSSIBLE
        for time_s in (-20.0, -20.0 + DIED_S):
            wagon.judged(time_s, changes=0, wheelsets=(braked,) * 4)
        wagon.thought.clear()
    first, second, *_ = thought_of_forces(wagon, (0.0, 0.0, FULL_N, FULL_N))[-1]
    contradicted = InputCondition.CONTRADICTED
    assert (first, second) == {
        "sound": (contradicted, contradicted),
        "lost": (GOOD, LOST),
        "died": (GOOD, contradicted),
    }[how]


def thought_of_forces(
    wagon: Wagon, said_n: Sequence[float], *, stopped_s: float = inf
) -> list[tuple[InputCondition, ...]]:
    """The wagon rolls for 10 s, then all brakes press alike, of which their sensors say this.

    `stopped_s`: from then on the speed of the last wheelset says 0.
    """
    radii_m, speed_mps, found = wagon.settings.vehicle.wheel_radius_m, 25.0, []
    for k in range(200):
        time_s, brakes = 0.1 * k, k >= 100
        speed_mps -= 0.1 * RETARDED_MPS2 * brakes
        slip = CREEP_PER_N * FULL_N * brakes
        omegas_radps = [speed_mps * (1.0 - slip) / radius_m for radius_m in radii_m]
        said_radps = [*omegas_radps[:3], 0.0 if time_s >= stopped_s else omegas_radps[3]]
        forces_n = [own_n * brakes for own_n in said_n]
        wagon.see(time_s, {SPEED: speed_mps} | dict(zip([*WHEELS, *FORCES], [*said_radps, *forces_n], strict=True)))
        own = [
            wheelset(slip=slip, omega_radps=omega_radps, pressing_force_n=force_n)
            for omega_radps, force_n in zip(omegas_radps, forces_n, strict=True)
        ]
        told = wagon.judged(time_s, speed_mps=speed_mps, wheelsets=tuple(own))
        found.append(tuple(told[place] for place in FORCES))
    return found
