"""The rules on brake units, each with what looks like it and is not: what they see is made by hand."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from math import hypot, inf, sqrt
from random import Random
from statistics import fmean

import pytest

from brake_monitor.estimation.estimate import Status
from brake_monitor.monitoring.alarm import Severity
from brake_monitor.monitoring.brake_units.application_record import ApplicationRecord, WheelsetRecord
from brake_monitor.monitoring.brake_units.brakes import Brakes, BrakeUnit
from brake_monitor.monitoring.brake_units.wear import PadUse, PadWear
from brake_monitor.monitoring.creep_meter import CreepMeter
from brake_monitor.monitoring.inputs.wheel_state import WheelState
from brake_monitor.monitoring.misled import MisledBy
from brake_monitor.monitoring.monitor import Monitor
from brake_monitor.monitoring.observation import Observation
from brake_monitor.monitoring.reports import InputReport
from brake_monitor.monitoring.rule import FINE, UNKNOWN, Finding, Rule, Suspicion, Verdict
from brake_monitor.monitoring.rules.brake_not_applied import BrakeNotApplied
from brake_monitor.monitoring.rules.dragging_brake import DraggingBrake
from brake_monitor.monitoring.rules.friction_drift import FrictionDrift, trend
from brake_monitor.monitoring.rules.friction_out_of_band import FrictionOutOfBand
from brake_monitor.monitoring.rules.hidden_drag import HiddenDrag
from brake_monitor.monitoring.rules.hot_disc import HotDisc
from brake_monitor.monitoring.rules.pads import ThinPads
from brake_monitor.monitoring.rules.participation import EASING_S, Participation
from brake_monitor.monitoring.rules.told_apart import told_apart
from brake_monitor.monitoring.rules.uneven_braking import UnevenBraking
from brake_monitor.samples import InputCondition, Quantity
from brake_monitor.settings.alarm_settings import (
    BrakeNotAppliedRule,
    DraggingBrakeRule,
    FrictionDriftRule,
    FrictionOutOfBandRule,
    HotDiscRule,
    PadAtLimitRule,
    PadNearLimitRule,
    UnevenBrakingRule,
)
from brake_monitor.settings.wear_settings import WearSettings
from estimates import estimate, observation, report, wheelset

NOMINAL = 0.35
WEAR = WearSettings()
STIFFNESS = 35.0  # adhesion per creep
FULL_N, CONTACT_N = 40e3, 2000.0
RADIUS_M = 0.45


def wheelset_stop(friction: float | None = 0.34, std: float = 0.014, **changes: object) -> WheelsetRecord:
    values: dict[str, object] = {
        "energy_j": 1.5e6,
        "force_travel_nm": 4.5e6,
        "friction": friction,
        "friction_std": None if friction is None else std,
        "friction_energy_j": 0.0 if friction is None else 1.4e6,
        "pressing_force_n": FULL_N,
        "torque_nm": None if friction is None else friction * FULL_N * 0.247,
        "creep": None,
        "sliding_distance_m": 0.0,
        "wsp_actions": 0,
        "greatest_slip": 0.003,
        "peak_disc_temperature_c": 60.0,
    }
    return WheelsetRecord(**(values | changes))  # type: ignore[arg-type]


def stop(*wheelsets: WheelsetRecord, start_s: float = 100.0) -> ApplicationRecord:
    return ApplicationRecord(start_s, start_s + 12.0, 25.0, 10.0, 220.0, 1.0, 0.1, 36e3, None, None, wheelsets)


def after(*stops: ApplicationRecord) -> Observation:
    return observation(estimate(time_s=200.0), brakes=Brakes(200.0, Brakes.new(6, WEAR).units, stops))


def told(rule: Rule, *stops: ApplicationRecord) -> tuple[Verdict, ...]:
    return rule.judge(after(*stops))


def severities(verdicts: Iterable[Verdict]) -> list[Severity | None]:
    return [verdict.severity if isinstance(verdict, Finding) else None for verdict in verdicts]


def out_of_band(count: int = 2) -> FrictionOutOfBand:
    return FrictionOutOfBand(FrictionOutOfBandRule(), NOMINAL, count)


def uneven(count: int) -> UnevenBraking:
    return UnevenBraking(UnevenBrakingRule(), NOMINAL, [1.0] * count, [0.247] * count)


class TestFrictionOutOfBand:
    @pytest.mark.parametrize(
        ("friction", "severity"),
        [(0.34, None), (0.31, None), (0.26, Severity.WARNING), (0.44, Severity.WARNING), (0.2, Severity.ALARM)],
    )
    def test_of_the_wagon_with_one_wheelset(self, friction: float, severity: Severity | None) -> None:
        assert severities(told(out_of_band(1), stop(wheelset_stop(friction, std=0.005)))) == [severity]

    def test_not_while_the_interval_does_not_exclude_that_it_is_fine(self) -> None:
        assert severities(told(out_of_band(1), stop(wheelset_stop(0.26, std=0.03)))) == [None]
        assert severities(told(out_of_band(1), stop(wheelset_stop(0.26, std=0.01)))) == [Severity.WARNING]

    def test_of_friction_that_was_told_for_the_smaller_part_of_the_energy_nothing_is_said(self) -> None:
        """Wet discs: the pads rub less for a second or two, and are doubted while they recover."""
        wet = wheelset_stop(0.26, energy_j=4e6, friction_energy_j=0.5e6)
        assert told(out_of_band(), stop(wet, wet)) == (UNKNOWN, UNKNOWN)
        weak = wheelset_stop(0.26, energy_j=4e6, friction_energy_j=2.1e6)
        assert severities(told(out_of_band(), stop(weak, weak))) == [Severity.WARNING] * 2

    def test_of_friction_that_was_never_valid_nothing_is_said(self) -> None:
        assert told(out_of_band(), stop(wheelset_stop(None), wheelset_stop(None))) == (UNKNOWN, UNKNOWN)
        assert told(out_of_band()) == (UNKNOWN, UNKNOWN)

    def test_a_wheelset_of_which_nothing_is_known_leaves_the_others_verdicts(self) -> None:
        weak, unknown = wheelset_stop(0.2, std=0.005), wheelset_stop(None)
        *found, of_unknown = told(out_of_band(3), stop(weak, weak, unknown))
        assert severities(found) == [Severity.ALARM] * 2
        assert of_unknown is UNKNOWN
        (alone, _) = told(out_of_band(2), stop(weak, unknown))
        assert isinstance(alone, Finding)
        assert "the others" not in alone.message

    def test_of_a_wheelset_that_creep_alone_sets_apart_nothing_is_known(self) -> None:
        """It may be a curve: that is not believed, but neither is that it is fine."""
        creeps = [wheelset_stop(creep=share * 12e-4, creep_std=2e-5) for share in (0.7, 1.1, 1.1, 1.1)]
        assert told(out_of_band(4), stop(*creeps)) == (UNKNOWN, FINE, FINE, FINE)

    @staticmethod
    def to_standstill(*frictions: float, own_std: float = 0.012) -> list[ApplicationRecord]:
        """Stops that a gradient of 10 per mille beside brakes of 0.5 m/s² makes doubtful by a fifth each."""
        gradient_std = 0.2 * NOMINAL
        std = hypot(own_std, gradient_std)
        one = [wheelset_stop(friction, std=std, friction_gradient_std=gradient_std) for friction in frictions]
        return [stop(own, start_s=100.0 * k) for k, own in enumerate(one)]

    def test_stops_to_standstill_tell_together_what_each_alone_does_not(self) -> None:
        weak = 0.62 * NOMINAL
        assert severities(told(out_of_band(1), *self.to_standstill(weak))) == [None]
        (verdict,) = told(out_of_band(1), *self.to_standstill(*[weak] * 8))
        assert isinstance(verdict, Finding)
        assert verdict.severity is Severity.ALARM
        assert f"in the last {verdict.evidence['applications']:.0f} brake applications" in verdict.message
        assert verdict.evidence["stop_start_time_s"] == 700.0  # the last one's

    @pytest.mark.parametrize(("share", "verdict"), [(0.87, UNKNOWN), (0.89, FINE), (1.13, UNKNOWN), (1.11, FINE)])
    def test_it_is_fine_again_only_when_well_within_the_band(self, share: float, verdict: Verdict) -> None:
        assert told(out_of_band(1), stop(wheelset_stop(share * NOMINAL, std=0.001))) == (verdict,)

    @pytest.mark.parametrize(("others", "is_shared"), [(0.7, True), (0.86, False), (1.3, False)])
    def test_only_where_the_others_are_off_by_half_as_much_or_more_it_may_be_the_mass(
        self, others: float, is_shared: bool
    ) -> None:
        stops = stop(wheelset_stop(0.6 * NOMINAL), *[wheelset_stop(others * NOMINAL)] * 2)
        verdict, *_ = told(out_of_band(3), stops)
        assert isinstance(verdict, Finding)
        said = "in the last brake application, 40% below nominal (0.35)"
        assert f"{said}; so had the others" in verdict.message if is_shared else verdict.message.endswith(f"{said}.")

    def test_several_stops_count_by_how_well_each_is_known(self) -> None:
        """One is known twice as well as the other: it counts four times."""
        stops = [stop(wheelset_stop(0.20, std=0.035, friction_gradient_std=0.035), start_s=0.0)]
        stops += [stop(wheelset_stop(0.30, std=0.07, friction_gradient_std=0.07), start_s=100.0)]
        (verdict,) = told(out_of_band(1), *stops)
        assert isinstance(verdict, Finding)
        assert verdict.evidence["friction"] == pytest.approx((4 * 0.20 + 0.30) / 5)

    @pytest.mark.parametrize(("off_by_gradients", "is_told"), [(0.0, True), (0.2, False)])
    def test_stops_show_how_much_gradients_change_where_the_brake_is_put_on(
        self, off_by_gradients: float, is_told: bool
    ) -> None:
        """Four of 0.67 of nominal on average, each doubtful by a fifth: half of that was for what then did not happen.

        By the guess alone their mean is known to 0.0726 (95 %), 0.67 and this of 0.35 is 0.307 and within the band.
        """
        stops = self.to_standstill(*[NOMINAL * (0.67 + off_by_gradients * (-1) ** k) for k in range(4)])
        assert isinstance(told(out_of_band(1), *stops)[0], Finding) is is_told

    def test_one_stop_shows_nothing_of_how_they_change(self) -> None:
        assert severities(told(out_of_band(1), *self.to_standstill(0.5 * NOMINAL))) == [None]

    def test_gradients_that_differ_from_stop_to_stop_do_not(self) -> None:
        up_and_down = [NOMINAL * (1.0 + 0.2 * (-1) ** k) for k in range(20)]
        assert told(out_of_band(1), *self.to_standstill(*up_and_down)) == (FINE,)

    def test_what_is_wrong_with_all_stops_alike_stays_doubtful_however_many_there_are(self) -> None:
        """A force or mass that is known to 10 % does not become better known."""
        doubtful = self.to_standstill(*[0.75 * NOMINAL] * 20, own_std=0.1 * NOMINAL)
        assert severities(told(out_of_band(1), *doubtful)) == [None]

    def test_new_pads_that_one_stop_shows_end_it(self) -> None:
        before = self.to_standstill(*[0.62 * NOMINAL] * 8)
        assert told(out_of_band(1), *before, stop(wheelset_stop(0.97 * NOMINAL, std=0.014))) == (FINE,)

    def test_nor_do_pads_before_them_count_where_one_stop_leaves_doubt(self) -> None:
        """Nobody noted that new ones were fitted; those before were well known."""
        before = [stop(wheelset_stop(0.5 * NOMINAL, std=0.007), start_s=100.0 * k) for k in range(8)]
        doubtful = wheelset_stop(0.9 * NOMINAL, std=0.0175)
        assert not isinstance(told(out_of_band(1), *before, stop(doubtful, start_s=800.0))[0], Finding)

    def test_of_several_stops_the_one_that_is_known_best_counts_most(self) -> None:
        doubtful = stop(wheelset_stop(0.33, std=0.07, friction_gradient_std=0.07), start_s=200.0)
        (verdict,) = told(out_of_band(1), stop(wheelset_stop(0.22, std=0.005)), doubtful)
        assert isinstance(verdict, Finding)
        assert verdict.evidence["friction"] == pytest.approx(0.22, abs=0.002)

    def test_a_light_touch_of_the_brake_says_nothing(self) -> None:
        assert told(out_of_band(1), stop(wheelset_stop(0.1, friction_energy_j=20e3))) == (UNKNOWN,)

    def test_each_application_is_judged_as_it_ends(self) -> None:
        rule, sound, weak = out_of_band(1), stop(wheelset_stop(0.34, std=0.005)), stop(wheelset_stop(0.26, std=0.005))
        assert [severities(told(rule, *stops)) for stops in ((sound,), (sound, weak), (sound, weak, sound))] == [
            [None], [Severity.WARNING], [None],
        ]  # fmt: skip

    def test_what_all_share_may_be_the_mass(self) -> None:
        verdicts = told(out_of_band(), stop(wheelset_stop(0.25), wheelset_stop(0.25)))
        assert all(isinstance(verdict, Finding) and "mass" in verdict.message for verdict in verdicts)

    def test_creep_tells_whose_pads_they_are(self) -> None:
        """The estimator gives both 0.26; the second wheelset creeps less than half as much as the first."""
        both = stop(wheelset_stop(0.26, creep=13e-4), wheelset_stop(0.26, creep=6e-4))
        first, second = told(out_of_band(), both)
        assert not isinstance(first, Finding)
        assert isinstance(second, Finding)
        assert second.evidence["friction"] == pytest.approx(0.26 * 6.0 / 9.5)

    def test_creep_within_the_noise_of_coarse_wheel_speeds_tells_of_all_alike(self) -> None:
        """The same creeps, each known to a third of their mean; the message says what cannot be told."""
        both = [wheelset_stop(0.22, creep=creep, creep_std=3.2e-4) for creep in (13e-4, 6e-4)]
        verdicts = told(out_of_band(), stop(*both))
        assert [v.evidence["friction"] for v in verdicts if isinstance(v, Finding)] == [0.22, 0.22]
        assert all(isinstance(v, Finding) and "cannot be told" in v.message for v in verdicts)

    def test_coarse_wheel_speeds_that_agree_stop_after_stop_tell_whose_pads_they_are(self) -> None:
        """Four together are known twice as well as one: 7 of 19 parts apart, each to 13 of a hundred."""
        coarse = [wheelset_stop(0.26, creep=creep, creep_std=1.3e-4) for creep in (13e-4, 6e-4)]
        stops = [stop(*coarse, start_s=100.0 * k) for k in range(4)]
        assert severities(told(out_of_band(), *stops[:1])) == [Severity.WARNING, Severity.WARNING]
        assert severities(told(out_of_band(), *stops))[0] is None

    def test_creep_that_is_as_even_as_curves_leave_it_tells_of_all_alike(self) -> None:
        weak = stop(wheelset_stop(0.24, creep=7e-4), wheelset_stop(0.24, creep=6e-4))
        verdicts = told(out_of_band(), weak)
        assert [v.evidence["friction"] for v in verdicts if isinstance(v, Finding)] == [0.24, 0.24]
        assert not any(isinstance(v, Finding) and "cannot be told" in v.message for v in verdicts)  # it would show
        coarse = wheelset_stop(0.24, creep=6e-4, creep_std=3.2e-4)
        verdicts = told(out_of_band(), stop(wheelset_stop(0.24, creep=7e-4), coarse))
        assert all(isinstance(v, Finding) and "cannot be told" in v.message for v in verdicts)

    @pytest.mark.parametrize(
        ("others", "is_told"), [((1.12,), True), ((1.2,), False), ((0.9, 1.1), True), ((1.0, 1.2), False)]
    )
    def test_one_culprit_stands_beside_brakes_within_the_weather(self, others: Sequence[float], is_told: bool) -> None:
        """The wagon's friction alone leaves doubt; shared out, one brake has half of nominal."""
        each = (0.5, *others)
        friction = fmean(each) * NOMINAL
        creeps = [4.5e-4 * share * NOMINAL / friction for share in each]
        wheelsets = [wheelset_stop(friction, std=0.03, creep=creep, creep_std=2e-5) for creep in creeps]
        shared = told_apart([stop(*wheelsets)], NOMINAL)
        found = [wheelset.friction for wheelset in shared.wheelsets]
        expected = [share * NOMINAL for share in each] if is_told else [friction] * len(each)
        assert found == pytest.approx(expected)

    def test_a_wheelset_whose_torque_is_not_known_takes_nothing_from_the_others(self) -> None:
        """The last one slid all the time: of what the others gave, each is still told its share by earlier creep."""
        shares = (0.55, 1.15, 1.15, 1.15)
        crept = [wheelset_stop(0.28, creep=share * 12e-4, creep_std=3e-5) for share in shares]
        slid = wheelset_stop(None, pressing_force_n=None)
        shared = told_apart([stop(*crept), stop(*[wheelset_stop(0.25)] * 3, slid)], NOMINAL)
        found = [own.friction for own in shared.wheelsets]
        assert found == [*(pytest.approx(0.25 * share) for share in shares[:3]), None]

    def test_of_an_application_in_which_all_slid_creep_tells_nothing(self) -> None:
        crept = [wheelset_stop(0.28, creep=share * 12e-4, creep_std=3e-5) for share in (0.55, 1.15, 1.15, 1.15)]
        slid = stop(*[wheelset_stop(None, pressing_force_n=None)] * 4)
        assert told_apart([stop(*crept), slid], NOMINAL) == slid

    @pytest.mark.parametrize(("every_s", "is_told"), [(100.0, True), (60.0, True), (45.0, False)])
    def test_stops_in_one_curve_do_not_bear_each_other_out(self, every_s: float, is_told: bool) -> None:
        """A curve shows in all of them alike; in as many places there are no four that turn the same way."""
        apart = [wheelset_stop(0.34, creep=creep) for creep in (15e-4, 5e-4)]
        stops = [stop(*apart, start_s=every_s * k) for k in range(4)]
        assert (Severity.ALARM in severities(told(out_of_band(), *stops))) is is_told

    def test_a_braked_wheelset_that_runs_ahead_is_in_a_curve(self) -> None:
        """Friction is off, but of which brake these creeps cannot say; beside one that does nothing they can."""
        ahead, idle = (stop(wheelset_stop(0.24, creep=20e-4), wheelset_stop(0.24, creep=own)) for own in (-5e-4, 0.0))
        assert severities(told(out_of_band(), ahead)) == [Severity.ALARM, Severity.ALARM]
        assert severities(told(out_of_band(), idle))[1] is Severity.ALARM
        friction = [v.evidence["friction"] for v in told(out_of_band(), ahead) if isinstance(v, Finding)]
        assert friction == [0.24, 0.24]

    def test_creep_alone_in_one_stop_may_be_a_curve(self) -> None:
        in_a_curve = stop(wheelset_stop(0.33, creep=13e-4), wheelset_stop(0.33, creep=7e-4))
        assert severities(told(out_of_band(), in_a_curve)) == [None, None]


