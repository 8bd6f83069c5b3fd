"""What may be learned of K, the error of motors' torques: as they begin, and no more than it can be."""

import numpy as np
import pytest

from brake_monitor.estimation.core.motor_watch import REMEMBERED, REST_S
from brake_monitor.estimation.estimator import Estimator
from brake_monitor.estimation.model.acting import Acting, acting_on_wheelset
from brake_monitor.estimation.model.tuning import WAGON
from brake_monitor.estimation.model.wagon import Inputs
from brake_monitor.samples import Channel, Quality, Quantity, Sample
from brake_monitor.settings.config import EstimatorSettings
from brake_monitor.settings.example_vehicles import example_settings
from test_estimator import channels

TORQUE_NM, SPEED_MPS = -3000.0, 20.0
RAILCAR = example_settings("railcar").vehicle
COUNT = RAILCAR.wheelset_count
TORQUES = [Channel(Quantity.WHEEL_TORQUE, i, "can0", "M", f"t{i}", 0.0, 0.0, 0.5) for i in range(COUNT)]


class Braking:
    """An estimator of the railcar, told speeds and torques; nothing else acts on the vehicle."""

    def __init__(self) -> None:
        self.estimator = Estimator(RAILCAR, EstimatorSettings(), [*channels(COUNT), *TORQUES])
        self.core, self.brakes = self.estimator.core, self.estimator.core.filter
        (self.place,) = range(self.brakes.layout.size)[self.brakes.layout.torque_error]
        self.time_s, self.speed_mps = 0.0, SPEED_MPS

    def run(self, seconds: float, torque_nm: float, slows_mps2: float) -> None:
        """Told every 20 ms."""
        for _ in range(round(seconds / 0.02)):
            self.time_s += 0.02
            self.speed_mps -= 0.02 * slows_mps2
            for i, radius_m in enumerate(RAILCAR.wheel_radius_m):
                self._tell(Quantity.WHEEL_TORQUE, i, torque_nm)
                self._tell(Quantity.PRESSING_FORCE, i, 0.0)
                self._tell(Quantity.AXLE_SPEED, i, self.speed_mps / radius_m)
            self._tell(Quantity.SPEED, 0, self.speed_mps)

    def _tell(self, quantity: Quantity, wheelset: int, value: float) -> None:
        self.estimator.take(Sample(self.time_s, quantity, wheelset, value, Quality.GOOD))

    @property
    def error(self) -> float:
        return self.brakes.x[self.place]

    @property
    def std(self) -> float:
        return self.brakes.std(self.place)


def by_motors_mps2(torque_nm: float) -> float:
    """By which so much torque on each wheelset slows the vehicle down, rotating masses included."""
    radii_m = np.array(RAILCAR.wheel_radius_m)
    inertia_kg = np.array(RAILCAR.wheelset_inertia_kgm2) @ radii_m**-2
    return float(-(torque_nm / radii_m).sum() / (RAILCAR.mass_kg + inertia_kg))


def resistance_mps2() -> float:
    return (RAILCAR.track_resistance_n + RAILCAR.drag_n_per_mps2 * SPEED_MPS**2) / RAILCAR.mass_kg


@pytest.mark.parametrize("error", [-0.06, 0.06])
def test_motors_that_come_on_show_by_how_much_they_err(error: float) -> None:
    braking = Braking()
    braking.run(10.0, 0.0, resistance_mps2())
    braking.run(3.0, TORQUE_NM, resistance_mps2() + (1.0 + error) * by_motors_mps2(TORQUE_NM))
    assert braking.error == pytest.approx(error, abs=0.025)
    assert braking.std < 0.6 * WAGON.torque_error_std


