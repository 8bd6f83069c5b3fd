"""Every rule, in the order in which they judge."""

from brake_monitor.estimation.model.tuning import resolve
from brake_monitor.monitoring.creep_meter import CreepMeter
from brake_monitor.monitoring.rule import AnyRule
from brake_monitor.monitoring.rules.brake_not_applied import BrakeNotApplied
from brake_monitor.monitoring.rules.buses import BusFault, BusSilent
from brake_monitor.monitoring.rules.dragging_brake import DraggingBrake
from brake_monitor.monitoring.rules.friction_drift import FrictionDrift
from brake_monitor.monitoring.rules.friction_out_of_band import FrictionOutOfBand
from brake_monitor.monitoring.rules.hot_disc import HotDisc
from brake_monitor.monitoring.rules.inputs import InputImplausible, InputLost
from brake_monitor.monitoring.rules.low_adhesion import LowAdhesion
from brake_monitor.monitoring.rules.memory_failing import MemoryFailing
from brake_monitor.monitoring.rules.pads import ThinPads
from brake_monitor.monitoring.rules.slide import Slide
from brake_monitor.monitoring.rules.uneven_braking import UnevenBraking
from brake_monitor.monitoring.rules.wheelset_not_rotating import WheelsetNotRotating
from brake_monitor.settings.alarm_settings import AlarmSettings
from brake_monitor.settings.config import Settings


def all_rules(settings: Settings, creep: CreepMeter) -> tuple[AnyRule, ...]:
    """All of them, for the wagon of these settings; `creep` is shared with others that ask how far it creeps."""
    return (*wagon_rules(settings.alarms, settings.vehicle.wheelset_count), *brake_rules(settings, creep))


def wagon_rules(alarms: AlarmSettings, wheelset_count: int) -> tuple[AnyRule, ...]:
    """Those on wheels and rail, and on what the monitor itself needs."""
    return (
        WheelsetNotRotating(alarms.wheelset_not_rotating, wheelset_count),
        LowAdhesion(alarms.low_adhesion, wheelset_count),
        Slide(alarms.slide, wheelset_count),
        InputLost(alarms.input_lost, wheelset_count),
        InputImplausible(alarms.input_implausible, wheelset_count),
        BusSilent(alarms.bus_silent),
        BusFault(alarms.bus_fault),
        MemoryFailing(alarms.memory_failing),
    )


def brake_rules(settings: Settings, creep: CreepMeter) -> tuple[AnyRule, ...]:
    """Those on the brake units themselves."""
    alarms, wear, count = settings.alarms, settings.wear, settings.vehicle.wheelset_count
    contact_force_n, nominal = settings.estimator.contact_force_n, settings.estimator.friction_nominal
    alike_std = None if settings.estimator.preset == "train" else resolve(settings.estimator).friction_own_std
    return (
        DraggingBrake(alarms.dragging_brake, nominal, count),
        BrakeNotApplied(alarms.brake_not_applied, contact_force_n, nominal, count, creep),
        UnevenBraking(alarms.uneven_braking, nominal, settings.brake_forces, settings.vehicle.brake_radius_m),
        FrictionOutOfBand(alarms.friction_out_of_band, nominal, count, alike_std),
        FrictionDrift(alarms.friction_drift, nominal, count),
        HotDisc(alarms.hot_disc, count),
        ThinPads(alarms.pad_near_limit, wear, count),
        ThinPads(alarms.pad_at_limit, wear, count),
    )