class TestFrictionDrift:
    @staticmethod
    def stops(frictions: Sequence[float], std: float, gradient_std: float) -> list[ApplicationRecord]:
        each = [wheelset_stop(friction, std, friction_gradient_std=gradient_std) for friction in frictions]
        return [stop(wheelset, start_s=100.0 * k) for k, wheelset in enumerate(each)]

    def verdict(self, frictions: Sequence[float], std: float = 0.014, gradient_std: float = 0.0) -> Verdict:
        rule = FrictionDrift(FrictionDriftRule(), NOMINAL, 1)
        return told(rule, *self.stops(frictions, std, gradient_std))[0]

    def test_a_steady_fall_is_found(self) -> None:
        verdict = self.verdict([0.36 - 0.004 * k for k in range(20)])
        assert isinstance(verdict, Finding)
        assert verdict.evidence["change"] == pytest.approx(-0.004 * 19 / NOMINAL)

    def test_a_walk_within_what_is_not_known_of_friction_is_none(self) -> None:
        """In a train friction hardly shows: what is taken for it walks, without scatter, as far as it is not known."""
        walk = [0.35 + 0.003 * k for k in range(20)]  # 16 % of nominal
        assert not isinstance(self.verdict(walk, std=0.03), Finding)
        assert isinstance(self.verdict(walk, std=0.01), Finding)

    def test_a_change_within_the_limit_is_none_however_certain_it_is(self) -> None:
        steadily = [0.36 - 0.002 * k for k in range(20)]  # by 11 % of nominal
        assert self.verdict(steadily, std=0.001) is UNKNOWN
        assert self.verdict([0.36 - 0.001 * k for k in range(20)], std=0.001) is FINE

    def test_it_tells_of_the_friction_as_it_is_now(self) -> None:
        verdict = self.verdict([0.30 + 0.004 * k for k in range(20)])
        assert isinstance(verdict, Finding)
        assert verdict.evidence["friction"] == pytest.approx(0.376)
        assert verdict.evidence["stops"] == 20.0
        assert "rose by 22% of nominal over the last 20 brake applications" in verdict.message

    def test_gradients_that_differ_from_stop_to_stop_are_in_the_scatter(self) -> None:
        walk = [0.35 + 0.003 * k for k in range(20)]
        assert isinstance(self.verdict(walk, std=hypot(0.01, 0.2), gradient_std=0.2), Finding)

    def test_scatter_and_a_few_odd_stops_are_none(self) -> None:
        steady = [0.34 + 0.01 * (-1) ** k for k in range(20)]
        assert self.verdict(steady) is FINE
        assert self.verdict([*steady[:-3], 0.20, 0.20, 0.20]) is FINE

    def test_few_stops_say_nothing(self) -> None:
        assert self.verdict([0.40, 0.35, 0.30, 0.25, 0.20]) is UNKNOWN

    def test_the_trend_of_a_line_is_exact_and_certain(self) -> None:
        assert trend([1.0, 1.5, 2.0, 2.5, 3.0]) == pytest.approx((2.0, 0.0))

    def test_the_trend_of_noise_is_as_uncertain_as_it_scatters(self) -> None:
        """Theil-Sen's line scatters about as that of least squares does, which is as certain as any."""
        random = Random(1)
        told = [trend([random.gauss(0.34, 0.02) for _ in range(20)]) for _ in range(300)]
        scatter = sqrt(fmean(change * change for change, _ in told))
        assert fmean(std for _, std in told) == pytest.approx(scatter, rel=0.15)


