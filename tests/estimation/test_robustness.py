"""Everything that goes wrong with sensors, buses and clocks, on drives of the independent simulator.

Of every fault it is asked: no NaN; bounded uncertainty; never `valid` and wrong by more than three of its own standard
deviations for longer than a second; recovered by itself. Where physics lets nobody see the fault, the test says so and
bounds the error instead.
"""

from dataclasses import replace
from itertools import chain

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace as struct_replace

from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.estimation.doubts.consistency import Doubt
from brake_monitor.estimation.estimate import Status
from brake_monitor.estimation.estimator import Estimator
from brake_monitor.estimation.inputs.alignment import Alignment
from brake_monitor.monitoring.misled import MisledBy
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.samples import Quality, Quantity, Sample
from brake_monitor.settings.config import EstimatorSettings, OutputSettings, SignalMapping
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.physics.pneumatics import Valve
from brake_monitor.simulator.physics.wsp import WheelSlideProtection
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.scenarios import Profile, Scenario, steps
from brake_monitor.simulator.simulate import EPOCH_S, Recording
from brake_monitor.simulator.simulate import run as simulate
from brake_monitor.validation.cases import LARGE_ERROR_S
from brake_monitor.validation.scores import LARGE_ERROR, longest_s
from drives import DRY, END_S, SLIDE, Judged, drive, numbers, play, play_to
from faults import (
    SENSORS,
    Fault,
    beyond_range,
    biased,
    clock_set,
    duplicated,
    error_code,
    frozen,
    jittered,
    lagging,
    lost,
    scattered,
    signal_changed,
    silence,
    spiking,
    stuck,
    swapped,
    told_again,
)

VALID, HELD, CONVERGING, INVALID = Status.VALID, Status.HELD, Status.CONVERGING, Status.INVALID
NAMES = {"vehicle speed": "speed 1", "wheel speed": "axle_speed 1", "pressing force": "pressing_force 1"}
TOLD_S = 0.3  # from a sensor's failure to its telling: the longest time-out is five cycles of 50 ms
NORMAL_RMSE = 0.003  # of adhesion, once recovered
WET = Scenario(
    name="wet",
    summary="brake from 3 s as hard as a wet rail just allows",
    initial_speed_mps=22.0,
    duration_s=END_S,
    demand=steps((3.0, 1.0)),
    rail_over_time=Profile(((0.0, 0.08),)),
)
HARD_BRAKING = 0.25  # of the rail, by the hardest brakes of wagons
TAIL_S = 4.0  # how long the recovered estimate is looked at


def decoder_of_the_wagon() -> SignalDecoder:
    return SignalDecoder.from_settings(drive(DRY).settings)


def through(scenario: Scenario, fault: Fault, until_s: float = END_S) -> Judged:
    """Play a drive with a fault, up to some time; what came out holds no nonsense."""
    recording = drive(scenario)
    frames = fault([frame for frame in recording.frames if frame.time_s - EPOCH_S < until_s])
    judged = Judged.of(recording, play(recording.settings, frames))
    judged.assert_sound()
    return judged


def assert_normal(judged: Judged) -> None:
    assert judged.statuses == {VALID}
    assert judged.rmse < NORMAL_RMSE


# -- a sensor that is told to be missing ---------------------------------------------------------------------------


@pytest.mark.parametrize(("from_s", "to_s"), [(2.0, 4.9), (8.0, 10.5), (12.0, 18.0)], ids=["before", "during", "after"])
@pytest.mark.parametrize("sensor", SENSORS)
def test_a_sensor_without_data_makes_the_estimate_invalid_until_it_is_back(
    sensor: str, from_s: float, to_s: float
) -> None:
    """Before, during and across the end of a brake and the beginning of the next."""
    judged = through(DRY, error_code(sensor, from_s, to_s), to_s + 1.0 + TAIL_S)
    judged.assert_honest()
    gone = judged.during(from_s + TOLD_S, to_s)
    assert gone.statuses == {INVALID}
    assert gone.reasons == {f"{NAMES[sensor]} lost"}
    assert gone.friction_statuses(0) == {INVALID}
    assert_normal(judged.during(to_s + 1.0))


@pytest.mark.parametrize("sensor", SENSORS)
def test_a_sensor_lost_in_a_slide(sensor: str) -> None:
    judged = through(SLIDE, error_code(sensor, 8.0, 11.0), 16.0)
    judged.assert_honest()
    assert judged.during(8.0 + TOLD_S, 11.0).statuses == {INVALID}
    assert_normal(judged.during(12.0))


@pytest.mark.parametrize("scenario", [DRY, SLIDE], ids=lambda s: s.name)
def test_a_wheel_speed_that_is_lost_for_good_leaves_the_other_brake_alone(scenario: Scenario) -> None:
    """What is not measured is not told to slide, and bears what its brake asks for: the other one need not."""
    judged = through(scenario, error_code("wheel speed", 2.0, END_S))
    judged.assert_honest()
    gone = judged.during(2.0 + TOLD_S)
    assert gone.statuses <= {INVALID, HELD}
    assert gone.worst_friction() < 0.05
    assert all(abs(estimate.wheelsets[0].slip) < 0.01 for estimate in gone.told)
    if scenario is DRY:
        assert not any(estimate.saturated for estimate in gone.told)