def test_what_was_learned_is_less_known_as_they_begin_anew_and_as_they_drive_instead() -> None:
    braking = Braking()
    braking.run(10.0, 0.0, resistance_mps2())
    braking.run(3.0, TORQUE_NM, resistance_mps2() + by_motors_mps2(TORQUE_NM))
    known = braking.std
    braking.run(0.4 * REST_S, 0.0, resistance_mps2())
    braking.run(0.04, TORQUE_NM, resistance_mps2())
    assert braking.std < 1.05 * known  # they hardly paused
    braking.run(0.04, -TORQUE_NM, resistance_mps2())
    assert 1.2 * known < braking.std <= WAGON.torque_error_std
    braking.run(1.0, -TORQUE_NM, resistance_mps2() + by_motors_mps2(-TORQUE_NM))
    braking.run(1.2 * REST_S, 0.0, resistance_mps2())
    known, braking.brakes.x[braking.place] = braking.std, 0.06
    braking.run(0.04, -TORQUE_NM, resistance_mps2() + by_motors_mps2(-TORQUE_NM))
    assert braking.error < 0.05  # and believed less
    assert 1.2 * known < braking.std <= WAGON.torque_error_std


def test_what_k_and_other_states_may_be_wrong_by_together_is_not_forgotten_as_motors_begin() -> None:
    """K was told from d by how they began last time: where one is wrong, so is the other, by as much less as K is."""
    braking = Braking()
    braking.run(10.0, 0.0, resistance_mps2())
    braking.run(3.0, TORQUE_NM, resistance_mps2() + by_motors_mps2(TORQUE_NM))
    before, d = np.array(braking.brakes.covariance), braking.brakes.layout.deceleration
    assert abs(before[braking.place, d]) > 0.3 * braking.std * braking.brakes.std(d)
    braking.core.renew_torque_error()
    after, share = np.array(braking.brakes.covariance), REMEMBERED**2
    others = np.arange(len(after)) != braking.place
    np.testing.assert_allclose(after[braking.place, others], REMEMBERED * before[braking.place, others])
    np.testing.assert_allclose(after, after.T)
    assert after[braking.place, braking.place] == pytest.approx(
        share * before[braking.place, braking.place] + (1.0 - share) * WAGON.torque_error_std**2
    )


def test_while_motors_act_what_is_known_of_them_fades_to_what_was_known_beforehand() -> None:
    braking = Braking()
    braking.run(10.0, 0.0, resistance_mps2())
    slows_mps2 = resistance_mps2() + by_motors_mps2(TORQUE_NM)
    braking.run(3.0, TORQUE_NM, slows_mps2)
    braking.brakes.forget(braking.place, 0.0, 0.005)
    braking.run(8.0, TORQUE_NM, slows_mps2)
    assert braking.std > 0.009  # 1e-5 a second, of which steady torques tell hardly anything
    braking.brakes.forget(braking.place, 0.0, WAGON.torque_error_std)
    braking.core.see_motors()
    assert braking.core.now.torque_error_density == 0.0


def test_a_line_that_falls_as_motors_come_on_is_not_taken_for_motors_that_hardly_work() -> None:
    """It takes away a third of what they give, 15 per mille: K would be -0.34, d is."""
    braking = Braking()
    braking.run(10.0, 0.0, resistance_mps2())
    given_mps2 = by_motors_mps2(TORQUE_NM)
    braking.run(6.0, TORQUE_NM, resistance_mps2() + 0.66 * given_mps2)
    assert abs(braking.error) <= 2.0 * WAGON.torque_error_std
    d = braking.brakes.layout.deceleration
    assert braking.brakes.x[d] == pytest.approx(-0.34 * given_mps2, abs=0.5 * 0.34 * given_mps2)


