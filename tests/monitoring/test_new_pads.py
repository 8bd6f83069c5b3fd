"""Friction that was told of pads is no word about those that a person has fitted since."""

import pytest
from msgspec.structs import replace

from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.monitoring.brake_units.application_record import ApplicationRecord, WheelsetRecord
from brake_monitor.monitoring.brake_units.brakes import Brakes, BrakeUnit
from brake_monitor.monitoring.brake_units.wear import PadUse, PadWear
from brake_monitor.monitoring.monitor import Monitor
from brake_monitor.monitoring.rule import Rule
from brake_monitor.monitoring.rules.friction_drift import FrictionDrift
from brake_monitor.monitoring.rules.friction_out_of_band import FrictionOutOfBand
from brake_monitor.monitoring.rules.uneven_braking import UnevenBraking
from brake_monitor.settings.alarm_settings import AlarmSettings
from brake_monitor.settings.wear_settings import WearSettings
from estimates import estimate, observation

NOMINAL, FULL_N = 0.35, 40e3
ALARMS, WEAR = AlarmSettings(), WearSettings()
EVERY_S = 1000.0  # a brake application


class Wagon:
    """Two wheelsets that brake again and again, and the pads of the first are replaced."""

    def __init__(self) -> None:
        rules: tuple[Rule, ...] = (
            FrictionDrift(ALARMS.friction_drift, NOMINAL, 2),
            FrictionOutOfBand(ALARMS.friction_out_of_band, NOMINAL, 2),
            UnevenBraking(ALARMS.uneven_braking, NOMINAL, [1.0] * 2, [0.247] * 2),
        )
        self.monitor = Monitor(rules)
        unit = BrakeUnit(PadWear.new(WEAR), 15.0)
        self.brakes = Brakes(0.0, (unit, unit), ())
        self.clock_ahead_s = 0.0

    def set_clock(self, by_s: float) -> None:
        assert self.brakes.time_s is not None
        self.brakes = replace(self.brakes, time_s=self.brakes.time_s + by_s)
        self.clock_ahead_s += by_s

    def replace_pads(self) -> list[Alarm]:
        assert self.brakes.time_s is not None
        time_s = self.brakes.time_s + EVERY_S / 2.0
        unit = BrakeUnit(PadWear.new(WEAR, time_s), 15.0)
        self.brakes = replace(self.brakes, time_s=time_s, units=(unit, self.brakes.units[1]))
        return self.seen()

    def brake(self, friction: float, std: float = 0.012, calibration: int | None = None) -> list[Alarm]:
        """One application; the first wheelset's pads rub so much, and the others' as they should."""
        assert self.brakes.time_s is not None
        start_s = self.brakes.time_s + EVERY_S
        wheelsets = (self._wheelset(friction, std), self._wheelset(NOMINAL, std))
        end_s = start_s + 12.0
        stop = ApplicationRecord(start_s, end_s, 25.0, 0.0, 220.0, 1.0, 0.1, 36e3, None, None, wheelsets, calibration)
        units = tuple(replace(unit, pads=unit.pads.used(PadUse(stops=1.0))) for unit in self.brakes.units)
        self.brakes = Brakes(end_s, units, (*self.brakes.applications, stop)[-20:])
        return self.seen()

    def seen(self) -> list[Alarm]:
        """What is given out within five seconds."""
        given: list[Alarm] = []
        assert self.brakes.time_s is not None
        for step in range(50):
            time_s = self.brakes.time_s - self.clock_ahead_s + 0.1 * step
            now = estimate(time_s=time_s, clock_ahead_s=self.clock_ahead_s)
            given += self.monitor.see(observation(now, brakes=self.brakes))
        return given

    @staticmethod
    def _wheelset(friction: float, std: float) -> WheelsetRecord:
        return WheelsetRecord(
            1.5e6, 4.5e6, friction, std, 1.4e6, FULL_N, None, 0.0, 0, 0.003, 60.0, friction_gradient_std=0.8 * std
        )


def test_new_pads_that_rub_otherwise_have_not_drifted() -> None:
    wagon = Wagon()
    told = [alarm for _ in range(10) for alarm in wagon.brake(0.31)]
    wagon.replace_pads()
    told += [alarm for _ in range(15) for alarm in wagon.brake(0.385)]
    assert [(alarm.kind, alarm.message) for alarm in told] == []


def test_pads_that_were_not_replaced_have() -> None:
    wagon = Wagon()
    told = [alarm for k in range(25) for alarm in wagon.brake(0.31 if k < 10 else 0.385)]
    assert {alarm.kind for alarm in told} == {"friction_drift"}


def test_pads_whose_force_is_told_otherwise_have_not_drifted() -> None:
    wagon = Wagon()
    told = [alarm for k in range(25) for alarm in wagon.brake(0.31 if k < 10 else 0.385, calibration=k // 10)]
    told += [alarm for _ in range(10) for alarm in wagon.brake(0.31, calibration=0)]
    assert [(alarm.kind, alarm.message) for alarm in told] == []


def test_what_memories_told_that_knew_no_calibration_counts() -> None:
    wagon = Wagon()
    told = [
        alarm for k in range(25) for alarm in wagon.brake(0.31 if k < 10 else 0.385, calibration=None if k < 10 else 1)
    ]
    assert {alarm.kind for alarm in told} == {"friction_drift"}


def test_what_was_told_of_the_old_pads_is_over_with_them() -> None:
    wagon = Wagon()
    told = [alarm for _ in range(3) for alarm in wagon.brake(0.22)]
    assert {(alarm.kind, alarm.wheelset) for alarm in told} == {("friction_out_of_band", 1)}
    assert {alarm.id for alarm in wagon.replace_pads() if alarm.cleared_time_s} == {told[0].id}


@pytest.mark.parametrize("std", [0.012, 0.05])
def test_new_pads_are_not_judged_by_what_the_old_ones_did(std: float) -> None:
    """Least of all where one application leaves doubt, and earlier ones would be averaged with it."""
    wagon = Wagon()
    for _ in range(10):
        wagon.brake(0.22)
    wagon.replace_pads()
    assert wagon.brake(0.32, std) == []


@pytest.mark.parametrize("by_s", [86400.0, -86400.0])
def test_a_clock_that_was_wrong_as_they_were_fitted_changes_nothing(by_s: float) -> None:
    """Applications of the old pads are not theirs, nor are their own the old ones', whatever times they have."""
    wagon = Wagon()
    for _ in range(10):
        wagon.brake(0.22)
    wagon.set_clock(-by_s)
    assert [alarm.cleared_time_s is not None for alarm in wagon.replace_pads()] == [True]
    wagon.set_clock(by_s)
    assert wagon.brake(0.32, 0.05) == []
    told = [alarm for _ in range(3) for alarm in wagon.brake(0.5)]
    assert {(alarm.kind, alarm.wheelset) for alarm in told} == {("friction_out_of_band", 1)}