@pytest.mark.parametrize("quantity", [Quantity.AXLE_SPEED, Quantity.PRESSING_FORCE])
def test_what_nobody_tells_of_wheelsets_for_minutes_strays_no_further_than_brakes_can_make_it(
    quantity: Quantity,
) -> None:
    """In a train, where the vehicle speed tells little of any rail: coasting, with all sensors of a kind lost."""
    recording = drive(DRY)
    decoder = SignalDecoder.from_settings(recording.settings)
    estimator = Estimator(recording.settings.vehicle, EstimatorSettings(preset="train"), decoder.channels)
    second = [
        sample for frame in recording.frames for sample in decoder.decode(frame) if 1.0 <= frame.time_s - EPOCH_S < 2.0
    ]
    for passed_s in range(200):
        for sample in second:
            later = sample._replace(time_s=sample.time_s + passed_s)
            is_lost = passed_s > 5 and sample.quantity is quantity
            estimator.take(later._replace(quality=Quality.STALE) if is_lost else later)
        for wheelset in estimator.estimate().wheelsets:
            assert wheelset.adhesion_std < HARD_BRAKING / 2
            assert abs(wheelset.adhesion) < HARD_BRAKING


@pytest.mark.parametrize("message", ["GNSS", "WSP", "BCU"])
def test_a_message_that_is_not_sent(message: str) -> None:
    judged = through(DRY, lost(message, 8.0, 10.5), 15.0)
    judged.assert_honest()
    assert judged.during(8.0 + TOLD_S, 10.5).statuses == {INVALID}
    assert_normal(judged.during(11.5))


@pytest.mark.parametrize("sensor", SENSORS)
def test_values_beyond_the_range_of_the_dbc_are_no_values(sensor: str) -> None:
    judged = through(SLIDE, beyond_range(sensor, 8.0, 10.5), 15.0)
    judged.assert_honest()
    assert judged.during(8.0 + TOLD_S, 10.5).statuses == {INVALID}
    assert_normal(judged.during(11.5))


# -- a sensor that repeats itself ----------------------------------------------------------------------------------


@pytest.mark.parametrize("message", ["WSP", "BCU"])
def test_a_control_unit_that_repeats_its_last_frame_betrays_itself_by_its_counter(message: str) -> None:
    judged = through(SLIDE, stuck(message, 8.0, 10.5), 15.0)
    judged.assert_honest()
    assert judged.during(8.0 + TOLD_S, 10.5).statuses == {INVALID}
    assert_normal(judged.during(11.5))


@pytest.mark.parametrize("scenario", [DRY, SLIDE], ids=lambda s: s.name)
@pytest.mark.parametrize("sensor", ["vehicle speed", "wheel speed"])
def test_a_frozen_speed_is_found_out_by_the_others(sensor: str, scenario: Scenario) -> None:
    """No counter helps when the value alone stands still. It is told once the others have moved away from it."""
    judged = through(scenario, frozen(sensor, 7.0, 11.0), 19.0)
    judged.assert_honest()
    assert VALID not in judged.during(8.5, 11.0).statuses
    assert f"{NAMES[sensor]} frozen" in judged.during(8.5, 11.0).reasons
    assert_normal(judged.during(15.0))


@pytest.mark.parametrize("sensor", ["vehicle speed", "wheel speed"])
def test_what_was_known_before_a_speed_froze_is_known_again_when_it_is_found_out(sensor: str) -> None:
    """Not what it has taught since then, nor as little as at the beginning: ± 0.041 of friction."""
    judged = through(SLIDE, frozen(sensor, 9.0, 12.0), 16.0)
    judged.assert_honest()
    before, after = judged.during(8.0, 9.0), judged.during(12.5, 14.0)
    for was, now in zip(before.told[-1].wheelsets, after.told[0].wheelsets, strict=True):
        assert abs(now.friction - was.friction) < 0.02
        assert now.friction_std < 0.02
    assert after.worst_friction() < 0.05
    assert after.rmse < 0.005


@pytest.mark.parametrize("for_s", [0.4, 0.6, 0.9])
def test_a_vehicle_speed_that_hangs_for_a_moment_teaches_no_friction(for_s: float) -> None:
    """As the brake comes on: each reading of a speed that falls no more would be friction that is not there."""
    judged = through(DRY, frozen("vehicle speed", 6.0, 6.0 + for_s), 15.0)
    judged.assert_honest()
    assert f"{NAMES['vehicle speed']} frozen" in judged.during(6.0, 7.0).reasons
    assert Doubt.BIASED not in judged.reasons
    assert judged.during(7.5).worst_friction() < 0.05
    assert_normal(judged.during(10.5))


def test_a_vehicle_speed_that_freezes_while_coasting_is_found_out_before_the_brake() -> None:
    judged = through(DRY, frozen("vehicle speed", 0.5, 9.0), 17.0)
    judged.assert_honest()
    assert judged.during(4.9, 9.0).statuses == {INVALID}
    assert_normal(judged.during(12.5))


@pytest.mark.parametrize("from_s", [7.0, 9.0])
def test_a_frozen_vehicle_speed_makes_no_slide_of_which_friction_is_learned(from_s: float) -> None:
    """When it is found out the wheelsets seem to slide by 7 %: they, and not it, tell how fast the wagon is.

    The pads give more than they should, so that friction is to be learned anew.
    """
    recording = drive(WET)
    estimator = struct_replace(recording.settings.estimator, friction_nominal=0.30)
    frames = frozen("vehicle speed", from_s, from_s + 3.0)(list(recording.frames))
    judged = Judged.of(recording, play(struct_replace(recording.settings, estimator=estimator), frames))
    judged.assert_sound()
    judged.assert_honest()
    assert judged.during(from_s + 1.5, from_s + 2.9).statuses == {INVALID}
    assert judged.during(from_s + 6.5, 18.0).statuses == {VALID}


