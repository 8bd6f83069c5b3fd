"""Which pressing forces are not believed beside those of the other brakes, and what is used instead."""

from collections.abc import Callable

import pytest

from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.estimation.core.core import TELLS
from brake_monitor.estimation.doubts.force_gate import ALIVE_S, DEAD_S
from brake_monitor.estimation.estimator import Estimator
from brake_monitor.estimation.known_inputs import RELEASED_N, KnownInputs
from brake_monitor.samples import InputCondition, Measurand, Quality, Quantity, Sample
from brake_monitor.settings.example_vehicles import example_settings

FULL_N, NOISE_N, PERIOD_S, FAILS_S = 40e3, 5.0, 0.01, 5.0
OWN: Measurand = (Quantity.PRESSING_FORCE, 0)
GOOD, IMPOSSIBLE = InputCondition.GOOD, InputCondition.IMPOSSIBLE

Force = Callable[[float], float]  # over time


class Told:
    """What is thought of the first of two brakes, of what each is told to press with, while the wagon rolls."""

    def __init__(self, own: Force, other: Force, *, noise_n: float = NOISE_N, to_s: float = FAILS_S + 3.0) -> None:
        settings = example_settings("wagon")
        channels = SignalDecoder.from_settings(settings).channels
        self.estimator = estimator = Estimator(settings.vehicle, settings.estimator, channels)
        self.conditions: dict[float, InputCondition] = {}
        self.forces_n: dict[float, float] = {}
        for k in range(round(to_s / PERIOD_S)):
            time_s = k * PERIOD_S
            for i, force in enumerate((own, other)):
                trembles = i == 1 or time_s < FAILS_S
                value = force(time_s) + noise_n * (k % 2) * trembles
                estimator.take(Sample(time_s, Quantity.PRESSING_FORCE, i, value, Quality.GOOD))
            self.conditions[time_s] = estimator.input_condition(OWN)
            self.forces_n[time_s] = estimator.estimate(time_s).wheelsets[0].pressing_force_n

    def since(self, from_s: float) -> set[InputCondition]:
        return {condition for time_s, condition in self.conditions.items() if time_s > from_s - 0.5 * PERIOD_S}

    def used_n(self, from_s: float) -> set[float]:
        """The pressing forces that are used since then, with no more than their noise."""
        forces_n = [force_n for time_s, force_n in self.forces_n.items() if time_s > from_s - 0.5 * PERIOD_S]
        return {force_n - force_n % (2.0 * NOISE_N) for force_n in forces_n}


def held(force_n: float) -> Force:
    return lambda _: force_n


def at_once(before_n: float, after_n: float) -> Force:
    """As its sensor fails."""
    return lambda time_s: before_n if time_s < FAILS_S else after_n


def test_a_force_that_is_gone_at_once_while_another_brake_presses_on_is_not_believed() -> None:
    """Its brake is taken to press as before."""
    told = Told(at_once(FULL_N, 0.0), held(FULL_N))
    assert told.since(FAILS_S + DEAD_S + PERIOD_S) == {IMPOSSIBLE}
    assert told.used_n(PERIOD_S) == {FULL_N}


def test_nothing_else_of_its_wheelset_is_disbelieved_for_that() -> None:
    estimator, flag = Told(at_once(FULL_N, 0.0), held(FULL_N)).estimator, (Quantity.WSP_ACTIVE, 0)
    estimator.take(Sample(FAILS_S + 3.0, *flag, 1.0, Quality.GOOD))
    assert (estimator.input_condition(OWN), estimator.input_condition(flag)) == (IMPOSSIBLE, GOOD)