class TestUnevenBraking:
    @property
    def rule(self) -> UnevenBraking:
        return uneven(4)

    def test_less_pressing_force_is_the_brake_gears_fault(self) -> None:
        weak = wheelset_stop(pressing_force_n=0.6 * FULL_N, torque_nm=0.6 * 0.34 * FULL_N * 0.247)
        verdicts = told(self.rule, stop(wheelset_stop(), weak, wheelset_stop(), wheelset_stop()))
        assert severities(verdicts) == [None, Severity.WARNING, None, None]
        assert isinstance(verdicts[1], Finding)
        assert "wheelset 2 braked 40% less" in verdicts[1].message.lower()
        assert "brake gear or valve" in verdicts[1].message
        assert "of either" not in verdicts[1].message
        assert verdicts[1].misled_by is None  # friction is told apart by the force
        assert verdicts[1].evidence["pressing_force_apart"] == pytest.approx(-0.4)

    @pytest.mark.parametrize(("others_n", "verdict"), [(7.9e3, UNKNOWN), (8.1e3, Finding)])
    def test_of_a_light_braking_zeros_of_pressure_sensors_make_as_much(
        self, others_n: float, verdict: Verdict | type[Finding]
    ) -> None:
        """By 0.05 bar apart 5 kN read as 4; pads that are weak are told all the same."""
        light = wheelset_stop(pressing_force_n=others_n, torque_nm=0.34 * others_n * 0.247)
        weaker = wheelset_stop(pressing_force_n=0.75 * others_n, torque_nm=0.75 * 0.34 * others_n * 0.247)
        found = told(self.rule, stop(light, weaker, light, light))[1]
        assert found is verdict or type(found) is verdict
        pads = wheelset_stop(0.25, pressing_force_n=others_n, torque_nm=0.25 * others_n * 0.247)
        assert severities(told(self.rule, stop(light, pads, light, light))) == [None, Severity.WARNING, None, None]

    def test_where_the_others_friction_was_in_doubt_all_along_torque_tells_alone(self) -> None:
        wet = wheelset_stop(None, torque_nm=0.34 * FULL_N * 0.247)
        verdicts = told(self.rule, stop(wet, wheelset_stop(0.24), wet, wet))
        assert severities(verdicts) == [None, Severity.WARNING, None, None]

    def test_of_two_either_may_press_as_it_should_not(self) -> None:
        """One that was not released presses more than the other in the next application: that one is sound."""
        weak = wheelset_stop(pressing_force_n=0.4 * FULL_N, torque_nm=0.4 * 0.34 * FULL_N * 0.247)
        of_one, _ = told(uneven(2), stop(weak, wheelset_stop()))
        assert isinstance(of_one, Finding)
        assert of_one.message.endswith("(its pressing force differs as much: brake gear or valve of either).")

    def test_of_two_halves_either_may_press_as_it_should_not(self) -> None:
        weak = wheelset_stop(pressing_force_n=0.6 * FULL_N, torque_nm=0.6 * 0.34 * FULL_N * 0.247)
        first, second, *others = told(self.rule, stop(weak, weak, wheelset_stop(), wheelset_stop()))
        for one in (first, second):
            assert isinstance(one, Finding)
            assert one.message.endswith("(its pressing force differs as much: brake gear or valve of either half).")
        assert severities(others) == [None, None]

    def test_more_torque_with_less_pressing_force_is_not_the_brake_gears_fault(self) -> None:
        grabs = wheelset_stop(0.6, pressing_force_n=0.7 * FULL_N, torque_nm=1.4 * 0.34 * FULL_N * 0.247)
        verdict = told(self.rule, stop(wheelset_stop(), grabs, wheelset_stop(), wheelset_stop()))[1]
        assert isinstance(verdict, Finding)
        assert "pads" in verdict.message
        assert "drags" not in verdict.message
        assert verdict.misled_by is MisledBy.UNEVEN

    def test_a_force_that_explains_less_than_half_of_it_does_not_explain_it(self) -> None:
        weak = wheelset_stop(pressing_force_n=0.85 * FULL_N, torque_nm=0.6 * 0.34 * FULL_N * 0.247)
        verdict = told(self.rule, stop(weak, *[wheelset_stop()] * 3))[0]
        assert isinstance(verdict, Finding)
        assert verdict.misled_by is MisledBy.UNEVEN

    def test_the_wheelset_that_brakes_most_is_to_have_braked_enough(self) -> None:
        """A brake that hardly brakes is what is looked for."""
        weak = wheelset_stop(0.17, friction_energy_j=60e3)
        for others_j, severity in ((120e3, Severity.ALARM), (80e3, None)):
            verdicts = told(self.rule, stop(weak, *[wheelset_stop(friction_energy_j=others_j)] * 3))
            assert severities(verdicts) == [severity, None, None, None]

    def test_less_torque_at_the_same_cylinder_force_is_the_pads_or_the_brake_gear(self) -> None:
        verdicts = told(self.rule, stop(*(wheelset_stop(friction) for friction in (0.34, 0.34, 0.20, 0.34))))
        assert severities(verdicts) == [None, None, Severity.ALARM, None]
        assert isinstance(verdicts[2], Finding)
        assert "pads or brake gear, or it drags when released" in verdicts[2].message
        assert verdicts[2].misled_by is MisledBy.UNEVEN

    @pytest.mark.parametrize(("friction", "verdict"), [(0.34 * 0.83, UNKNOWN), (0.34 * 0.87, FINE)])
    def test_it_is_fine_again_only_when_well_within_the_limit(self, friction: float, verdict: Verdict) -> None:
        weak = stop(wheelset_stop(), wheelset_stop(friction), wheelset_stop(), wheelset_stop())
        assert told(self.rule, weak) == (FINE, verdict, FINE, FINE)

    def test_of_two_the_weaker_is_told_of(self) -> None:
        rule = uneven(2)
        strong, weak = wheelset_stop(0.34), wheelset_stop(0.25)
        assert severities(told(rule, stop(strong, weak))) == [None, Severity.WARNING]
        assert told(rule, stop(strong, weak))[0] is FINE
        assert severities(told(uneven(3), stop(wheelset_stop(0.45), strong, strong))) == [Severity.WARNING, None, None]

    @pytest.mark.parametrize("count", [4, 6])
    def test_of_two_halves_the_weaker_one_is_told_of(self, count: int) -> None:
        """One cylinder for a bogie lacks air: the other bogie's brakes are sound."""
        rule = uneven(count)
        weak = wheelset_stop(pressing_force_n=0.5 * FULL_N, torque_nm=0.5 * 0.34 * FULL_N * 0.247)
        verdicts = told(rule, stop(*[weak] * (count // 2), *[wheelset_stop()] * (count // 2)))
        assert severities(verdicts) == [Severity.ALARM] * (count // 2) + [None] * (count // 2)

    @pytest.mark.parametrize(
        ("share", "severity"),
        [(0.61, "warning"), (0.79, "warning"), (1.21, "warning"), (1.39, "warning"), (1.41, "alarm")],
    )
    def test_one_that_brakes_more_than_all_others_is_told_of_from_the_same_limits_on(
        self, share: float, severity: str
    ) -> None:
        verdicts = told(self.rule, stop(wheelset_stop(0.34 * share), *[wheelset_stop()] * 3))
        assert severities(verdicts) == [Severity(severity), None, None, None]

    @pytest.mark.parametrize(("share", "verdict"), [(1.17, UNKNOWN), (1.13, FINE)])
    def test_one_that_braked_more_is_fine_again_only_when_well_within_the_limit(
        self, share: float, verdict: Verdict
    ) -> None:
        strong = stop(wheelset_stop(), wheelset_stop(0.34 * share), wheelset_stop(), wheelset_stop())
        assert told(self.rule, strong) == (FINE, verdict, FINE, FINE)

    def test_the_usual_differences_are_fine(self) -> None:
        assert told(self.rule, stop(*(wheelset_stop(friction) for friction in (0.32, 0.36, 0.34, 0.33)))) == (FINE,) * 4

    def test_where_slide_protection_acted_all_the_time_nothing_is_said(self) -> None:
        slid = wheelset_stop(torque_nm=None, pressing_force_n=None)
        assert told(self.rule, stop(wheelset_stop(), slid, wheelset_stop(), wheelset_stop())) == (UNKNOWN,) * 4

    def test_a_glazed_pad_is_not_fine_again_where_creep_shows_it_and_is_not_believed(self) -> None:
        """Its 0.55 of a share is believed where the wagon's friction is off, its 0.71 of a light braking is not."""
        glazed, lightly, replaced = (
            stop(*(wheelset_stop(friction, creep=share * 12e-4, creep_std=3e-5) for share in (own, *[1.1] * 3)))
            for friction, own in ((0.28, 0.55), (0.32, 0.71), (0.34, 1.05))
        )
        verdicts = told(self.rule, glazed)
        assert severities(verdicts) == [Severity.ALARM, None, None, None]
        assert told(self.rule, glazed, lightly) == (UNKNOWN, FINE, FINE, FINE)
        assert told(self.rule, glazed, lightly, replaced) == (FINE,) * 4
        assert isinstance(told(out_of_band(4), glazed)[0], Finding)
        assert told(out_of_band(4), glazed, lightly)[0] is UNKNOWN
        assert told(out_of_band(4), glazed, lightly, replaced)[0] is FINE

    def test_a_brake_is_measured_by_its_size(self) -> None:
        """One brake has twice the discs, another one's are a fifth smaller."""
        rule = UnevenBraking(UnevenBrakingRule(), NOMINAL, [0.8, 0.8, 1.6, 0.8], [0.247, 0.247, 0.247, 0.198])
        sound, small = wheelset_stop(), wheelset_stop(torque_nm=0.34 * FULL_N * 0.198)
        twice = wheelset_stop(pressing_force_n=2.0 * FULL_N, torque_nm=2.0 * 0.34 * FULL_N * 0.247)
        assert told(rule, stop(sound, sound, twice, small)) == (FINE,) * 4
        verdicts = told(rule, stop(sound, sound, sound, small))
        assert severities(verdicts) == [None, None, Severity.ALARM, None]
        assert isinstance(verdicts[2], Finding)
        assert "wheelset 3 braked 50% less" in verdicts[2].message.lower()
        assert verdicts[2].evidence["pressing_force_apart"] == pytest.approx(-0.5)

    def test_friction_that_is_not_known_so_well_accuses_no_brake(self) -> None:
        """Four wheelsets that had locked: nothing tells which of them brakes how much of what all do."""
        frictions = ((0.20, 0.11), (0.21, 0.11), (0.40, 0.13), (0.39, 0.13))
        doubtful = stop(*(wheelset_stop(friction, std) for friction, std in frictions))
        assert told(self.rule, doubtful)[0] is UNKNOWN
        assert not any(severities(told(self.rule, doubtful)))
        assert not any(severities(told(self.rule, stop(*[wheelset_stop()] * 4, start_s=0.0), doubtful)))
        beside = stop(wheelset_stop(0.20, 0.01), *[wheelset_stop(0.34, 0.12)] * 3)  # nor are they, beside one that is
        assert told(self.rule, beside) == (UNKNOWN, FINE, FINE, FINE)
        sure = stop(*(wheelset_stop(friction, 0.014) for friction, _ in frictions))
        assert severities(told(self.rule, sure)) == [Severity.ALARM, Severity.ALARM, None, None]

    @pytest.mark.parametrize(("std", "severity"), [(0.048, Severity.WARNING), (0.054, None)])
    def test_friction_alone_tells_from_its_95_percent_interval_on(self, std: float, severity: Severity | None) -> None:
        """0.10 apart from the other's, which is known: 1.96 deviations of 0.051."""
        pair = stop(wheelset_stop(0.24, std), wheelset_stop(0.34, 0.0))
        assert severities(told(uneven(2), pair)) == [severity, None]

    def test_a_pressing_force_that_differs_or_creep_that_does_tells_without_friction(self) -> None:
        doubtful = wheelset_stop(std=0.12)
        weak = wheelset_stop(std=0.12, pressing_force_n=0.5 * FULL_N, torque_nm=0.5 * 0.34 * FULL_N * 0.247)
        assert severities(told(self.rule, stop(weak, *[doubtful] * 3))) == [Severity.ALARM, None, None, None]
        glazed = (wheelset_stop(0.27, 0.03, creep=share * 12e-4, creep_std=3e-5) for share in (0.3, *[1.23] * 3))
        assert severities(told(self.rule, stop(*glazed))) == [Severity.ALARM, None, None, None]

    def test_one_wheelset_has_nothing_to_be_compared_with(self) -> None:
        assert told(uneven(1), stop(wheelset_stop(0.1))) == (FINE,)


Forces = Callable[[float], Sequence[float]]
Inputs = Callable[[float], tuple[InputReport, ...]]


def play(
    rule: Rule,
    forces_n: Forces,
    torques_n: Forces | None = None,
    *,
    until_s: float = 60.0,
    friction: float | Sequence[float] = 0.34,
    friction_std: float = 0.01,
    speed_mps: float | Callable[[float], float] = 20.0,
    omega_noise: float = 1e-5,
    inputs: Inputs | tuple[InputReport, ...] = (),
    wsp: Callable[[float], Sequence[bool]] = lambda _: (),
    motor_n: float = 0.0,
) -> list[tuple[Verdict, ...]]:
    """Ten observations a second at this speed; wheelsets creep by what `torques_n` really presses."""
    verdicts, speed_at = [], speed_mps if callable(speed_mps) else lambda _: speed_mps
    for k in range(round(until_s * 10)):
        time_s = k / 10
        now_mps = speed_at(time_s)
        pressing, real = forces_n(time_s), (torques_n or forces_n)(time_s)
        active = wsp(time_s) or [False] * len(pressing)
        creep = [0.1 * force_n / FULL_N / STIFFNESS for force_n in real]
        frictions = [friction] * len(pressing) if isinstance(friction, float) else friction
        wheelsets = tuple(
            wheelset(
                omega_radps=now_mps / RADIUS_M * (1.0 - own_creep),
                omega_noise=omega_noise,
                slip=own_creep,
                friction=own_friction,
                friction_std=friction_std,
                friction_status=Status.VALID if force_n > CONTACT_N else Status.HELD,
                pressing_force_n=force_n,
                wsp_active=own_active,
                motor_force_n=motor_n,
            )
            for force_n, own_creep, own_active, own_friction in zip(pressing, creep, active, frictions, strict=True)
        )
        now = estimate(time_s=time_s, speed_mps=now_mps, saturated=any(active), wheelsets=wheelsets)
        verdicts.append(rule.judge(observation(now, inputs(time_s) if callable(inputs) else inputs)))
    return verdicts


def found(verdicts: list[tuple[Verdict, ...]]) -> list[float | None]:
    """When each wheelset was found first, s; None: never."""
    return [
        next((k / 10 for k, verdict in enumerate(of_one) if isinstance(verdict, Finding)), None)
        for of_one in zip(*verdicts, strict=True)
    ]


def braked(time_s: float) -> float:
    return FULL_N if 20.0 <= time_s < 40.0 else 0.0


def slowly(time_s: float) -> float:
    """The same with a release that takes 18 s."""
    return FULL_N * min(max((58.0 - time_s) / 18.0, 0.0), 1.0) if time_s >= 40.0 else braked(time_s)


def lost(quantity: Quantity, condition: InputCondition) -> tuple[InputReport, ...]:
    return (report(quantity, 0, "BCU.p_A", condition),)


class TestBrakeNotApplied:
    @staticmethod
    def rule(count: int = 2, contact_n: float = CONTACT_N) -> BrakeNotApplied:
        return BrakeNotApplied(BrakeNotAppliedRule(), contact_n, NOMINAL, count, CreepMeter(contact_n))

    def test_one_does_not_press_while_the_others_do(self) -> None:
        assert found(play(self.rule(), lambda t: (braked(t), 0.0))) == [None, 20.0]
        four = play(self.rule(4), lambda t: (braked(t), braked(t), 0.0, braked(t)))
        assert found(four) == [None, None, 20.0, None]
        assert set(four[150]) == {UNKNOWN}  # nobody brakes
        first, second, told, last = four[390]
        assert {first, second, last} == {FINE}
        assert isinstance(told, Finding)
        shown = [told.evidence[name] for name in ("creep", "others_creep")]
        assert shown == pytest.approx([0.0, 0.1 / STIFFNESS], abs=1e-5)

    def test_a_dead_sensor_of_a_brake_that_works_is_no_brake_fault(self) -> None:
        both = play(self.rule(), lambda t: (braked(t), 0.0), lambda t: (braked(t), braked(t)))
        after_a_second = both[215:]
        assert not any(isinstance(verdict, Finding) for verdicts in after_a_second for verdict in verdicts)

    @pytest.mark.parametrize(
        ("creep", "noise", "is_told"),
        [
            (2.6e-4, 1e-7, True),  # curves make as much
            (4.3e-4, 1e-7, False),
            (4.3e-4, 4.5e-5, True),  # half of it is 1.4 deviations
            (4.3e-4, 1e-5, False),  # ... and here 2.9
        ],
    )
    def test_a_brake_that_works_unseen_is_accused_where_creep_says_too_little(
        self, creep: float, noise: float, is_told: bool
    ) -> None:
        real_n = creep / 0.1 * STIFFNESS * FULL_N
        both = play(
            self.rule(), lambda t: (braked(t), 0.0), lambda t: (real_n * (braked(t) > 0.0),) * 2, omega_noise=noise
        )
        told = [verdict.message for _, verdict in both[215:] if isinstance(verdict, Finding)]
        assert bool(told) is is_told
        assert all("or its sensor says too little" in message for message in told)

    def test_where_the_wagon_retards_as_if_none_pressed_it_may_be_the_others_sensors(self) -> None:
        presses, does_not = wheelset(pressing_force_n=FULL_N), wheelset(pressing_force_n=0.0)
        seen, rule = observation(estimate(time_s=1.0, wheelsets=(presses, does_not))), self.rule()
        rule.judge(observation(estimate(time_s=0.0, wheelsets=(does_not, does_not))))
        assert isinstance(rule.judge(seen)[1], Finding)
        assert rule.judge(replace(seen, misled_by=frozenset([MisledBy.IDLE]))) == (UNKNOWN, UNKNOWN)

    def test_where_creep_tells_the_others_friction_does_not_count(self) -> None:
        """The other brake does it alone, lightly, with pads that bite as hard as two."""
        light = play(self.rule(), lambda t: (0.2025 * braked(t), 0.0), friction=2.0 * NOMINAL)
        assert isinstance(light[350][1], Finding)

    def test_of_its_own_friction_a_brake_that_does_not_press_tells_nothing(self) -> None:
        forces = (FULL_N, FULL_N, 0.0)
        silent = play(self.rule(3), lambda _: forces, until_s=5.0, friction=(NOMINAL, NOMINAL, 0.1 * NOMINAL))
        assert found(silent) == [None, None, 0.0]
        rough = play(self.rule(), lambda t: (braked(t), 0.0), omega_noise=1e-2, friction=(NOMINAL, 3.0 * NOMINAL))
        assert found(rough) == [None, 20.0]

    def test_at_a_crawl_nothing_is_said(self) -> None:
        crawls = play(self.rule(), lambda t: (braked(t), 0.0), speed_mps=1.0)
        assert {verdict for both in crawls for verdict in both} == {UNKNOWN}

    def test_nor_where_only_the_others_friction_tells(self) -> None:
        """Braking from the first moment on, no free rolling was seen; all of two brakes' work seems to be one's."""
        assert found(play(self.rule(), lambda _: (FULL_N, FULL_N, FULL_N, 0.0)[:2], until_s=5.0)) == [None, None]
        forces = (FULL_N, FULL_N, FULL_N, 0.0)
        assert found(play(self.rule(4), lambda _: forces, until_s=5.0, friction=NOMINAL * 4 / 3)) == [None] * 4
        assert found(play(self.rule(4), lambda _: forces, until_s=5.0, friction=NOMINAL)) == [None, None, None, 0.0]

    def test_the_others_friction_is_held_against_the_work_of_all_that_do_not_press(self) -> None:
        """Of two silent brakes of six, what is a seventh above nominal is not their unseen work."""
        forces = (0.0, 0.0, *[FULL_N] * 4)
        blocks = play(self.rule(6), lambda _: forces, until_s=5.0, friction=1.15 * NOMINAL)
        assert found(blocks) == [0.0, 0.0, *[None] * 4]
        assert found(play(self.rule(6), lambda _: forces, until_s=5.0, friction=NOMINAL * 6 / 4)) == [None] * 6
        unsure = play(self.rule(6), lambda _: forces, until_s=5.0, friction=1.15 * NOMINAL, friction_std=0.05)
        assert found(unsure) == [None] * 6

    def test_where_one_alone_presses_nothing_is_said_of_the_others(self) -> None:
        alone = play(self.rule(4), lambda t: (braked(t), 0.0, 0.0, 0.0))
        assert {verdict for verdicts in alone for verdict in verdicts} == {UNKNOWN}

    @pytest.mark.parametrize(("share", "is_told"), [(0.5, True), (0.35, False)])
    def test_others_that_hardly_brake_do_not_press_either(self, share: float, is_told: bool) -> None:
        """Pads that are wet give half of nominal; forces that give less are their sensors'."""
        silent = play(self.rule(4), lambda _: (FULL_N, FULL_N, FULL_N, 0.0), until_s=5.0, friction=share * NOMINAL)
        assert found(silent) == [None, None, None, 0.0 if is_told else None]

    def test_released_by_its_slide_protection_is_no_fault(self) -> None:
        acting = play(self.rule(), lambda t: (braked(t), 0.0), wsp=lambda t: (False, 19.0 < t < 41.0))
        assert found(acting) == [None, None]
        assert acting[300] == (UNKNOWN, UNKNOWN)

    def test_nor_is_one_that_slides_and_has_no_flag(self) -> None:
        """Its slide protection may have released it, and it takes some seconds to fill."""
        presses, rolls = wheelset(pressing_force_n=FULL_N), wheelset(pressing_force_n=0.0)
        rule, slides = self.rule(), wheelset(pressing_force_n=0.0, slip=0.1)
        moments = [(0.0, rolls, rolls), (1.0, presses, slides), (5.9, presses, rolls), (6.1, presses, rolls)]
        told = [rule.judge(observation(estimate(time_s=t, wheelsets=both)))[1] for t, *both in moments]
        assert told[:3] == [UNKNOWN] * 3
        assert isinstance(told[3], Finding)

    def test_of_two_the_one_that_was_released_is_not_at_fault(self) -> None:
        """The first brake stays: the second has done its part."""
        assert found(play(self.rule(), lambda t: (FULL_N if t >= 20.0 else 0.0, braked(t)))) == [None, None]

    def test_nor_are_two_of_four(self) -> None:
        """One bogie's brakes stay: the other bogie's have done their part."""
        stay = play(self.rule(4), lambda t: (FULL_N if t >= 20.0 else 0.0,) * 2 + (braked(t),) * 2)
        assert found(stay) == [None] * 4

    def test_a_bogie_that_never_came_is_found(self) -> None:
        assert found(play(self.rule(4), lambda t: (braked(t), braked(t), 0.0, 0.0))) == [None, None, 20.0, 20.0]

    def test_whether_two_of_four_came_is_not_known_of_an_application_whose_begin_was_not_seen(self) -> None:
        assert found(play(self.rule(4), lambda _: (FULL_N, FULL_N, 0.0, 0.0), friction=NOMINAL)) == [None] * 4

    def test_one_of_four_that_loses_its_air_in_mid_application_is_found(self) -> None:
        dies = play(self.rule(4), lambda t: (braked(t) if t < 30.0 else 0.0, braked(t), braked(t), braked(t)))
        assert found(dies) == [pytest.approx(30.5, abs=0.5), None, None, None]  # creep is a second's mean

    def test_others_below_the_force_of_contact_do_not_press(self) -> None:
        """Where pads are said to touch at a greater force than `others_force_n`, no brake presses between the two."""
        light_n = BrakeNotAppliedRule().others_force_n + 1e3
        light = play(self.rule(3, contact_n=light_n + 1e3), lambda t: (light_n * (20.0 <= t < 40.0),) * 2 + (0.0,))
        assert {verdict for verdicts in light for verdict in verdicts} == {UNKNOWN}

    @pytest.mark.parametrize("quantity", [Quantity.PRESSING_FORCE, Quantity.SPEED, Quantity.AXLE_SPEED])
    def test_a_lost_input_leaves_it_unknown(self, quantity: Quantity) -> None:
        verdicts = play(self.rule(), lambda t: (braked(t), 0.0), inputs=lost(quantity, InputCondition.LOST))
        assert {verdict for both in verdicts for verdict in both} == {UNKNOWN}

    @pytest.mark.parametrize(
        ("quantity", "condition", "force_n", "verdict"),
        [
            (Quantity.PRESSING_FORCE, InputCondition.CONTRADICTED, 0.0, FINE),
            (Quantity.PRESSING_FORCE, InputCondition.CONTRADICTED, FULL_N, UNKNOWN),  # its brake does not press
            (Quantity.PRESSING_FORCE, InputCondition.FROZEN, 0.0, UNKNOWN),
            (Quantity.PRESSING_FORCE, InputCondition.IMPOSSIBLE, 0.0, UNKNOWN),
            (Quantity.AXLE_SPEED, InputCondition.CONTRADICTED, 0.0, UNKNOWN),
        ],
    )
    def test_a_sensor_that_is_told_to_be_the_cause_clears_its_own_brake_and_no_other(
        self, quantity: Quantity, condition: InputCondition, force_n: float, verdict: Verdict
    ) -> None:
        inputs = lost(quantity, condition)
        verdicts = play(self.rule(), lambda t: (min(force_n, braked(t)), braked(t)), inputs=inputs)
        assert verdicts[300] == (verdict, UNKNOWN)

    def test_alone_a_wheelset_has_no_others(self) -> None:
        assert found(play(self.rule(1), lambda _: (0.0,))) == [None]


class TestDraggingBrake:
    @staticmethod
    def rule(count: int = 2) -> DraggingBrake:
        return DraggingBrake(DraggingBrakeRule(), NOMINAL, count)

    @staticmethod
    def residual(time_s: float) -> tuple[float, float]:
        return (braked(time_s) if time_s < 40.0 else 6e3, braked(time_s))

    def test_one_still_presses_after_the_release(self) -> None:
        assert found(play(self.rule(), self.residual)) == [40.0, None]

    def test_only_one_that_drags_unseen_misleads_the_estimator_after_a_restart(self) -> None:
        hidden = {
            "retarding_force_n": 3e3,
            "slip_shift": 3e-4,
            "slip_shift_std": 1e-5,
            "rolled_deceleration_mps2": 0.0,
            "rolled_apart": 0.0,
        }
        rule = self.rule()
        assert rule.resume(0, hidden) is MisledBy.DRAG
        assert set(play(rule, lambda _: (0.0, 0.0), until_s=8.0)) == {(UNKNOWN, FINE)}
        assert play(rule, lambda _: (0.0, 0.0), until_s=20.0)[-1] == (FINE, FINE)  # it rolled without
        stays = play(self.rule(), self.residual)[-1][0]
        assert isinstance(stays, Finding)
        assert self.rule().resume(0, stays.evidence) is None

    def test_in_a_train_one_that_turns_more_slowly_ever_since_is_doubted_then_found_and_not_forgotten(self) -> None:
        """The third of four drags with 10 kN of pad force; the wagon's speed, that of the train, does not tell."""
        released_s = 40.0 + 60.0

        def told(t: float) -> Sequence[float]:
            return (braked(t - 60.0),) * 4

        def real(t: float) -> Sequence[float]:
            return (*told(t)[:2], max(told(t)[2], 10e3 * (t >= released_s)), told(t)[3])

        rule = self.rule(4)
        verdicts = play(rule, told, real, until_s=200.0)
        of_it = [verdict for _, _, verdict, _ in verdicts]
        doubted_s = next(k / 10 for k, verdict in enumerate(of_it) if isinstance(verdict, Suspicion))
        found_s = found(verdicts)[2]
        assert found(verdicts) == [None, None, found_s, None]
        assert not any(isinstance(other, Suspicion) for of_four in verdicts for other in of_four[:2] + of_four[3:])
        assert found_s is not None
        assert released_s < doubted_s < released_s + 20.0 < found_s
        last = of_it[-1]
        assert isinstance(last, Finding)
        assert last.misled_by is MisledBy.DRAG
        assert "brake of wheelset 3 drags" in last.message
        assert "over 1.0 km of free rolling" in last.message
        assert last.evidence["pressing_force_n"] == 0.0
        retarding_n = last.evidence["retarding_force_n"]
        assert isinstance(retarding_n, float)
        assert retarding_n == pytest.approx(0.1 / 4.0 / STIFFNESS * 60.0 * 36e3 / 4.0 * 9.81, rel=0.1)
        assert last.message.endswith(f"as under about {retarding_n / 1e3:.1f} kN, at 72 km/h.")
        later = self.rule(4)  # the program ends, and goes on
        assert later.resume(2, last.evidence) is MisledBy.DRAG
        assert {of_four[2] for of_four in play(later, told, told, until_s=20.0)} == {UNKNOWN}
        assert play(later, told, told, until_s=160.0)[-1] == (FINE,) * 4

    def test_after_a_restart_one_that_drags_unseen_is_not_fine_before_the_wagon_has_rolled_without_it(self) -> None:
        numbers = (3e3, 3e-4, 1e-5, 0.0, 0.0)
        rule = self.rule()
        rule.resume(0, dict(zip(HiddenDrag._fields[1:], numbers, strict=True)))
        rolls = play(rule, lambda _: (0.0, 0.0), until_s=30.0)
        assert rolls[0] == (UNKNOWN, FINE)
        assert rolls[-1] == (FINE, FINE)

    @pytest.mark.parametrize("left_n", [6e3, 20e3])
    def test_two_of_four_still_press(self, left_n: float) -> None:
        stay = play(self.rule(4), lambda t: (braked(t) if t < 40.0 else left_n,) * 2 + (braked(t),) * 2)
        assert found(stay) == [40.0, 40.0, None, None]
        assert all(isinstance(own, Finding) and own.latches for own in stay[450][:2])

    @pytest.mark.parametrize("left_n", [6e3, 20e3])
    def test_they_have_eased_in_a_slow_release_as_well(self, left_n: float) -> None:
        stay = play(
            self.rule(4), lambda t: (max(slowly(t), left_n * (t >= 40.0)),) * 2 + (slowly(t),) * 2, until_s=65.0
        )
        others_released_s, over_s = 57.3, 58.0
        first_s, second_s, *sound = found(stay)
        assert first_s == second_s
        assert first_s is not None
        assert others_released_s <= first_s < over_s + EASING_S
        assert sound == [None, None]
        assert all(isinstance(own, Finding) and own.latches for own in stay[-1][:2])

    @pytest.mark.parametrize("step_n", [0.0, 1000.0])
    @pytest.mark.parametrize("empty_s", [45.0, 60.0])
    def test_one_that_is_still_vented_as_the_other_is_said_to_be_released_does_not_drag(
        self, empty_s: float, step_n: float
    ) -> None:
        """In position G a cylinder is down to a tenth within 45 to 60 s (EN 15355, UIC 540)."""

        def vented(time_s: float) -> float:
            force_n = FULL_N * 0.1 ** (max(time_s - 40.0, 0.0) / empty_s) if time_s >= 20.0 else 0.0
            return step_n * round(force_n / step_n) if step_n else force_n

        slow = play(self.rule(), lambda t: (vented(t), braked(t) if t < 35.0 else 0.0), until_s=100.0)
        drags = "".join("F" if isinstance(own, Finding) else "-" for own, _ in slow)
        longest_s = max(len(spell) for spell in drags.split("-")) / 10
        assert longest_s < DraggingBrakeRule().debounce_s
        assert {own for own, _ in slow if not isinstance(own, Finding)} == {FINE, UNKNOWN}

    def test_of_two_that_came_on_one_after_the_other_the_first_still_presses(self) -> None:
        late = play(self.rule(), lambda t: (self.residual(t)[0], braked(t) if t >= 21.0 else 0.0))
        assert found(late) == [40.0, None]
        assert isinstance(late[-1][0], Finding)
        assert late[-1][0].message.startswith(
            "The brake of wheelset 1 still presses with 6.0 kN while the others are released, at 72 km/h."
        )

    @pytest.mark.parametrize("later_n", [6e3, 12e3])
    def test_one_that_presses_harder_again_is_not_sure_to_drag(self, later_n: float) -> None:
        """The driver had eased all, and brakes on: it is the other one that has lost its air meanwhile."""

        def own(time_s: float) -> float:
            return braked(time_s) if time_s < 30.0 else 6e3 if time_s < 45.0 else later_n

        both = play(self.rule(), lambda t: (own(t), own(t) if t < 40.0 else 0.0), until_s=60.0)
        (last, _) = both[-1]
        assert isinstance(last, Finding)
        assert last.latches is (later_n == 6e3)
        assert ("Or the wagon is braking" in last.message) is (later_n != 6e3)

    def test_the_one_of_the_others_that_presses_most_is_told(self) -> None:
        stay = play(self.rule(3), lambda t: tuple(max(braked(t), left_n * (t >= 40.0)) for left_n in (6e3, 900.0, 0.0)))
        assert isinstance(stay[-1][0], Finding)
        assert stay[-1][0].evidence["others_pressing_force_n"] == 900.0

    def test_one_between_released_and_pressing_is_neither(self) -> None:
        """A hysteresis: 1.8 kN."""
        between = play(self.rule(), lambda t: (max(braked(t), 1.8e3 * (t >= 40.0)), braked(t)))
        assert set(between[400:]) == {(UNKNOWN, FINE)}

    def test_neither_at_a_crawl_nor_while_a_wheelset_slides_anything_is_said(self) -> None:
        assert found(play(self.rule(), self.residual, speed_mps=1.0)) == [None, None]
        assert found(play(self.rule(), self.residual, wsp=lambda _: (False, True))) == [None, None]

    def test_nor_while_motors_brake(self) -> None:
        assert set(play(self.rule(), self.residual, motor_n=9e3)) == {(UNKNOWN, UNKNOWN)}

    def test_many_released_ones_are_listed(self) -> None:
        stay = play(self.rule(6), lambda t: (max(braked(t), 6e3 * (t >= 40.0)),) * 2 + (braked(t),) * 4, until_s=52.0)
        assert isinstance(stay[-1][0], Finding)
        assert "those of wheelsets 3, 4, 5 and 6 are released" in stay[-1][0].message

    @pytest.mark.parametrize("count", [2, 4])
    def test_half_that_stay_as_they_were_may_brake_as_asked_while_the_others_lost_their_air(self, count: int) -> None:
        """Both are said, and nobody need acknowledge it once they, too, come off."""
        half = count // 2

        def forces(time_s: float) -> Sequence[float]:
            return (FULL_N if 20.0 <= time_s < 50.0 else 0.0,) * half + (braked(time_s),) * half

        *_, last, released = (play(self.rule(count), forces, until_s=t)[-1] for t in (49.0, 55.0))
        for own in last[:half]:
            assert isinstance(own, Finding)
            assert "lost" in own.message
            assert not own.latches
        assert released == (FINE,) * count

    @pytest.mark.parametrize("count", [3, 4])
    def test_all_but_one_that_press_are_a_brake_application(self, count: int) -> None:
        dies = play(self.rule(count), lambda t: (braked(t) if t < 30.0 else 0.0, *[braked(t)] * (count - 1)))
        assert found(dies) == [None] * count

    def test_one_stays_though_another_never_came(self) -> None:
        """Two have braked and been released; the air in one of them is not quite gone."""
        stays = play(self.rule(4), lambda t: (self.residual(t)[0], braked(t), max(braked(t), 1e3 * (t >= 40.0)), 0.0))
        assert found(stays) == [40.0, None, None, None]
        (told, *_) = stays[-1]
        assert isinstance(told, Finding)
        assert told.evidence["others_pressing_force_n"] == 1e3

    def test_found_for_as_long_as_it_lasts(self) -> None:
        verdicts = play(self.rule(), lambda t: self.residual(t) if t < 50.0 else (0.0, 0.0))
        eased = 400 + round(20.0 * EASING_S)  # it is known to stay
        assert all(isinstance(own, Finding) for own, _ in verdicts[eased:500])
        assert all(own is FINE for own, _ in verdicts[500:])
        assert all(other is FINE for _, other in verdicts[400:])

    def test_one_that_lets_its_wheelset_stand_is_not_fine_before_the_wagon_has_stood(self) -> None:
        rule = self.rule(3)
        rolls, stands = WheelState.ROLLING, WheelState.BLOCKED

        def judged(speed_mps: float, *wheels: WheelState, force_n: float = 0.0) -> tuple[Verdict, ...]:
            now = estimate(speed_mps=speed_mps, saturated=False, wheelsets=(wheelset(pressing_force_n=force_n),) * 3)
            return rule.judge(observation(now, wheels=wheels))

        found, *others = judged(20.0, stands, rolls, rolls)
        assert isinstance(found, Finding)
        assert "brake of wheelset 1 does not let it turn" in found.message
        assert found.misled_by is MisledBy.DRAG
        assert others == [UNKNOWN, UNKNOWN]  # while one stands nothing can be said of others
        assert judged(20.0, stands, rolls, rolls, force_n=FULL_N) == (UNKNOWN,) * 3  # nor of it while brakes are on
        assert judged(20.0, rolls, rolls, rolls) == (UNKNOWN, FINE, FINE)
        rule = self.rule(3)  # the program ends, and goes on
        assert rule.resume(0, found.evidence) is MisledBy.DRAG
        assert judged(20.0, rolls, rolls, rolls) == (UNKNOWN, FINE, FINE)
        assert judged(0.2, rolls, rolls, rolls) == (UNKNOWN, UNKNOWN, UNKNOWN)
        assert judged(20.0, rolls, rolls, rolls) == (FINE, FINE, FINE)

    def test_braking_with_the_other_isolated_is_no_drag(self) -> None:
        assert found(play(self.rule(), lambda t: (braked(t), 0.0))) == [None, None]

    def test_pressing_alone_for_minutes_is(self) -> None:
        (first, second) = found(play(self.rule(), lambda t: (6e3 if t >= 5.0 else 0.0, 0.0), until_s=150.0))
        assert first == pytest.approx(125.0, abs=0.2)
        assert second is None

    @pytest.mark.parametrize("others_braked", [True, False])
    def test_where_no_other_ever_pressed_they_may_be_what_failed(self, others_braked: bool) -> None:
        """Three that never came leave the fourth alone in a long braking, as a drag from the departure on does."""

        def forces(time_s: float) -> Sequence[float]:
            return (6e3 if time_s >= 5.0 else 0.0,) + (braked(time_s) if others_braked else 0.0,) * 3

        drags, *_ = play(self.rule(4), forces, until_s=150.0)[-1]
        assert isinstance(drags, Finding)
        assert ("Or the wagon is braking, and the others are isolated" in drags.message) is not others_braked
        assert drags.latches

    def test_a_force_that_does_not_retard_is_not_there(self) -> None:
        weak = play(self.rule(), self.residual, friction=0.3 * NOMINAL)
        assert found(weak) == [None, None]
        assert weak[-1] == (UNKNOWN, FINE)
        assert found(play(self.rule(), self.residual, friction=0.5 * NOMINAL)) == [40.0, None]  # wet pads do so

    def test_all_brakes_together_are_a_brake_application(self) -> None:
        assert set(play(self.rule(), lambda _: (6e3, 6e3), until_s=300.0)) == {(UNKNOWN, UNKNOWN)}

    def test_all_that_press_while_the_train_pulls_the_wagon_have_not_been_released(self) -> None:
        """From 5 to 10 m/s within 50 s; two of three cylinders kept their air."""
        verdicts = play(self.rule(3), lambda _: (11e3, 11e3, 0.0), speed_mps=lambda t: 5.0 + 0.1 * t, until_s=70.0)
        assert found(verdicts) == [pytest.approx(50.0, abs=0.2), pytest.approx(50.0, abs=0.2), None]
        stays = verdicts[-1][0]
        assert isinstance(stays, Finding)
        assert stays.message == (
            "The brake of wheelset 1 still presses with 11.0 kN, as most do, though the wagon has gained speed from "
            "18 to 43 km/h: it has not been released, or does not hold the wagon on a descent."
        )
        assert self.rule(3).resume(0, stays.evidence) is None

    @pytest.mark.parametrize(
        ("force_n", "gained_mps", "pause_s", "is_found"),
        [
            (11e3, 5.5, 1e9, True),
            (11e3, 4.5, 1e9, False),  # brakes at a train's end are not released yet
            (5.9e3, 10.0, 1e9, False),  # a train that is driven keeps its discs free of snow
            (6.1e3, 10.0, 1e9, True),  # three times the force of a brake that should be released
            (11e3, 6.0, 30.0, False),  # released meanwhile
        ],
    )
    def test_brakes_that_hardly_press_and_small_gains_are_of_no_account(
        self, force_n: float, gained_mps: float, pause_s: float, is_found: bool
    ) -> None:
        forces: Forces = lambda t: (0.0 if pause_s <= t < pause_s + 1.0 else force_n,) * 2  # noqa: E731
        verdicts = play(self.rule(), forces, speed_mps=lambda t: 10.0 + gained_mps * t / 60.0)
        assert (found(verdicts) != [None, None]) is is_found

    def test_what_the_brakes_did_while_their_forces_were_not_known_does_not_count(self) -> None:
        """They may have been released, and put on anew at the speed that the train has gained."""
        rule, lost_force = self.rule(), lost(Quantity.PRESSING_FORCE, InputCondition.LOST)
        for speed_mps, inputs in ((5.0, ()), (5.0, lost_force), (20.0, ())):
            verdicts = play(rule, lambda _: (11e3, 11e3), speed_mps=speed_mps, inputs=inputs, until_s=20.0)
        assert found(verdicts) == [None, None]

    def test_a_lost_input_leaves_it_unknown(self) -> None:
        verdicts = play(self.rule(), self.residual, inputs=lost(Quantity.PRESSING_FORCE, InputCondition.LOST))
        assert {verdict for both in verdicts for verdict in both} == {UNKNOWN}


def with_units(*units: BrakeUnit) -> Observation:
    return observation(estimate(), brakes=Brakes(1.0, units, ()))


class TestHotDisc:
    def setup_method(self) -> None:
        self.rule = HotDisc(HotDiscRule(), 2)

    def judge(self, *temperatures_c: float) -> tuple[Verdict, ...]:
        return self.rule.judge(with_units(*(BrakeUnit(PadWear.new(WEAR), t) for t in temperatures_c)))

    def test_by_its_thresholds(self) -> None:
        assert severities(self.judge(399.0, 401.0)) == [None, Severity.WARNING]
        assert severities(self.judge(501.0, 60.0)) == [Severity.ALARM, None]

    def test_it_names_the_limit_of_its_severity(self) -> None:
        """400 °C warn, 500 °C alarm."""
        units = [BrakeUnit(PadWear.new(WEAR), temperature_c) for temperature_c in (450.0, 520.0)]
        warm, hot = HotDisc(HotDiscRule(), 2).judge(with_units(*units))
        assert isinstance(warm, Finding)
        assert "about 450 °C (limit 400 °C)" in warm.message
        assert isinstance(hot, Finding)
        assert "about 520 °C (limit 500 °C)" in hot.message

    def test_while_they_cool_it_says_how_hot_they_were(self) -> None:
        """The last word of an alarm that lasts until they are well below its limit."""
        self.judge(20.0, 740.0)
        _, cooling = self.judge(20.0, 502.0)
        assert isinstance(cooling, Finding)
        assert "up to about 740 °C (limit 500 °C)" in cooling.message

    def test_it_is_fine_only_when_well_below(self) -> None:
        assert self.judge(390.0, 340.0) == (UNKNOWN, FINE)

    def test_each_alarm_ends_with_its_own_peak(self) -> None:
        """The third heat is too short for one."""
        monitor = Monitor((HotDisc(HotDiscRule(debounce_s=1.0, clear_s=0.0), 1),))
        ended = []
        temperatures_c = (20.0, 480.0, 520.0, 390.0, 410.0, 20.0, 410.0, 405.0, 20.0, 440.0, 20.0, 420.0, 415.0, 20.0)
        for k, temperature_c in enumerate(temperatures_c):
            brakes = Brakes(float(k), (BrakeUnit(PadWear.new(WEAR), temperature_c),), ())
            changed = monitor.see(observation(estimate(time_s=float(k), wheelsets=(wheelset(),)), brakes=brakes))
            ended += [alarm for alarm in changed if alarm.cleared_time_s is not None]
        assert [alarm.evidence["peak_disc_temperature_c"] for alarm in ended] == [520.0, 410.0, 420.0]

    def test_the_peak_outlives_a_restart(self) -> None:
        """The rule that is new since knows of it by the alarm that it goes on with."""
        self.judge(20.0, 470.0)
        (_, hot) = self.judge(20.0, 430.0)
        assert isinstance(hot, Finding)
        self.rule = HotDisc(HotDiscRule(), 2)
        self.rule.resume(1, hot.evidence)
        (_, still_hot) = self.judge(20.0, 420.0)
        assert isinstance(still_hot, Finding)
        assert still_hot.evidence["peak_disc_temperature_c"] == 470.0


class TestPads:
    near, at = ThinPads(PadNearLimitRule(), WEAR, 1), ThinPads(PadAtLimitRule(), WEAR, 1)

    @pytest.mark.parametrize(
        ("thickness_mm", "near", "at"),
        [(35.0, None, None), (8.1, None, None), (7.9, Severity.WARNING, None), (4.9, Severity.WARNING, Severity.ALARM)],
    )
    def test_by_thickness(self, thickness_mm: float, near: Severity | None, at: Severity | None) -> None:
        pads = PadWear.new(WEAR).gauged(WEAR, 1.0, thickness_mm)
        seen = with_units(BrakeUnit(pads, 20.0))
        assert severities(self.near.judge(seen)) == [near]
        assert severities(self.at.judge(seen)) == [at]

    def test_what_is_little_above_the_limit_neither_raises_an_alarm_nor_clears_one(self) -> None:
        """The expected thickness moves to and fro with friction."""
        pads = PadWear.new(WEAR).gauged(WEAR, 1.0, WEAR.pad_limit_mm + 0.5 * PadAtLimitRule().clear_margin_mm)
        assert self.at.judge(with_units(BrakeUnit(pads, 20.0))) == (UNKNOWN,)

    def test_says_its_interval_and_archards_view(self) -> None:
        pads = PadWear.new(WEAR).used(PadUse(energy_j=25e9, force_travel_nm=25e9 / 0.35, stops=100.0, distance_m=1e6))
        (verdict,) = self.at.judge(with_units(BrakeUnit(pads, 20.0)))
        assert isinstance(verdict, Finding)
        assert verdict.message.startswith("The pads of wheelset 1 are at their limit of 5 mm")
        evidence = verdict.evidence
        assert evidence["thickness_low_mm"] < evidence["thickness_mm"] < evidence["thickness_high_mm"]  # type: ignore[operator]
        assert evidence["thickness_by_archard_mm"] == pytest.approx(evidence["thickness_mm"], abs=0.01)

    def test_new_pads_make_it_fine_again(self) -> None:
        worn = PadWear.new(WEAR).gauged(WEAR, 1.0, 4.0)
        assert self.at.judge(with_units(BrakeUnit(worn.renewed(WEAR, 2.0), 20.0))) == (FINE,)


@pytest.mark.parametrize(
    ("forces_n", "is_easing"),
    [
        ([20e3], False),
        ([20e3, 19e3, 18e3], False),  # so few tell nothing
        ([9e3, 11e3] * 20, False),
        ([20e3 * (1.0 - 0.015 * k / 10) for k in range(40)], False),  # 3 % within 2 s
        ([20e3 * (1.0 - 0.035 * k / 10) for k in range(40)], True),
        ([*[20e3] * 20, *[10e3] * 40], False),
    ],
)
def test_a_brake_is_vented_while_it_loses_a_twentieth_in_two_seconds(forces_n: list[float], is_easing: bool) -> None:
    participation = Participation(2000.0, 2)
    for tenth, force_n in enumerate(forces_n):
        participation.see(tenth / 10, (0.0, force_n))
    assert participation.is_easing(1) is is_easing


def test_who_eased_in_one_release_has_not_eased_in_the_next() -> None:
    """An ordinary release; then the second brake does not come, and the first presses on."""
    participation = Participation(2000.0, 2)
    for tenth in range(1000):
        released = tenth < 100 or tenth >= 400
        force_n = 0.0 if released and not 370 <= tenth < 400 else 20e3
        forces_n = (20e3, 0.0) if tenth >= 500 else (force_n, force_n * (0.5 if 370 <= tenth < 400 else 1.0))
        participation.see(tenth / 10, forces_n)
    assert participation.eased == [False, False]


def test_a_brake_that_is_eased_to_just_below_the_force_of_contact_is_not_released() -> None:
    participation = Participation(2000.0, 2)
    for tenth in range(600):
        force_n = 0.0 if tenth < 100 else 1.8e3 if 300 <= tenth < 320 else 20e3
        participation.see(tenth / 10, (force_n, force_n))
        assert participation.begun_s == (inf if tenth < 100 else 10.0)
    participation.see(60.0, (1.5e3, 1.5e3))
    assert participation.begun_s == inf


@pytest.mark.parametrize(
    ("quantity", "found_s"), [(Quantity.SPEED, 50.0), (Quantity.AXLE_SPEED, 50.0), (Quantity.PRESSING_FORCE, 170.1)]
)
def test_who_was_released_while_an_input_was_lost_is_not_the_one_that_does_not_press(
    quantity: Quantity, found_s: float
) -> None:
    """All press and are released in a tunnel, but for the second brake, which drags.

    Where no force was told it may as well press by right, and the first one be isolated: for as long as that may be.
    """

    def forces_n(time_s: float) -> Sequence[float]:
        return braked(time_s), max(braked(time_s), 20e3 * (time_s >= 40.0))

    def inputs(time_s: float) -> tuple[InputReport, ...]:
        return lost(quantity, InputCondition.LOST if 15.0 <= time_s < 50.0 else InputCondition.GOOD)

    drags = play(TestDraggingBrake.rule(), forces_n, inputs=inputs, until_s=200.0)
    assert found(drags) == [None, found_s]
    silent = play(TestBrakeNotApplied.rule(), forces_n, inputs=inputs, until_s=200.0)
    assert found(silent) == [None, None]