@pytest.mark.parametrize(("from_s", "to_s"), [(7.0, 11.0), (11.0, 16.0)], ids=["pressed", "released meanwhile"])
def test_a_frozen_pressing_force_is_lost_before_the_wagon_contradicts_it(from_s: float, to_s: float) -> None:
    """It trembled before. Else a release that it does not show would be taken for a line that falls."""
    judged = through(DRY, frozen("pressing force", from_s, to_s), 27.0)
    judged.assert_honest()
    lost = judged.during(from_s + 1.0, to_s)
    assert lost.statuses == {INVALID}
    assert all("pressing_force 1 frozen" in estimate.reasons for estimate in lost.told)
    assert Doubt.BIASED not in judged.reasons
    assert judged.worst < 0.03
    assert_normal(judged.during(max(to_s, 15.5) + 5.0))  # a doubt outlasts its reason by three


def test_a_pressing_force_that_freezes_in_a_slide_is_doubted_while_the_slip_moves() -> None:
    """The slide protection moves the true force around the frozen one, so that on average it is about right."""
    judged = through(SLIDE, frozen("pressing force", 7.0, 11.0), 20.0)
    judged.assert_honest()
    assert Doubt.STILL in judged.during(8.2, 11.0).reasons
    assert judged.worst < 0.03
    assert judged.worst_friction() < 0.06
    assert_normal(judged.during(16.5))  # what it has taught in four seconds is unlearned in five


@pytest.mark.parametrize("seed", [3, 5])
def test_friction_that_was_doubted_in_a_slide_is_learned_again_as_forces_fall_and_as_they_rise(seed: int) -> None:
    """Slide protection vents and fills in turn: friction learned of one alone is off by what forces are late."""
    settings = example_settings("bogie")
    recording = simulate("wsp", settings, seed=seed)
    frames = recording.frames
    for signal in ("p_3", "p_4"):
        frames = told_again("BrakeTrail", signal, 55.0, 60.0, vehicle="bogie")(frames)
    judged = Judged.of(recording, play(settings, frames)).during(0.0, 108.0)  # until all roll
    judged.assert_sound()
    assert Doubt.STILL in judged.during(55.0, 65.0).reasons
    assert judged.friction_dishonest_s() == 0.0


@pytest.mark.parametrize("from_s", [7.0, 8.0, 9.0])
def test_a_pressing_force_that_dies_in_a_slide_is_found_out_as_its_wheelset_slides_anew(from_s: float) -> None:
    """Nothing that presses nowhere slides anew; d could take what seems to be missing of the brake for minutes."""
    judged = through(SLIDE, signal_changed("pressing force", lambda _, __: 0.0, from_s, 13.5), 21.0)
    judged.assert_honest()
    assert judged.during(from_s + 4.0, 13.5).statuses == {INVALID}
    assert judged.during(from_s + 4.0, 13.5).reasons - set(Doubt) == {"pressing_force 1 contradicted"}
    assert_normal(judged.during(18.5))


@pytest.mark.parametrize("to_s", [10.0, 16.0], ids=["pressed", "released meanwhile"])
def test_a_pressing_force_that_dies_while_the_other_brake_presses_on_has_no_say(to_s: float) -> None:
    """No valve empties a cylinder from one reading to the next: nothing is learned of it, nor later unlearned."""
    judged = through(DRY, signal_changed("pressing force", lambda _, __: 0.0, 7.5, to_s), 24.0)
    judged.assert_honest()
    dead = judged.during(7.8, min(to_s, 12.0))
    assert dead.statuses == {INVALID}
    assert dead.reasons == {"pressing_force 1 impossible"}
    assert judged.worst < 0.01
    assert judged.worst_friction() < 0.05
    assert_normal(judged.during(to_s + 3.5))


def test_a_pressing_force_stuck_at_zero_may_be_an_isolated_brake_until_it_has_shown_that_it_is_none() -> None:
    """That one wheelset brakes for both cannot be refuted at once. Until then what both do contradicts nothing."""
    judged = through(DRY, frozen("pressing force", 1.0, 9.0))
    judged.assert_honest()
    assert {MisledBy.SILENT, "pressing_force 1 contradicted"} <= judged.reasons
    assert Doubt.BIASED not in judged.reasons
    assert judged.worst < 0.02
    assert judged.during(6.5, 7.5).worst < 0.006
    assert max(w.friction for e in judged.told for w in e.wheelsets) < 0.4
    assert VALID not in judged.during(5.6, 8.9).statuses
    assert_normal(judged.during(22.0))


@pytest.mark.parametrize("from_s", [2.0, 8.0], ids=["coasting", "braking"])
@pytest.mark.parametrize("scenario", [DRY, SLIDE], ids=lambda s: s.name)
def test_a_wheel_speed_that_dies_is_not_taken_for_a_locked_wheelset(scenario: Scenario, from_s: float) -> None:
    """It reads standstill from one frame to the next: as long as it is doubted the wheelset looks locked."""
    judged = through(scenario, signal_changed("wheel speed", lambda _, __: 0.0, from_s, 12.0), 18.0)
    disbelieved = judged.during(from_s + 2.0, 12.0)
    assert disbelieved.statuses == {INVALID}
    assert disbelieved.reasons == {"axle_speed 1 contradicted"}
    assert not any(e.saturated and e.wheelsets[0].slip > 0.5 for e in disbelieved.told)
    assert_normal(judged.during(15.5))


# -- a sensor that is wrong ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("scenario", [DRY, SLIDE], ids=lambda s: s.name)
@pytest.mark.parametrize(
    ("sensor", "by"),
    [
        *(("vehicle speed", 30.0), ("vehicle speed", -2.0)),
        *(("wheel speed", 60.0), ("wheel speed", -100.0)),
        *(("pressing force", 4.0), ("pressing force", -4.0)),
    ],
)
def test_spikes_do_no_harm(sensor: str, by: float, scenario: Scenario) -> None:
    """Every 17th reading is off, in the DBC's units (m/s, km/h, bar), for a single frame."""
    judged = through(scenario, spiking(sensor, by), 13.0)
    judged.assert_honest()
    assert_normal(judged.during(4.0))


