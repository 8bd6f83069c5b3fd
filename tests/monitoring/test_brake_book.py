"""The books of the brake units: nothing counted twice, nothing lost, one record per brake application."""

from math import exp

import pytest
from msgspec.structs import replace

from brake_monitor.estimation.brake_work import WheelsetWork
from brake_monitor.estimation.estimate import Estimate, Status
from brake_monitor.estimation.model.wagon import GRAVITY_MPS2
from brake_monitor.monitoring.brake_units.application_record import ApplicationRecord
from brake_monitor.monitoring.brake_units.brake_book import BrakeBook
from brake_monitor.monitoring.brake_units.brakes import Brakes
from brake_monitor.monitoring.brake_units.gauge import Gauge, after_gauge
from brake_monitor.monitoring.brake_units.wear import archard_loss_mm, energy_loss_mm, pad_life
from brake_monitor.monitoring.creep_meter import CreepMeter
from brake_monitor.monitoring.reports import InputReports
from brake_monitor.samples import InputCondition, Quantity
from brake_monitor.settings.alarm_settings import UnevenBrakingRule
from brake_monitor.settings.wear_settings import WearSettings
from estimates import estimate, report, wheelset

WEAR = WearSettings()
FORCE_N, FRICTION, BRAKE_RADIUS_M, WHEEL_RADIUS_M = 40e3, 0.34, 0.247, 0.45
SOUND = InputReports()
LOST = InputReports([report(Quantity.PRESSING_FORCE, 1, "BCU.p_B", InputCondition.LOST)])
ALL_LOST = InputReports([*LOST, report(Quantity.PRESSING_FORCE, 0, "BCU.p_A", InputCondition.LOST)])