def test_what_k_gives_to_the_line_leaves_the_vehicles_deceleration_as_it_is() -> None:
    braking = Braking()
    braking.run(10.0, 0.0, resistance_mps2())
    braking.run(3.0, TORQUE_NM, resistance_mps2() + by_motors_mps2(TORQUE_NM))
    brakes, core = braking.brakes, braking.core
    brakes.x[braking.place] = -0.2
    u = Inputs(core.now.mass_kg, core.now.gradient, [Acting(*acting_on_wheelset(wheel)) for wheel in core.wheels])
    before_mps2, d = brakes.wagon.acceleration_mps2(brakes.x, u), brakes.x[brakes.layout.deceleration]
    friction = brakes.layout.friction.start
    brakes.direction[friction] = 1.0  # as a doubt of friction leaves it
    known, prior_variance = brakes.std(friction), WAGON.torque_error_std**2
    at_rim_mps2 = -sum(TORQUE_NM / radius_m for radius_m in RAILCAR.wheel_radius_m) / RAILCAR.mass_kg
    doubted = braking.std**2 + (0.05 / at_rim_mps2) ** 2  # 5 per mille of the line
    core.give_to_line()
    assert brakes.std(friction) == pytest.approx(known, rel=1e-3)
    kept = prior_variance / (prior_variance + doubted)
    assert braking.error == pytest.approx(-0.2 * kept, rel=0.1)
    assert brakes.x[brakes.layout.deceleration] < d - 0.6 * 0.2 * by_motors_mps2(TORQUE_NM)
    given_mps2 = 0.2 * by_motors_mps2(TORQUE_NM)
    assert brakes.wagon.acceleration_mps2(brakes.x, u) == pytest.approx(before_mps2, abs=0.05 * given_mps2)
    assert brakes.is_sound()


def test_k_does_not_wander_off_however_often_motors_begin_on_lines_that_fall() -> None:
    braking = Braking()
    for _ in range(12):
        braking.speed_mps = SPEED_MPS
        braking.estimator.core.filter.forget(braking.brakes.layout.speed, SPEED_MPS, 0.1)
        braking.run(4.0, 0.0, resistance_mps2())
        braking.run(3.0, TORQUE_NM, resistance_mps2() + 0.88 * by_motors_mps2(TORQUE_NM))
    assert -2.0 * WAGON.torque_error_std <= braking.error < 0.0


def test_a_clock_that_is_set_back_ends_what_motors_did_before() -> None:
    braking = Braking()
    braking.run(4.0, TORQUE_NM, resistance_mps2() + by_motors_mps2(TORQUE_NM))
    braking.run(0.04, 0.0, resistance_mps2())
    braking.core.now.motors_acted_s += 3600.0  # as the clock was then
    braking.run(0.1, 0.0, resistance_mps2())
    assert braking.core.now.motor_direction == 0.0


def test_who_has_no_motors_has_no_state_for_them() -> None:
    estimator = Estimator(RAILCAR, EstimatorSettings(), channels(COUNT))
    assert estimator.core.filter.layout.size == estimator.core.filter.layout.torque_error.start
    assert not estimator.core.learns_torque_error


def test_to_the_letter_of_the_paper_no_torque_errs() -> None:
    estimator = Estimator(RAILCAR, EstimatorSettings(preset="rig"), [*channels(COUNT), *TORQUES])
    assert not estimator.core.learns_torque_error


def test_motors_that_work_against_each_other_show_no_error_and_spoil_nothing() -> None:
    """One spins its wheelset up while the other brakes: K moves the wagon by nothing then."""
    braking = Braking()
    braking.run(10.0, 0.0, resistance_mps2())
    core, brakes = braking.core, braking.brakes
    for wheel, torque_nm in zip(core.wheels, (TORQUE_NM, -TORQUE_NM), strict=False):
        wheel.torque.value = torque_nm
    brakes.x[braking.place] = 0.2
    core.give_to_line()
    assert 0.0 <= braking.error < 0.2
    assert brakes.x[brakes.layout.deceleration] == pytest.approx(0.0, abs=0.05)
    assert all(0.0 < brakes.std(core.adhesion_place + i) < 0.1 for i in range(2))
    assert braking.std == pytest.approx(WAGON.torque_error_std, rel=0.1)