@pytest.mark.parametrize("every", [17, 53, 151])
def test_spikes_of_a_wheel_speed_condemn_no_pressing_force(every: int) -> None:
    """2 km/h less for a single reading looks like a slide, and the force of a brake that is off stands still."""
    judged = through(DRY, spiking("wheel speed", -2.0, every), END_S)
    assert not any("pressing_force" in reason for reason in judged.during(4.0, END_S).reasons)


@pytest.mark.parametrize("seed", [1, 3, 6])
@pytest.mark.parametrize("by_kmh", [1.0, 3.0])
def test_small_spikes_at_random_leave_the_estimate_valid(by_kmh: float, seed: int) -> None:
    """Slide protection moves a wheel by as much from reading to reading: the first ones are believed for one."""
    judged = through(SLIDE, scattered("wheel speed", by_kmh, 0.02, seed), END_S)
    judged.assert_honest()
    judged = judged.during(9.0)
    assert judged.rmse < NORMAL_RMSE
    assert np.mean([e.status is Status.VALID for e in judged.told]) > 0.98
    assert not any("pressing_force" in reason for reason in judged.reasons)


@pytest.mark.parametrize("by_kmh", [-2.0, 2.0, 3.0])
def test_a_spike_that_was_believed_is_taken_back_with_the_next_reading(by_kmh: float) -> None:
    """It looks like a jump of adhesion by 0.1, whose pull would make outliers of the readings that follow."""
    recording = drive(SLIDE)
    at_every_frame = struct_replace(recording.settings, output=OutputSettings(rate_hz=0.0))
    until_s = 9.0
    frames = [frame for frame in recording.frames if frame.time_s - EPOCH_S < until_s]
    spiked = signal_changed("wheel speed", lambda _, value: value + by_kmh, 8.39, 8.41)(frames)
    with_it, without = (
        {estimate.time_s - EPOCH_S: estimate.wheelsets[0] for estimate in play(at_every_frame, told)}
        for told in (spiked, frames)
    )
    shared = with_it.keys() & without.keys()
    assert max(abs(with_it[time_s].slip - without[time_s].slip) for time_s in shared) > 0.01  # it was believed
    later = [abs(with_it[time_s].adhesion - without[time_s].adhesion) for time_s in shared if time_s > 8.43]
    assert max(later) < 0.01


@pytest.mark.parametrize("seed", [0, 2])
@pytest.mark.parametrize("by_kmh", [5.0, 30.0])
@pytest.mark.parametrize("scenario", [DRY, SLIDE], ids=lambda s: s.name)
def test_spikes_at_random_are_told_from_a_wheel_that_is_quick(scenario: Scenario, by_kmh: float, seed: int) -> None:
    """A tenth of one wheel's readings is off, the first one perhaps, now and then several in a row.

    A second spike must not pass because the first left much time since the last good reading; and what was believed
    of spikes must not make outliers of all readings that follow.
    """
    recording = drive(scenario)
    at_every_frame = struct_replace(recording.settings, output=OutputSettings(rate_hz=0.0))
    frames = scattered("wheel speed", by_kmh, 0.1, seed)(list(recording.frames))
    judged = Judged.of(recording, play(at_every_frame, frames)).during(4.0)
    judged.assert_sound()
    judged.assert_honest()
    assert judged.rmse < NORMAL_RMSE
    assert longest_s(judged.time_s, np.abs(judged.adhesion_error) > LARGE_ERROR) <= LARGE_ERROR_S


def test_a_biased_vehicle_speed_is_put_down_to_worn_wheels() -> None:
    """2 % from the beginning: nobody can tell it from smaller wheels, and adhesion and slip come out the same."""
    judged = through(SLIDE, biased("vehicle speed", 1.02))
    judged.assert_honest()
    assert_normal(judged.during(4.0))
    slip_error = [e.wheelsets[0].slip for e in judged.told] - judged.truth.slip[:, 0]
    assert np.max(np.abs(slip_error[judged.time_s > 4.0])) < 0.03


def test_a_biased_wheel_speed_is_put_down_to_a_worn_wheel() -> None:
    judged = through(SLIDE, biased("wheel speed", 0.98))
    judged.assert_honest()
    assert_normal(judged.during(4.0))


def test_a_wheel_speed_that_becomes_biased_while_braking_looks_like_slip() -> None:
    """2 % of creep is what a braked wheel may have: slip is off by as much, adhesion only while the reading jumps."""
    judged = through(DRY, biased("wheel speed", 0.98, from_s=9.0), 13.0)
    judged.assert_honest()
    assert_normal(judged.during(9.5))
    assert all(abs(e.wheelsets[0].slip) < 0.03 for e in judged.during(4.0).told)


@pytest.mark.parametrize("share", [0.001, 0.003])
@pytest.mark.parametrize("scenario", [DRY, SLIDE], ids=lambda scenario: scenario.name)
def test_pole_wheels_that_run_out_do_no_harm_once_that_is_learned(scenario: Scenario, share: float) -> None:
    """Without what takes the run-out away adhesion errs two to ten times as much, and is hardly ever `valid`."""
    sound, uneven = (drive(scenario, Modifiers(run_out=some)) for some in (0.0, share))
    judged = [Judged.of(recording, play(example_settings("wagon"), recording.frames)) for recording in (sound, uneven)]
    judged[1].assert_sound()
    judged[1].assert_honest()
    reference, own = (each.during(5.0) for each in judged)
    assert own.rmse < 1.1 * reference.rmse
    assert np.mean([e.status is Status.VALID for e in own.told]) > 0.98