@pytest.mark.parametrize(("other_n", "is_believed"), [(0.4 * FULL_N, True), (0.6 * FULL_N, False)])
def test_another_brake_that_presses_far_less_is_no_witness(other_n: float, is_believed: bool) -> None:
    """Brakes are told to press alike; one that is at less than half has its own reasons."""
    told = Told(at_once(FULL_N, 0.0), held(other_n))
    assert told.since(FAILS_S + DEAD_S + PERIOD_S) == {GOOD if is_believed else IMPOSSIBLE}
    assert told.used_n(FAILS_S + PERIOD_S) == {0.0 if is_believed else FULL_N}  # as soon as it is borne out


def test_nor_is_one_whose_sensor_repeats_itself() -> None:
    told = Told(at_once(FULL_N, 0.0), held(FULL_N), noise_n=0.0)
    assert told.since(0.0) == {GOOD}
    assert told.used_n(FAILS_S + PERIOD_S) == {0.0}


def test_nor_is_one_that_does_not_touch_its_disc() -> None:
    """What its cylinder says is no brake force of which another's should be half."""
    contact_n = example_settings("wagon").estimator.contact_force_n
    told = Told(at_once(1.4 * contact_n, 0.0), held(0.9 * contact_n))
    assert told.since(0.0) == {GOOD}
    assert told.used_n(FAILS_S + PERIOD_S) == {0.0}


def test_a_dead_force_is_believed_again_when_the_others_are_released_as_well() -> None:
    """They are eased slowly, so that long before they are less than half of what it said last."""
    eased_from_s, eased_nps = FAILS_S + 1.0, 10e3
    told = Told(
        at_once(FULL_N, 0.0),
        lambda time_s: max(FULL_N - eased_nps * max(time_s - eased_from_s, 0.0), 0.0),
        to_s=eased_from_s + FULL_N / eased_nps + 2.0,
    )
    released_s = eased_from_s + (FULL_N - RELEASED_N) / eased_nps
    before = {c for time_s, c in told.conditions.items() if FAILS_S + 0.2 < time_s < released_s - 0.02}
    assert before == {IMPOSSIBLE}
    assert told.since(released_s + 0.05) == {GOOD}
    assert told.used_n(released_s + 0.05) == {0.0}


def test_a_force_that_is_told_below_0_is_none() -> None:
    """A sensor that drifts; nothing pulls pads off their disc that is worth a brake torque."""
    told = Told(lambda time_s: -3000.0 if time_s < FAILS_S else -500.0, held(0.0))
    assert told.since(0.0) == {GOOD}
    assert set(told.forces_n.values()) == {0.0}


def test_a_force_far_beyond_what_its_brake_pressed_with_lately_is_not_believed_however_long_it_stays() -> None:
    """Nor whatever another brake does: a wire of the sensor touches another."""
    told = Told(at_once(1000.0, 120e3), held(0.0), to_s=FAILS_S + 10.0)
    assert told.since(FAILS_S + DEAD_S + PERIOD_S) == {IMPOSSIBLE}
    assert told.used_n(PERIOD_S) == {1000.0}


def test_one_that_it_pressed_with_lately_may_be_back_at_once() -> None:
    """As slide protection fills it again, in models of rigs."""
    told = Told(lambda time_s: 80e3 if abs(time_s - FAILS_S) > ALIVE_S else 0.0, held(0.0))
    assert told.since(0.0) == {GOOD}
    assert told.used_n(FAILS_S + ALIVE_S + 2.0 * PERIOD_S) == {80e3}


@pytest.mark.parametrize("quantity", [quantity for quantity in Quantity if quantity not in TELLS])
def test_what_tells_the_filter_nothing_is_noted_and_forgotten_once_it_is_lost(quantity: Quantity) -> None:
    settings = example_settings("wagon")
    channels = SignalDecoder.from_settings(settings).channels
    known = KnownInputs(Estimator(settings.vehicle, settings.estimator, channels).core)
    untold = repr(vars(known))
    known.take(0, Sample(0.0, quantity, 0, 1.0, Quality.GOOD))
    assert repr(vars(known)) != untold
    known.lose(Sample(1.0, quantity, 0, 1.0, Quality.STALE))
    assert repr(vars(known)) == untold