class Drive:
    """Two wheelsets that brake from 10 s to 20 s by 1 m/s² from 30 m/s on; totals begin at 0."""

    def __init__(
        self,
        begin_s: float = 0.0,
        end_s: float = 30.0,
        second_n: float = FORCE_N,
        later_mps2: float = 0.01,
        creep: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """`second_n`: how the second brake presses; `later_mps2`: the unmodelled deceleration from 20 s on.

        `creep` is each wheelset's as it brakes.
        """
        self.estimates: list[Estimate] = []
        travel_nm, distance_m = [0.0, 0.0], 0.0
        for k in range(round(begin_s * 10), round(end_s * 10)):
            time_s = k / 10
            brakes = 10.0 <= time_s < 20.0
            speed_mps = 30.0 - min(max(time_s - 10.0, 0.0), 10.0)
            forces_n = (FORCE_N, second_n) if brakes else (0.0, 0.0)
            omega_radps = speed_mps / WHEEL_RADIUS_M
            distance_m += 0.1 * speed_mps
            travel_nm = [t + 0.1 * f * BRAKE_RADIUS_M * omega_radps for t, f in zip(travel_nm, forces_n, strict=True)]
            wheelsets = tuple(
                wheelset(
                    omega_radps=omega_radps * (1.0 - own_creep * brakes),
                    adhesion=1.0 / GRAVITY_MPS2 if brakes else 0.0,
                    slip=0.002 * brakes,
                    friction=FRICTION,
                    friction_status=Status.VALID if force_n > 0.0 else Status.HELD,
                    pressing_force_n=force_n,
                    work=WheelsetWork(FRICTION * travel, travel),
                )
                for force_n, travel, own_creep in zip(forces_n, travel_nm, creep, strict=True)
            )
            now = estimate(
                time_s=time_s,
                speed_mps=speed_mps,
                distance_m=distance_m,
                adhesion=1.0 / GRAVITY_MPS2 if brakes else 0.0,
                wheelsets=wheelsets,
                saturated=False,
                deceleration_mps2=0.01 if time_s < 20.0 else later_mps2,
            )
            self.estimates.append(now)

    @property
    def energy_j(self) -> list[float]:
        return [own.work.pad_energy_j for own in self.estimates[-1].wheelsets]


def keep(book: BrakeBook, drive: Drive, inputs: InputReports = SOUND) -> list[ApplicationRecord]:
    return [stop for now in drive.estimates for stop in book.see(now, inputs)]


def new_book(settings: WearSettings = WEAR) -> BrakeBook:
    return BrakeBook(2, settings, 2000.0, CreepMeter(2000.0), 1)


def test_a_brake_application_is_one_record_of_what_was_done() -> None:
    drive = Drive()
    (stop,) = keep(new_book(), drive)
    assert (stop.start_time_s, stop.end_time_s) == pytest.approx((9.9, 19.9))
    assert (stop.start_speed_mps, stop.end_speed_mps) == pytest.approx((30.0, 20.1))
    assert stop.greatest_deceleration_mps2 == pytest.approx(1.0, rel=0.01)
    assert stop.distance_m == pytest.approx(0.5 * (30.0 + 20.1) * 10.0, rel=0.01)
    for own, energy_j in zip(stop.wheelsets, drive.energy_j, strict=True):
        assert own.energy_j == pytest.approx(energy_j)
        assert own.friction == pytest.approx(FRICTION)
        assert own.torque_nm == pytest.approx(FRICTION * FORCE_N * BRAKE_RADIUS_M)
        assert own.creep == pytest.approx(0.0)  # both turn as freely as before


@pytest.mark.parametrize(("motor_force_n", "records"), [(10e3, 1), (0.0, 2)])
def test_a_brake_that_leaves_the_work_to_its_motor_does_not_end_the_application(
    motor_force_n: float, records: int
) -> None:
    drive = Drive()
    for k, now in enumerate(drive.estimates):
        if 12.0 <= now.time_s < 17.0:
            first, second = now.wheelsets
            second = replace(second, pressing_force_n=0.0, motor_force_n=motor_force_n)
            drive.estimates[k] = replace(now, wheelsets=(first, second))
    assert len(keep(new_book(), drive)) == records


def touched(pressed_s: float) -> Drive:
    """A drive whose brake is let go so soon after it has come on."""
    drive = Drive()
    drive.estimates = [now for now in drive.estimates if not 10.0 + pressed_s <= now.time_s < 20.0]
    drive.estimates = [
        replace(now, time_s=now.time_s - (now.time_s >= 20.0) * (10.0 - pressed_s)) for now in drive.estimates
    ]
    return drive


@pytest.mark.parametrize(("pressed_s", "is_told"), [(0.8, False), (1.2, True)])
def test_a_touch_of_the_brake_is_no_brake_application(pressed_s: float, is_told: bool) -> None:
    book = new_book()
    assert len(keep(book, touched(pressed_s))) == is_told
    assert [unit.pads.since_fitted.stops for unit in book.brakes.units] == [is_told] * 2


@pytest.mark.parametrize(("reasons", "is_told"), [((), True), (("an input is late",), False)])
def test_friction_that_is_not_sure_yet_counts_by_its_deviation_but_not_where_an_input_makes_it_doubtful(
    reasons: tuple[str, ...], is_told: bool
) -> None:
    drive = Drive()
    for k, now in enumerate(drive.estimates):
        unsure = [
            replace(own, friction_status=Status.CONVERGING) if own.pressing_force_n else own for own in now.wheelsets
        ]
        drive.estimates[k] = replace(now, wheelsets=tuple(unsure), reasons=reasons)
    (stop,) = keep(new_book(), drive)
    expected = pytest.approx(FRICTION) if is_told else None
    assert [own.friction for own in stop.wheelsets] == [expected] * 2


def test_creep_tells_of_torque_as_long_as_it_is_proportional_to_adhesion() -> None:
    """An adhesion of 0.10 is what 2 ‰ of creep give on a rail that is no more than damp, a brake that grabs included.

    Where 6 ‰ are needed the curve bends, and its peak is elsewhere under each wheelset.
    """
    (damp,) = keep(new_book(), Drive(creep=(0.0015, 0.0028)))
    assert [own.creep for own in damp.wheelsets] == pytest.approx([0.0015, 0.0028], rel=0.15)  # after a second
    (slippery,) = keep(new_book(), Drive(creep=(0.0028, 0.0112)))
    assert [own.creep for own in slippery.wheelsets] == [None, None]
    torque_nm = FRICTION * FORCE_N * BRAKE_RADIUS_M
    assert [own.torque_nm for own in slippery.wheelsets] == pytest.approx([torque_nm, torque_nm], rel=0.02)


def test_creep_tells_nothing_of_torque_where_a_wheelset_slid_later_in_the_application() -> None:
    """On its way onto leaves the leading wheelset crept more and more under the same torque, until it slid.

    On the whole the rail still gave 0.03 for each mille of creep, and more under the wheelset that followed.
    """
    drive = Drive(creep=(0.0045, 0.0015))
    for k, now in enumerate(drive.estimates):
        drive.estimates[k] = replace(now, saturated=17.0 <= now.time_s < 18.0)
    (stop,) = keep(new_book(), drive)
    assert [own.creep for own in stop.wheelsets] == [None, None]
    torque_nm = FRICTION * FORCE_N * BRAKE_RADIUS_M
    assert [own.torque_nm for own in stop.wheelsets] == pytest.approx([torque_nm, torque_nm], rel=0.02)


def test_who_bears_less_load_creeps_more_under_the_same_torque() -> None:
    """As the second of the two does while the wagon pitches, or its bogie."""
    drive, loads = Drive(creep=(0.0018, 0.0022)), (1.1, 0.9)
    for k, now in enumerate(drive.estimates):
        pitched = [replace(own, relative_load=load) for own, load in zip(now.wheelsets, loads, strict=True)]
        drive.estimates[k] = replace(now, wheelsets=tuple(pitched))
    (stop,) = keep(new_book(), drive)
    first, second = (own.creep or 0.0 for own in stop.wheelsets)
    assert first == pytest.approx(0.00198, rel=0.15)  # after a second
    assert second == pytest.approx(first)


def test_the_pads_took_what_the_estimator_says() -> None:
    book, drive = new_book(), Drive()
    keep(book, drive)
    for unit, energy_j in zip(book.brakes.units, drive.energy_j, strict=True):
        assert unit.pads.since_fitted.energy_j == pytest.approx(energy_j)
        assert unit.pads.since_fitted.stops == 1.0
        assert unit.pads.since_fitted.distance_m == pytest.approx(drive.estimates[-1].distance_m)


def test_a_restart_counts_nothing_twice_and_loses_nothing() -> None:
    """The second run's totals begin at 0 again, and it resumes what the first one knew."""
    first, second = Drive(0.0, 15.0), Drive(15.0, 30.0)
    book = new_book()
    keep(book, first)
    restarted = new_book()
    restarted.resume(book.brakes)
    keep(restarted, second)
    for i, unit in enumerate(restarted.brakes.units):
        assert unit.pads.since_fitted.energy_j == pytest.approx(first.energy_j[i] + second.energy_j[i])
        assert unit.pads.since_fitted.energy_j == pytest.approx(Drive().energy_j[i])


THINNER = WearSettings(new_pad_thickness_mm=24.0, specific_wear_cm3_per_mj=0.4, archard_mm3_per_nm=1e-4)


@pytest.mark.parametrize("is_late", [False, True])
def test_pads_of_which_nobody_noted_anything_are_as_the_settings_say_now(*, is_late: bool) -> None:
    """The first start is often one with an example's figures, which are put right afterwards."""
    before = new_book()
    keep(before, Drive())
    book = new_book(THINNER)
    if is_late:
        keep(book, Drive(40.0, 40.2))
    book.resume(before.brakes)
    for then, now in zip(before.brakes.units, book.brakes.units, strict=True):
        told, life = then.pads.since_fitted, pad_life(now.pads, THINNER)
        assert now.pads.since_fitted.energy_j == pytest.approx(told.energy_j)
        assert 24.0 - life.by_energy.value_mm == pytest.approx(energy_loss_mm(told.energy_j, 0.4, THINNER))
        assert 24.0 - life.by_archard.value_mm == pytest.approx(archard_loss_mm(told.force_travel_nm, 1e-4, THINNER))


@pytest.mark.parametrize("thickness_mm", [None, 31.4], ids=["new pads", "measured"])
def test_what_a_person_noted_of_pads_stays_when_the_settings_change(thickness_mm: float | None) -> None:
    before = new_book()
    keep(before, Drive())
    noted = after_gauge(before.brakes, Gauge(30.0, 1, thickness_mm), WEAR)
    book = new_book(THINNER)
    book.resume(noted)
    assert book.brakes.units[0].pads == noted.units[0].pads


@pytest.mark.parametrize("thickness_mm", [None, 20.0])
def test_what_a_person_noted_is_of_the_pads_of_one_wheelset(thickness_mm: float | None) -> None:
    book = new_book()
    keep(book, Drive())
    first, second = book.brakes.units
    noted = after_gauge(book.brakes, Gauge(50.0, 2, thickness_mm), WEAR).units
    assert noted[0] == first
    assert noted[1].disc_temperature_c == second.disc_temperature_c
    assert noted[1].pads.gauge_thickness_mm == (thickness_mm or WEAR.new_pad_thickness_mm)
    assert (noted[1].pads.fitted_time_s, noted[1].pads.gauged_time_s) == (
        (None, 50.0) if thickness_mm else (50.0, None)
    )


def test_a_late_disk_may_bring_brake_units_that_were_never_observed() -> None:
    """A person noted new pads before the daemon ran for the first time."""
    book = new_book()
    keep(book, Drive())
    before = book.brakes
    book.resume(after_gauge(Brakes.new(2, WEAR), Gauge(-50.0, 1, 30.0), WEAR))
    for unit, old in zip(book.brakes.units, before.units, strict=True):
        assert unit.disc_temperature_c == old.disc_temperature_c
        assert unit.pads.since_fitted == old.pads.since_fitted
    assert [unit.pads.gauge_thickness_mm for unit in book.brakes.units] == [30.0, WEAR.new_pad_thickness_mm]


def restarted(pause_s: float) -> tuple[list[ApplicationRecord], list[Drive], BrakeBook]:
    """The program ends at 15 s, in the midst of the braking, and begins anew so much later."""
    drives = [Drive(0.0, 15.0), Drive(15.0 + pause_s, 30.0 + pause_s)]
    first, second = new_book(), new_book()
    stops = keep(first, drives[0])
    second.resume(first.kept)
    return stops + keep(second, drives[1]), drives, second


def test_a_braking_is_one_though_the_program_began_anew_meanwhile() -> None:
    """What was braked in the pause nobody knows, nor any mean over all of it."""
    (stop,), (first, second), book = restarted(1.0)
    assert (stop.start_time_s, stop.end_time_s) == pytest.approx((9.9, 19.9))
    assert (stop.start_speed_mps, stop.end_speed_mps) == pytest.approx((30.0, 20.1))
    assert stop.greatest_deceleration_mps2 == pytest.approx(1.0, rel=0.01)
    assert stop.distance_m == pytest.approx(0.5 * (30.0 + 20.1) * 9.0, rel=0.05)
    for i, own in enumerate(stop.wheelsets):
        assert own.energy_j == pytest.approx(first.energy_j[i] + second.energy_j[i], rel=0.02)
        assert own.force_travel_nm == pytest.approx(own.energy_j / FRICTION)
        assert (own.friction, own.torque_nm, own.creep) == (None, None, None)
    assert [unit.pads.since_fitted.stops for unit in book.brakes.units] == [1.0, 1.0]
    assert book.kept.running is None


@pytest.mark.parametrize(
    ("ended_s", "told_s", "times_s"),
    [
        (15.0, 16.5, [9.9, 19.9]),
        (15.0, 19.5, [9.9, 19.9]),
        (15.0, 21.0, [9.9, 14.9]),
        (13.0, 21.0, [9.9, 12.9, 17.9, 19.9]),  # more than five seconds of it nobody saw
    ],
)
def test_a_braking_is_one_though_forces_are_told_before_the_speed_is(
    ended_s: float, told_s: float, times_s: list[float]
) -> None:
    """A second after the program ended all forces are awaited, then the speed, which comes each second or so."""
    first, second = new_book(), new_book()
    stops = keep(first, Drive(0.0, ended_s))
    second.resume(first.kept)
    awaited = [report(Quantity.PRESSING_FORCE, i, f"BCU.p_{i}", InputCondition.AWAITED) for i in range(2)]
    for now in Drive(ended_s + 1.0, 40.0).estimates:
        if now.time_s < ended_s + 1.1:
            own = tuple(replace(wheelset, pressing_force_n=0.0) for wheelset in now.wheelsets)
            stops += second.see(replace(now, status=Status.INVALID, wheelsets=own), InputReports(awaited))
        else:
            stops += second.see(replace(now, status=Status.INVALID) if now.time_s < told_s else now, SOUND)
    assert [time_s for stop in stops for time_s in (stop.start_time_s, stop.end_time_s)] == pytest.approx(times_s)


def test_of_an_interrupted_braking_the_worst_of_both_parts_is_told() -> None:
    """The first wheelset slid before the pause, and its discs were hotter then; the second one after it."""
    (stop,), _, _ = restarted(1.0)
    one = replace(stop.wheelsets[0], greatest_slip=0.3, peak_disc_temperature_c=90.0, wsp_actions=2)
    part = replace(stop, wheelsets=(one, stop.wheelsets[1]), greatest_deceleration_mps2=1.5, greatest_adhesion=0.2)
    later = replace(stop, wheelsets=part.wheelsets[::-1])
    for whole in (part.then(later), later.then(part)):
        assert [own.greatest_slip for own in whole.wheelsets] == [0.3, 0.3]
        assert [own.peak_disc_temperature_c for own in whole.wheelsets] == [90.0, 90.0]
        assert [own.wsp_actions for own in whole.wheelsets] == [2, 2]
        assert [own.friction_energy_j for own in whole.wheelsets] == [0.0, 0.0]
        assert (whole.greatest_deceleration_mps2, whole.greatest_adhesion) == (1.5, 0.2)


def test_a_braking_is_one_though_slide_protection_has_let_a_brake_go_as_the_program_begins_anew() -> None:
    first, second = new_book(), new_book()
    stops = keep(first, Drive(0.0, 15.0))
    second.resume(first.kept)
    for now in Drive(16.0, 30.0).estimates:
        one, other = now.wheelsets
        let_go = replace(other, pressing_force_n=other.pressing_force_n * (now.time_s >= 17.0))
        stops += second.see(replace(now, wheelsets=(one, let_go)), SOUND)
    (stop,) = stops
    assert (stop.start_time_s, stop.end_time_s) == pytest.approx((9.9, 19.9))


def test_a_braking_that_ended_in_a_short_pause_is_told_as_far_as_it_was_seen() -> None:
    first, second = new_book(), new_book()
    seen = keep(first, Drive(0.0, 18.0))
    second.resume(first.kept)
    (stop,) = seen + keep(second, Drive(20.5, 30.0))
    assert stop == first.kept.running


@pytest.mark.parametrize("pause_s", [5.0, 6.0, 100.0])
def test_a_braking_that_ended_while_the_program_did_not_run_is_told_as_far_as_it_was_seen(pause_s: float) -> None:
    (stop,), (first, _), book = restarted(pause_s)
    assert stop.end_time_s == pytest.approx(14.9)
    for own, energy_j in zip(stop.wheelsets, first.energy_j, strict=True):
        assert own.energy_j == pytest.approx(energy_j)
        assert own.friction == pytest.approx(FRICTION)
    assert [unit.pads.since_fitted.stops for unit in book.brakes.units] == [1.0, 1.0]


def test_a_braking_that_the_program_comes_upon_a_while_after_it_ended_in_one_is_another_one() -> None:
    first, second = new_book(), new_book()
    keep(first, Drive(0.0, 15.0))
    second.resume(first.kept)
    later = [replace(now, time_s=now.time_s + 100.0) for now in Drive(12.0, 30.0).estimates]
    (stop,) = [found for now in later for found in second.see(now, SOUND)]
    assert stop == first.kept.running


def test_discs_warm_by_the_energy_and_cool_in_a_pause() -> None:
    book, drive = new_book(), Drive()
    keep(book, drive)
    capacity_jpk = WEAR.discs_per_wheelset * WEAR.disc_mass_kg * WEAR.disc_heat_capacity_jpkgk
    warm_c = book.brakes.units[0].disc_temperature_c
    assert warm_c - WEAR.ambient_c == pytest.approx(drive.energy_j[0] / capacity_jpk, rel=0.05)
    later = new_book()
    later.resume(book.brakes)
    (first, *_) = Drive(3600.0, 3600.2).estimates
    later.see(first, SOUND)
    assert WEAR.ambient_c < later.brakes.units[0].disc_temperature_c < warm_c


@pytest.mark.parametrize("found_s", [0.1, 15.0, 25.0])
@pytest.mark.parametrize("pause_s", [60.0, 1800.0])
def test_what_a_late_disk_brings_adds_up_as_if_it_had_come_in_time(found_s: float, pause_s: float) -> None:
    """Energy, applications, and the heat that is left in the discs; the braking of this run is from 10 to 20 s."""
    first = new_book()
    keep(first, Drive(0.0, 25.0))
    shift_s = 25.0 + pause_s
    again = [replace(now, time_s=now.time_s + shift_s) for now in Drive().estimates]
    in_time, late = new_book(), new_book()
    in_time.resume(first.kept)
    for k, now in enumerate(again):
        in_time.see(now, SOUND)
        late.see(now, SOUND)
        if k == round(10 * found_s):
            late.resume(first.kept)
    for unit, expected in zip(late.brakes.units, in_time.brakes.units, strict=True):
        assert unit.disc_temperature_c == pytest.approx(expected.disc_temperature_c, abs=0.05)
        assert unit.pads.since_fitted.energy_j == pytest.approx(expected.pads.since_fitted.energy_j)
        assert unit.pads.since_fitted.stops == 2.0
    assert max(unit.disc_temperature_c for unit in first.brakes.units) > WEAR.ambient_c + 10.0
    assert [stop.start_time_s for stop in late.brakes.applications] == pytest.approx([9.9, 9.9 + shift_s])


def test_a_wheelset_whose_force_is_not_measured_is_taken_to_do_what_the_other_does() -> None:
    """Its last value is held, however long ago it was."""
    book = new_book()
    drive = Drive(second_n=70e3)
    keep(book, drive, LOST)
    assert book.brakes.units[1].pads.since_fitted.energy_j == pytest.approx(drive.energy_j[0])


def test_friction_counts_only_where_all_brakes_press() -> None:
    (stop,) = keep(new_book(), Drive(second_n=0.0))
    assert [own.friction for own in stop.wheelsets] == [None, None]
    assert stop.wheelsets[0].energy_j > 0.0


@pytest.mark.parametrize("known_s", [5.0, 15.0])
def test_with_a_brake_that_is_known_to_drag_unseen_no_friction_is_told(known_s: float) -> None:
    """It is part of how the wagon rolled before: of what it adds under the brake only that shows."""
    drive, book = Drive(), new_book()
    ended = [book.see(now, SOUND, a_brake_drags=now.time_s >= known_s) for now in drive.estimates]
    (stop,) = [record for records in ended for record in records]
    assert [(own.friction, own.torque_nm) for own in stop.wheelsets] == [(None, None)] * 2
    assert [own.energy_j for own in stop.wheelsets] == pytest.approx(drive.energy_j)


def told_late(drive: Drive, until_s: float, after_s: float = 0.0) -> list[Estimate]:
    """The second brake's force stands still at 0 until then, and rises to what it is within `after_s`."""

    def told(now: Estimate) -> Estimate:
        first, second = now.wheelsets
        share = min(max(now.time_s - until_s, 0.0) / after_s, 1.0) if after_s else float(now.time_s >= until_s)
        return replace(now, wheelsets=(first, replace(second, pressing_force_n=share * second.pressing_force_n)))

    return [told(now) for now in drive.estimates]


@pytest.mark.parametrize("until_s", [12.0, 15.0])
def test_a_force_that_is_told_at_once_while_others_press_was_told_too_late(until_s: float) -> None:
    """Air does not fill a cylinder at once: what its brake did meanwhile nobody knows, and it is accused of nothing."""
    book, drive = new_book(), Drive()
    drive.estimates = told_late(drive, until_s)
    (stop,) = keep(book, drive)
    assert [own.torque_nm for own in stop.wheelsets] == [None, None]


def test_a_brake_that_fills_late_is_told_of_as_it_is() -> None:
    book, drive = new_book(), Drive()
    drive.estimates = told_late(drive, 12.0, 2.0)
    (stop,) = keep(book, drive)
    assert stop.wheelsets[1].pressing_force_n == pytest.approx(
        (250 - 58 - 54 / 2) / 250 * FORCE_N, rel=0.02
    )  # by way, m


@pytest.mark.parametrize("lag_s", [0.05, 0.1, 0.15, 0.2, 0.3])
@pytest.mark.parametrize("fill_s", [0.15, 0.3, 0.6, 1.5])
def test_brakes_that_fill_and_empty_one_soon_after_the_other_are_told_as_they_are(lag_s: float, fill_s: float) -> None:
    """Air comes to one cylinder first, and no two leave their discs at the same instant: no sensor began to tell."""

    def force_n(time_s: float) -> float:
        filled = 1.0 - exp(-min(max(time_s - 10.0, 0.0), 10.0) / fill_s)
        return FORCE_N * filled * exp(-max(time_s - 20.0, 0.0) / 0.8)

    book, drive = new_book(), Drive()
    for k, now in enumerate(drive.estimates):
        first, second = now.wheelsets
        first = replace(first, pressing_force_n=force_n(now.time_s))
        second = replace(second, pressing_force_n=force_n(now.time_s - lag_s))
        drive.estimates[k] = replace(now, wheelsets=(first, second))
    (stop,) = keep(book, drive)
    assert [own.friction for own in stop.wheelsets] == pytest.approx([FRICTION, FRICTION])
    assert None not in [own.torque_nm for own in stop.wheelsets]


def test_what_slide_protection_took_from_a_brake_tells_nothing_of_the_brake() -> None:
    """It acted before the wheelset slipped by what counts as a slide, and had the brake filled again 1.5 s later."""
    book, drive = new_book(), Drive()
    for k, now in enumerate(drive.estimates):
        first, second = now.wheelsets
        work = replace(second.work, wsp_actions=int(now.time_s >= 15.0))
        share = 0.25 if 15.0 <= now.time_s < 16.5 else 1.0
        second = replace(second, pressing_force_n=share * second.pressing_force_n, work=work)
        drive.estimates[k] = replace(now, wheelsets=(first, second))
    (stop,) = keep(book, drive)
    assert [own.pressing_force_n for own in stop.wheelsets] == pytest.approx([FORCE_N, FORCE_N], rel=0.02)
    assert stop.wheelsets[1].wsp_actions == 1


def test_two_of_four_that_go_on_pressing_do_not_go_on_with_the_brake_application() -> None:
    """They drag; the next application is another one."""
    book = BrakeBook(4, WEAR, 2000.0, CreepMeter(2000.0), 1)
    stops = []
    for now in Drive(end_s=40.0).estimates:
        drags = now.time_s >= 20.0
        sound = now.wheelsets[0]
        dragging = replace(sound, pressing_force_n=6e3 if drags else sound.pressing_force_n)
        stops += book.see(replace(now, wheelsets=(dragging, dragging, sound, sound)), SOUND)
    assert [stop.end_time_s for stop in stops] == pytest.approx([19.9])


@pytest.mark.parametrize(("lost", "lost_s"), [(LOST, 4.0), (LOST, 7.0), (ALL_LOST, 4.0)])
def test_a_braking_goes_on_while_a_pressing_force_is_not_known(lost: InputReports, lost_s: float) -> None:
    """What its record says of friction and torque would be the others'; the rest is known."""
    book, drive = new_book(), Drive()
    stops = [
        stop for now in drive.estimates for stop in book.see(now, lost if 12.0 <= now.time_s < 12.0 + lost_s else SOUND)
    ]
    (stop,) = stops
    assert (stop.start_time_s, stop.end_time_s) == pytest.approx((9.9, 19.9))
    assert [own.energy_j for own in stop.wheelsets] == pytest.approx(drive.energy_j)
    assert [own.torque_nm for own in stop.wheelsets] == [None, None]
    assert [unit.pads.since_fitted.stops for unit in book.brakes.units] == [1.0, 1.0]


def test_a_braking_of_which_nothing_was_known_for_long_is_told_in_two() -> None:
    drive, book = Drive(), new_book()
    before, after = [
        stop for now in drive.estimates for stop in book.see(now, ALL_LOST if 11.0 <= now.time_s < 18.0 else SOUND)
    ]
    assert (before.end_time_s, after.start_time_s, after.end_time_s) == pytest.approx((10.9, 17.9, 19.9))


@pytest.mark.parametrize("by_s", [3600.0, -3600.0])
def test_a_braking_is_one_though_the_clock_was_set_meanwhile(by_s: float) -> None:
    book, drive = new_book(), Drive()
    stops = []
    for now in drive.estimates:
        stops += book.see(replace(now, clock_ahead_s=by_s * (now.time_s >= 15.0)), SOUND)
    (stop,) = stops
    assert (stop.start_time_s, stop.end_time_s) == pytest.approx((9.9 + by_s, 19.9 + by_s))
    assert [own.energy_j for own in stop.wheelsets] == pytest.approx(drive.energy_j)
    assert stop.greatest_deceleration_mps2 == pytest.approx(1.0, rel=0.01)


def blended(drive: Drive) -> list[Estimate]:
    """Motors brake as well until 12 s."""
    return [
        replace(
            now,
            wheelsets=tuple(replace(own, motor_force_n=10e3 * (10.0 <= now.time_s < 12.0)) for own in now.wheelsets),
        )
        for now in drive.estimates
    ]


@pytest.mark.parametrize(("motors_until_s", "pressed_s", "is_told"), [(0.0, 1.2, True), (10.2, 3.4, False)])
def test_of_a_light_braking_torques_are_told_unless_motors_helped(
    motors_until_s: float, pressed_s: float, is_told: bool
) -> None:
    """For 1.2 s pads brake alone, with 220 kW each: rules judge from 100 kJ on, and beside motors from 300 kJ."""
    light = touched(pressed_s)
    light.estimates = [
        replace(now, wheelsets=tuple(replace(own, motor_force_n=10e3 * acts) for own in now.wheelsets))
        for now in light.estimates
        for acts in [10.0 <= now.time_s < motors_until_s]
    ]
    (stop,) = keep(new_book(), light)
    for own in stop.wheelsets:
        assert own.energy_j > UnevenBrakingRule().min_energy_j
        assert own.torque_nm == (pytest.approx(FRICTION * FORCE_N * BRAKE_RADIUS_M) if is_told else None)


def test_what_is_kept_of_a_braking_that_goes_on_changes_nothing_of_its_record() -> None:
    """Early on pads beside motors tell nothing of their torques; in the end they do."""
    book = new_book()
    stops = []
    for now in blended(Drive()):
        stops += book.see(now, SOUND)
        running = book.kept.running
        assert now.time_s != 13.0 or (running is not None and running.wheelsets[0].torque_nm is None)
    (stop,) = stops
    for own in stop.wheelsets:
        assert own.torque_nm == pytest.approx(FRICTION * FORCE_N * BRAKE_RADIUS_M)
        assert own.pressing_force_n == pytest.approx(FORCE_N)


def test_pads_settle_after_motors_also_over_a_clock_that_is_set_back() -> None:
    book, by_s, stops = new_book(), -3600.0, []
    for now in blended(Drive()):
        stops += book.see(replace(now, clock_ahead_s=by_s * (now.time_s >= 12.5)), SOUND)
    (stop,) = stops
    assert [own.torque_nm for own in stop.wheelsets] == pytest.approx([FRICTION * FORCE_N * BRAKE_RADIUS_M] * 2)


@pytest.mark.parametrize("by_s", [3600.0, -3600.0])
def test_where_nobody_tells_of_it_what_comes_after_is_another_record(by_s: float) -> None:
    """It is a gap in a recording, for all that is known. Both together say what the pads took."""
    book, drive = new_book(), Drive()
    shown = [replace(now, time_s=now.time_s + by_s * (now.time_s >= 15.0)) for now in drive.estimates]
    before, after = (stop for now in shown for stop in book.see(now, SOUND))
    assert (before.end_time_s, after.end_time_s) == pytest.approx((14.9, 19.9 + by_s))
    told_j = [early.energy_j + late.energy_j for early, late in zip(before.wheelsets, after.wheelsets, strict=True)]
    assert told_j == pytest.approx(drive.energy_j, rel=0.02)


def test_what_drags_when_a_clock_is_set_is_no_brake_application() -> None:
    book, drive = new_book(), Drive(end_s=40.0)
    for now in drive.estimates:
        first, second = now.wheelsets
        drags = replace(first, pressing_force_n=max(first.pressing_force_n, 6e3 * (now.time_s >= 20.0)))
        shown_s = now.time_s + 3600.0 * (now.time_s >= 30.0)
        book.see(replace(now, time_s=shown_s, wheelsets=(drags, second)), SOUND)
    (stop,) = book.brakes.applications
    assert stop.end_time_s == pytest.approx(19.9)


def test_a_clock_that_is_set_back_a_little_makes_no_other_braking() -> None:
    book, drive = new_book(), Drive()
    shown = [replace(now, time_s=now.time_s - 2.0 * (now.time_s >= 14.0)) for now in drive.estimates]
    (stop,) = (stop for now in shown for stop in book.see(now, SOUND))
    assert [own.energy_j for own in stop.wheelsets] == pytest.approx(drive.energy_j)


def test_a_clock_that_is_set_ends_an_application_and_makes_no_heat() -> None:
    book = new_book()
    keep(book, Drive(0.0, 15.0))
    before_c = book.brakes.units[0].disc_temperature_c
    (now, *_) = Drive(15.0, 15.1).estimates
    (stop,) = book.see(Estimate(**{f: getattr(now, f) for f in now.__struct_fields__} | {"time_s": -1e6}), SOUND)
    assert stop.end_time_s < 15.0
    assert book.brakes.units[0].disc_temperature_c <= before_c


def to_standstill(gradient: InputCondition | None) -> ApplicationRecord:
    """The drive's stop, from 10 m/s on; `gradient`: the condition of its signal, None where none is mapped."""
    inputs = SOUND if gradient is None else InputReports([report(Quantity.GRADIENT, 0, "TCU.rise", gradient)])
    slower = [replace(now, speed_mps=now.speed_mps - 20.0) for now in Drive().estimates]
    book = new_book()
    (stop,) = [stop for now in slower for stop in book.see(now, inputs)]
    return stop


@pytest.mark.parametrize(("gradient", "std"), [(None, 0.1), (InputCondition.LOST, 0.1), (InputCondition.GOOD, 0.02)])
def test_at_standstill_the_gradient_is_known_only_where_it_is_mapped(
    gradient: InputCondition | None, std: float
) -> None:
    """10 per mille, or 2 by its signal, beside the 1 m/s² of the brakes."""
    (own, _) = to_standstill(gradient).wheelsets
    assert own.friction_gradient_std == pytest.approx(std * FRICTION, rel=0.05)
    assert own.friction_std is not None
    assert own.friction_std**2 == pytest.approx(0.01**2 + (std * FRICTION) ** 2, rel=0.05)


def test_a_gradient_that_changed_meanwhile_is_doubt_about_friction() -> None:
    """0.2 m/s² of unknown beside the 1 m/s² of the brakes: a fifth."""
    (level,), (steep,) = keep(new_book(), Drive()), keep(new_book(), Drive(later_mps2=0.21))
    assert level.wheelsets[0].friction_std == pytest.approx(0.01)
    assert steep.wheelsets[0].friction_std == pytest.approx(0.2 * FRICTION, rel=0.05)


def test_while_wheelsets_slide_a_gradient_that_changed_is_less_of_a_doubt() -> None:
    """How a wheelset slows down shows its friction, whatever the line does; it also settles for two seconds more."""
    rolling, sliding = Drive(later_mps2=0.21), Drive(later_mps2=0.21)
    sliding.estimates = [replace(now, saturated=10.0 <= now.time_s < 20.0) for now in sliding.estimates]
    (rolled,), (slid,) = keep(new_book(), rolling), keep(new_book(), sliding)
    assert slid.wheelsets[0].friction == rolled.wheelsets[0].friction
    assert slid.wheelsets[0].friction_gradient_std == pytest.approx(0.2 * 0.2 * FRICTION, rel=0.05)


def test_what_the_estimates_of_a_gradient_are_unsure_of_is_not_taken_for_a_change_of_it() -> None:
    """Both are known to 0.02 m/s²; friction's own deviation has that already."""
    (within,), (beyond,) = keep(new_book(), Drive(later_mps2=0.035)), keep(new_book(), Drive(later_mps2=0.06))
    assert within.wheelsets[0].friction_gradient_std == 0.0
    assert beyond.wheelsets[0].friction_gradient_std == pytest.approx(
        (0.05**2 - 2 * 0.02**2) ** 0.5 * FRICTION, rel=0.05
    )


@pytest.mark.parametrize(("since_s", "std"), [(12.0, 0.01), (0.0, 0.04)], ids=["meanwhile", "before"])
def test_coasting_answers_for_the_line_only_since_this_application_began(since_s: float, std: float) -> None:
    """Friction was known to 0.01, and is in doubt to 0.04 for a line that changed: then, or already before."""
    drive, line_std = Drive(), (0.04**2 - 0.01**2) ** 0.5
    for k, now in enumerate(drive.estimates):
        if now.time_s >= since_s:
            doubted = tuple(replace(own, friction_std=0.04, line_friction_std=line_std) for own in now.wheelsets)
            drive.estimates[k] = replace(now, wheelsets=doubted)
    (stop,) = keep(new_book(), drive)
    assert stop.wheelsets[0].friction_std == pytest.approx(std)


@pytest.mark.parametrize(("clock_was_s", "set_to_s"), [(1000.0, 1000.0 + 3600.0), (1000.0, 1000.0 - 3600.0)])
def test_a_clock_that_is_set_is_no_time_in_which_discs_cool(clock_was_s: float, set_to_s: float) -> None:
    book = resumed_with_hot_discs(clock_was_s - 0.1)
    book.see(estimate(time_s=clock_was_s, speed_mps=20.0, wheelsets=(wheelset(), wheelset())), SOUND)
    now = estimate(time_s=clock_was_s + 0.1, speed_mps=20.0, wheelsets=(wheelset(), wheelset()))
    book.see(replace(now, clock_ahead_s=set_to_s - clock_was_s), SOUND)
    assert min(unit.disc_temperature_c for unit in book.brakes.units) > HOT_C - 5.0
    assert book.brakes.time_s == pytest.approx(set_to_s + 0.1)


def test_a_clock_that_was_wrong_from_the_start_does_not_hide_how_long_the_pause_was() -> None:
    """The gateway's clock begins at 1970, until the network sets it."""
    book, begun_s = resumed_with_hot_discs(1.7e9), 100.0
    for time_s in (begun_s, begun_s + 1.0):
        book.see(estimate(time_s=time_s, speed_mps=0.0, wheelsets=(wheelset(), wheelset())), SOUND)
    assert min(unit.disc_temperature_c for unit in book.brakes.units) > HOT_C - 5.0
    ahead_s = 1.7e9 + 12 * 3600.0 - begun_s
    book.see(
        estimate(time_s=begun_s + 2.0, clock_ahead_s=ahead_s, speed_mps=0.0, wheelsets=(wheelset(), wheelset())), SOUND
    )
    assert max(unit.disc_temperature_c for unit in book.brakes.units) < WEAR.ambient_c + 20.0


HOT_C = 450.0


def resumed_with_hot_discs(time_s: float) -> BrakeBook:
    book = BrakeBook(2, WEAR, 2000.0, CreepMeter(2000.0), 1)
    units = tuple(replace(unit, disc_temperature_c=HOT_C) for unit in book.brakes.units)
    book.resume(replace(book.brakes, time_s=time_s, units=units))
    return book