def test_a_biased_pressing_force_is_put_down_to_friction() -> None:
    """Only the product of force and friction brakes (10): a tenth more force is a tenth less friction, for anybody."""
    judged = through(SLIDE, biased("pressing force", 1.10))
    assert judged.adhesion_dishonest_s() <= 1.0
    assert_normal(judged.during(4.0))
    assert judged.worst_friction() < 0.35 * 0.10 + 0.035


# -- a sensor that is late -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("message", ["GNSS", "WSP", "BCU"])
def test_frames_that_queue_for_up_to_a_tenth_of_a_second(message: str) -> None:
    judged = through(DRY, jittered(message, 0.1), 17.0)
    judged.assert_honest()
    assert judged.during(4.0).rmse < NORMAL_RMSE


@pytest.mark.parametrize(("message", "worst"), [("GNSS", 0.02), ("WSP", 0.1), ("BCU", 0.04)])
def test_frames_that_queue_during_a_slide(message: str, worst: float) -> None:
    """The wheels turn by 30 rad/s² and the forces by 300 kN/s: a time that is off by 0.05 s is a reading that is off by
    far more than its noise. Wheel speeds scatter so much then that they are doubted."""
    judged = through(SLIDE, jittered(message, 0.1))
    judged.assert_honest()
    assert (Doubt.SCATTERED in judged.reasons) is (message == "WSP")
    assert judged.during(4.0).worst < worst
    assert judged.worst_friction() < 0.08
    assert judged.during(22.0).rmse < NORMAL_RMSE


@pytest.mark.parametrize("lag_s", [0.02, 0.1])
@pytest.mark.parametrize("message", ["GNSS", "WSP", "BCU"])
@pytest.mark.parametrize("scenario", [DRY, SLIDE], ids=lambda scenario: scenario.name)
def test_a_lag_that_nobody_configured(scenario: Scenario, message: str, lag_s: float) -> None:
    """A force that is always late looks like friction that depends on whether the force rises or falls, and makes the
    wheels answer before they were asked. `delay_s` is the remedy; the error is bounded."""
    judged = through(scenario, lagging(message, lag_s))
    judged.assert_honest()
    assert judged.during(4.0).worst < 0.04
    assert judged.during(4.0).rmse < 0.008
    assert judged.worst_friction() < 0.09
    assert judged.during(22.0).rmse < 0.005
    if scenario is SLIDE and lag_s == 0.1 and message != "GNSS":
        assert Doubt.OUT_OF_STEP in judged.during(7.5, 14.0).reasons


SLIDE_AND_ON = Scenario(
    name="slide and on",
    summary="coast, brake from 5 s until the end, slide between 6 and 15 s, then good rail",
    initial_speed_mps=45.0,
    duration_s=40.0,
    demand=steps((5.0, 0.6)),
    rail_over_time=Profile(((5.0, 0.3), (6.0, 0.03), (14.0, 0.03), (15.0, 0.3))),
)


@pytest.mark.parametrize("message", ["WSP", "BCU"])
def test_what_a_lag_has_taught_is_doubted_when_the_forces_are_in_step_again(message: str) -> None:
    """Once nothing slides nothing shows the lag, and friction stays where the slide has brought it."""
    judged = through(SLIDE_AND_ON, lagging(message, 0.1), 40.0)
    judged.assert_honest()
    assert Doubt.OUT_OF_STEP in judged.during(7.5, 15.0).reasons
    assert Doubt.OUT_OF_STEP not in judged.during(30.0, 40.0).reasons
    told = judged.during(30.0, 40.0).told
    assert min(wheelset.friction_std for now in told for wheelset in now.wheelsets) > 0.02


@pytest.mark.parametrize("sensor", SENSORS)
def test_a_configured_delay_makes_up_for_the_lag(sensor: str) -> None:
    recording = drive(SLIDE)
    message, _ = SENSORS[sensor]
    mapped = recording.settings.signals
    compensated = struct_replace(
        mapped,
        speed=delayed(mapped.speed, message, 0.1),
        axle_speed=tuple(delayed(mapping, message, 0.1) for mapping in mapped.axle_speed),
        pressing_force=tuple(delayed(mapping, message, 0.1) for mapping in mapped.pressing_force),
    )
    frames = lagging(message, 0.1)([f for f in recording.frames if f.time_s - EPOCH_S < 14.0])
    judged = Judged.of(recording, play(struct_replace(recording.settings, signals=compensated), frames))
    judged.assert_honest()
    assert_normal(judged.during(4.0))


def delayed(mapping: SignalMapping, message: str, delay_s: float) -> SignalMapping:
    return struct_replace(mapping, delay_s=delay_s) if mapping.message == message else mapping


# -- the bus -------------------------------------------------------------------------------------------------------


def test_two_seconds_without_a_bus_in_the_middle_of_a_slide() -> None:
    judged = through(SLIDE, silence(9.0, 11.0), 18.0)
    judged.assert_honest()
    gone = judged.during(9.6, 11.0)
    assert gone.told
    assert gone.statuses == {INVALID}
    assert judged.during(11.1, 13.9).statuses == {CONVERGING}
    assert_normal(judged.during(14.1))


@pytest.mark.parametrize("fault", [duplicated(0.3), swapped(0.3)], ids=["duplicated", "reordered"])
def test_frames_twice_or_out_of_order(fault: Fault) -> None:
    judged = through(SLIDE, fault, 14.0)
    judged.assert_honest()
    assert_normal(judged.during(4.0))
    assert judged.told[-1].reset_count == 0


@pytest.mark.parametrize("jump_s", [-3600.0, -0.5, 0.5, 3600.0])
def test_the_clock_is_set_in_the_middle_of_a_slide(jump_s: float) -> None:
    """Three drives: what is left of the brake application is short, and one may be harder than others."""
    squares = []
    for seed in range(5, 8):
        recording = simulate(SLIDE, example_settings("wagon"), seed)
        frames = [frame for frame in recording.frames if frame.time_s - EPOCH_S < 18.0]
        told = play(recording.settings, clock_set(9.0, jump_s)(frames))
        times_s = np.array([estimate.time_s for estimate in told])
        after = np.cumsum(np.abs(np.diff(times_s, prepend=times_s[0]) - 0.1) > 0.2) > 0
        judged = Judged.of(recording, told, np.where(after, jump_s, 0.0))
        judged.assert_sound()
        judged.assert_honest()
        assert judged.told[-1].reset_count <= 1
        settled = judged.during(13.0)
        assert settled.statuses == {VALID}
        squares.append(settled.rmse**2)
    assert np.sqrt(np.mean(squares)) < NORMAL_RMSE


@pytest.mark.parametrize("set_s", [9.0, 14.9], ids=["while a pad presses", "while an earlier doubt lasts"])
def test_a_clock_that_is_set_back_makes_no_doubt_last_longer(set_s: float) -> None:
    """Ten minutes, that is: friction shows again within the settling time, not when the clock comes by again."""
    recording = drive(DRY)
    drifting = signal_changed("vehicle speed", lambda t, v: v + 0.25 * (t - 8.0), 8.0, 11.0)
    frames = recording.frames if set_s < 11.0 else drifting(recording.frames)
    told = play(recording.settings, clock_set(set_s, -600.0)(frames))
    times_s = np.array([estimate.time_s for estimate in told])
    judged = Judged.of(recording, told, np.where(np.cumsum(np.diff(times_s, prepend=times_s[0]) < -1.0), -600.0, 0.0))
    judged.assert_sound()
    judged.assert_honest()
    again = judged.during(12.2, 13.0) if set_s < 11.0 else judged.during(22.0)
    assert_normal(again)
    assert again.friction_statuses(0) == again.friction_statuses(1) == {VALID}


@pytest.mark.parametrize("jump_s", [-3600.0, -0.5, 0.5, 3600.0])
def test_a_clock_that_is_known_to_be_set_is_no_silence(jump_s: float) -> None:
    """The daemon sees that the clock was set; a recording does not tell it from a recorder that was off."""
    recording = drive(DRY)
    pipeline = Pipeline.from_settings(recording.settings)
    alarms, last_s = [], 0.0
    for frame in clock_set(9.0, jump_s)(list(recording.frames)):
        if last_s and abs(frame.time_s - last_s - jump_s) < abs(frame.time_s - last_s):
            pipeline.clock_set(jump_s)
        last_s = frame.time_s
        alarms += pipeline.step(frame).alarms
    assert alarms == []


def test_what_waits_for_a_slow_sensor_is_dropped_when_the_clock_is_set_back() -> None:
    """Else it would be let in when the clock comes by again, an hour old."""
    speed, wheel = (replace(c, delay_s=d) for c, d in zip(decoder_of_the_wagon().channels[:2], (0.1, 0.0), strict=True))
    alignment = Alignment([speed, wheel])
    given = []
    for time_s in (3600.0, 0.0, 0.5, 3700.0):
        given += alignment.put(Sample(time_s, wheel.quantity, wheel.wheelset, time_s, Quality.GOOD))
    assert [sample.time_s for sample in given] == [0.0, 0.5]


# -- the drive -----------------------------------------------------------------------------------------------------


def test_a_start_in_the_middle_of_a_braking_converges() -> None:
    """Neither friction nor gradient could be learned before: it knows less than usual, and says so."""
    judged = through(SLIDE, silence(0.0, 8.0), 16.0)
    judged.assert_honest()
    assert judged.during(8.4, 10.9).statuses == {CONVERGING}
    settled = judged.during(11.5)
    assert settled.statuses == {VALID}
    assert settled.rmse < 0.004


def test_fifteen_minutes_of_coasting_and_then_a_brake() -> None:
    """The coasting after the first braking goes on down a gentle slope that keeps up the speed, then as recorded."""
    recording = drive(DRY)
    decoder = SignalDecoder.from_settings(recording.settings)
    estimator = Estimator(recording.settings.vehicle, recording.settings.estimator, decoder.channels)
    samples = list(chain.from_iterable(decoder.decode(frame) for frame in recording.frames))
    stretched_s, coasted_s = EPOCH_S + 14.2, 900.0
    for sample in samples:
        if sample.time_s < stretched_s:
            estimator.take(sample)
    learned = [w.friction for w in estimator.estimate(0.0).wheelsets]
    level = [s for s in samples if stretched_s <= s.time_s < stretched_s + 0.05]
    noise_std = {Quantity.SPEED: 0.02, Quantity.AXLE_SPEED: 0.0225}
    rng = np.random.default_rng(2)
    for fifth in range(round(coasted_s * 5)):
        for sample in level:
            value = sample.value + rng.normal() * noise_std.get(sample.quantity, 0.0)
            estimator.take(sample._replace(time_s=sample.time_s + fifth / 5, value=value))
    told = []
    for sample in (s for s in samples if s.time_s >= stretched_s):
        estimator.take(sample._replace(time_s=sample.time_s + coasted_s))
        told.append(estimator.estimate(sample.time_s))
    whole = Judged.of(recording, told[::40])
    judged = whole.during(20.0)  # that the slope ends at once is doubted until here
    judged.assert_sound()
    judged.assert_honest()
    begun = whole.during(17.0, 18.5).told
    assert begun
    assert all(abs(w.friction - before) < 0.03 for e in begun for w, before in zip(e.wheelsets, learned, strict=True))
    assert_normal(judged)


def test_standing_for_hours() -> None:
    """A reading of each sensor every 0.8 s for three hours, brakes on."""
    recording = drive(DRY)
    estimator, standing = after_a_stop(recording)
    for k in range(13_500):
        for sample in standing:
            estimator.take(sample._replace(time_s=sample.time_s + 0.8 * k))
        if k % 100 == 99:
            estimate = estimator.estimate(0.0)
            assert np.isfinite(numbers(estimate)).all()
            assert estimate.status is HELD
            assert estimate.speed_mps < 0.01
            assert max(w.friction_std for w in estimate.wheelsets) < 0.1


def test_standing_wears_no_pad_and_covers_no_way() -> None:
    """Brakes on for an hour. Speeds without a sign read their noise: a night of it would be half a stop's energy."""
    estimator, standing = after_a_stop(drive(DRY))
    rng = np.random.default_rng(3)
    noise_std = {Quantity.SPEED: 0.02, Quantity.AXLE_SPEED: 0.0225}
    settled = None
    for k in range(4_500):
        for sample in standing:
            value = abs(sample.value + rng.normal() * noise_std.get(sample.quantity, 0.0))
            estimator.take(sample._replace(time_s=sample.time_s + 0.8 * k, value=value))
        estimate = estimator.estimate(0.0)
        if settled is None and estimate.speed_mps < 0.1:
            settled = estimate
    assert settled is not None
    assert estimate.distance_m == settled.distance_m
    for before, after in zip(settled.wheelsets, estimate.wheelsets, strict=True):
        assert after.pressing_force_n > 20e3
        assert after.work.pad_energy_j == before.work.pad_energy_j
        assert after.work.force_travel_nm == before.work.force_travel_nm


def after_a_stop(recording: Recording) -> tuple[Estimator, list[Sample]]:
    """An estimator that knows the wagon from a drive, and the readings of a wagon that stands with its brakes on."""
    decoder = SignalDecoder.from_settings(recording.settings)
    estimator = Estimator(recording.settings.vehicle, recording.settings.estimator, decoder.channels)
    samples = list(chain.from_iterable(decoder.decode(frame) for frame in recording.frames[:2000]))
    for sample in samples:
        estimator.take(sample)
    still = {Quantity.SPEED: 0.0, Quantity.AXLE_SPEED: 0.0}
    last = {(s.quantity, s.wheelset): s._replace(value=still.get(s.quantity, s.value)) for s in samples}
    end_s = samples[-1].time_s
    return estimator, [sample._replace(time_s=end_s + 0.5) for sample in last.values()]


UNPROTECTED = Scenario(
    name="locked",
    summary="a wagon without slide protection brakes on leaves and drags its wheelsets until the brake is released",
    initial_speed_mps=25.0,
    duration_s=19.0,
    demand=steps((4.0, 1.0), (11.0, 0.0), (14.0, 0.3)),
    rail_over_time=Profile(((4.0, 0.3), (5.0, 0.05), (11.5, 0.05), (12.5, 0.3))),
)


def test_locked_wheelsets_are_dragged_and_let_go() -> None:
    recording = drive(UNPROTECTED, Modifiers(slide_protection=False))
    judged = Judged.of(recording, play(recording.settings, recording.frames))
    judged.assert_sound()
    judged.assert_honest()
    locked = (judged.truth.omega_radps[:, 0] == 0.0) & (judged.truth.speed_mps > 5.0)
    assert locked.sum() > 20
    dragged = [e for e, is_locked in zip(judged.told, locked, strict=True) if is_locked][3:]
    assert all(e.saturated and e.wheelsets[0].slip > 0.97 for e in dragged)
    assert {e.wheelsets[0].friction_status for e in dragged} == {HELD}
    assert_normal(judged.during(15.0))


def test_a_rail_that_changes_under_locked_wheelsets_is_not_taken_for_a_gradient() -> None:
    """It gives twice as much from one moment to the next, and only the vehicle's speed shows it."""
    settings = example_settings("bogie")
    vehicle = struct_replace(settings.vehicle, mass_kg=0.35 * settings.vehicle.mass_kg)
    empty = struct_replace(settings, vehicle=vehicle)
    better = Scenario(
        name="better rail",
        summary="an empty wagon without slide protection brakes on a damp rail that is dry from 16 s on",
        initial_speed_mps=33.0,
        duration_s=28.0,
        demand=steps((4.0, 0.75)),
        rail_over_time=Profile(((0.0, 0.15), (16.0, 0.15), (16.3, 0.3))),
    )
    recording = simulate(better, empty, seed=1, modifiers=Modifiers(slide_protection=False))
    judged = Judged.of(recording, play(recording.settings, recording.frames)).during(4.0)
    stands = np.all(judged.truth.omega_radps == 0.0, axis=1)
    assert np.ptp(judged.truth.adhesion[stands]) > 0.05
    judged.assert_honest()
    assert judged.during(20.0, 24.0).worst < 0.015


class Chatter(WheelSlideProtection):
    """Vents and fills both cylinders in turn, three times a second, whatever the wheels do."""

    _ticks = 0

    def active(self, wheelset: int) -> bool:
        return True

    def step(self, wheel_speeds_mps: list[float]) -> list[Valve]:
        self._ticks += 1
        return [Valve.DUMP if self._ticks % 32 < 16 else Valve.FILL] * len(wheel_speeds_mps)


def test_slide_protection_that_vents_the_brake_three_times_a_second(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("brake_monitor.simulator.plant.WheelSlideProtection", Chatter)
    recording = simulate(replace(DRY, duration_s=14.0), example_settings("wagon"), seed=6)
    judged = Judged.of(recording, play(recording.settings, recording.frames))
    judged.assert_sound()
    judged.assert_honest()
    released = judged.truth.pressing_force_n[:, 0] == 0.0
    assert np.count_nonzero(np.diff(released[(judged.time_s > 6.0) & (judged.time_s < 13.0)])) > 10
    braked = judged.during(6.0, 13.0)
    assert_normal(braked)
    assert braked.friction_statuses(0) == {HELD, VALID}


# -- anything at all -----------------------------------------------------------------------------------------------

ANY_VALUE = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True),
    st.sampled_from([0.0, 1e-300, -1.0, 1.0, 20.0, 45.0, 40_000.0, 1e12, 1e308]),
    st.floats(0.0, 100.0),
)
ANY_STEP = st.one_of(st.floats(0.0, 0.05), st.floats(-0.1, 2.0), st.sampled_from([-3600.0, 3600.0, 1e9, -1e9, 0.0]))
SOUP = st.lists(
    st.tuples(ANY_STEP, st.sampled_from(list(Quantity)), st.integers(0, 1), ANY_VALUE, st.sampled_from(list(Quality))),
    max_size=60,
)


@settings(max_examples=150, deadline=None)
@given(soup=SOUP, settle=st.booleans())
@example(soup=[(0.0, Quantity.LATITUDE, 0, np.inf, Quality.GOOD)], settle=True)
def test_no_soup_of_samples_makes_it_fail(soup: list, settle: bool) -> None:
    """Random times, quantities, values and qualities, upon a fresh estimator or in the middle of a braking."""
    recording = drive(DRY)
    decoder = SignalDecoder.from_settings(recording.settings)
    estimator = Estimator(recording.settings.vehicle, EstimatorSettings(), decoder.channels)
    time_s = EPOCH_S
    if settle:
        for frame in recording.frames[1150:1250]:
            time_s = frame.time_s
            for sample in decoder.decode(frame):
                estimator.take(sample)
    for step_s, quantity, wheelset, value, quality in soup:
        if (quantity, wheelset) not in {(c.quantity, c.wheelset) for c in decoder.channels}:
            continue
        time_s += step_s
        estimator.take(Sample(time_s, quantity, wheelset, value, quality))
        assert np.isfinite(numbers(estimator.estimate(time_s))).all()


@pytest.mark.parametrize("spoilt", [np.nan, np.inf])
@pytest.mark.parametrize("part", ["state", "variance"])
def test_numbers_that_have_broken_down_are_given_up_and_learned_anew(part: str, spoilt: float) -> None:
    """No input is known that breaks them; a processor's bit may."""
    recording = drive(DRY)
    frames, pipeline = list(recording.frames), Pipeline.from_settings(recording.settings)
    before = sum(frame.time_s < EPOCH_S + 8.0 for frame in frames)
    play_to(pipeline, frames[:before])
    brakes, friction = pipeline.estimator.core.filter, pipeline.estimator.core.friction_place
    vector = brakes.x if part == "state" else brakes.covariance[friction]
    vector[friction] = spoilt
    seen = Judged.of(recording, play_to(pipeline, frames[before:])).during(8.2)
    seen.assert_sound()
    seen.assert_honest()
    assert seen.during(20.0).statuses == {VALID}


@pytest.mark.parametrize("time_s", [float("nan"), float("inf"), float("-inf")])
def test_a_sample_of_no_time_is_not_taken(time_s: float) -> None:
    recording = drive(DRY)
    decoder = SignalDecoder.from_settings(recording.settings)
    estimator = Estimator(recording.settings.vehicle, EstimatorSettings(), decoder.channels)
    assert not estimator.take(Sample(time_s, Quantity.SPEED, 0, 20.0, Quality.GOOD))
    assert estimator.take(Sample(EPOCH_S, Quantity.SPEED, 0, 20.0, Quality.GOOD))
    for told_s, force_n in [(EPOCH_S, 0.0), (time_s, 40e3)]:
        estimator.take(Sample(told_s, Quantity.PRESSING_FORCE, 0, force_n, Quality.GOOD))
    assert estimator.estimate().wheelsets[0].pressing_force_n == 0.0


def test_values_that_no_wagon_has_are_told_and_not_taken() -> None:
    decoder = decoder_of_the_wagon()
    estimator = Estimator(drive(DRY).settings.vehicle, EstimatorSettings(), decoder.channels)
    for quantity, value in [(Quantity.SPEED, 1e6), (Quantity.AXLE_SPEED, 1e5), (Quantity.PRESSING_FORCE, float("nan"))]:
        assert not estimator.take(Sample(EPOCH_S, quantity, 0, value, Quality.GOOD))
        assert f"{quantity} 1 impossible" in estimator.estimate(EPOCH_S).reasons


def test_a_load_sensor_that_says_zero_does_not_make_the_wagon_weightless() -> None:
    recording = drive(DRY)
    decoder = SignalDecoder.from_settings(recording.settings)
    estimator = Estimator(recording.settings.vehicle, EstimatorSettings(), decoder.channels)
    estimator.take(Sample(EPOCH_S, Quantity.LOAD_FORCE, 0, 0.0, Quality.GOOD))
    assert estimator.estimate().mass_kg == recording.settings.vehicle.mass_kg
