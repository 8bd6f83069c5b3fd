"""An estimator's core before its first sample, from vehicle, settings and channels."""

from collections.abc import Sequence
from math import hypot, nan

from brake_monitor.estimation.core.core import ELSE, TELLS, Core
from brake_monitor.estimation.filter.brake_filter import BrakeFilter
from brake_monitor.estimation.kalman.foretold import Foretold
from brake_monitor.estimation.model.tuning import Tuning
from brake_monitor.estimation.moment import ChannelState, Readings, WagonMoment, WheelsetMoment
from brake_monitor.samples import TRAITS, Channel, Quantity
from brake_monitor.settings.config import EstimatorSettings

UNEXPLAINED_SIGMAS = 3.0  # of d as known beforehand; in `wagon` a gradient of 30 per mille


def new_core(
    kind: type[Core],
    brakes: BrakeFilter,
    settings: EstimatorSettings,
    channels: Sequence[Channel],
    *,
    foretells: bool,
) -> Core:
    """Put a core together around a filter; `channels`, one for each measurand, are numbered in this order."""
    wagon, layout, tuning = brakes.wagon, brakes.layout, brakes.tuning
    by_measurand = {channel.measurand: channel for channel in channels}
    measured = [*((Quantity.AXLE_SPEED, i) for i in range(layout.wheelset_count)), (Quantity.SPEED, 0)]
    noise_std = [by_measurand[measurand].noise_std for measurand in measured]
    has_torque_signal = any(channel.quantity is Quantity.WHEEL_TORQUE for channel in channels)
    loads_n = wagon.wheel_load_n(0.0, wagon.vehicle.mass_kg)
    return kind(
        now=WagonMoment(wagon.vehicle.mass_kg, tuning.deceleration_per_metre),
        wheelset_count=layout.wheelset_count,
        friction_place=layout.friction.start,
        adhesion_place=layout.adhesion.start,
        deceleration_place=layout.deceleration,
        force_effect_place=layout.force_effect,
        decay_place=layout.decay,
        uptake_place=layout.uptake.start,
        lag_place=layout.lag,
        torque_error_place=layout.torque_error.start,
        wheels=[
            WheelsetMoment(
                own,
                load_n,
                settings.contact_force_n,
                std**2,
                has_motor=(Quantity.WHEEL_TORQUE, i) in by_measurand,
            )
            for i, (own, load_n, std) in enumerate(zip(wagon.wheelsets, loads_n, noise_std[:-1], strict=True))
        ],
        readings=[Readings(std) for std in noise_std],
        channels=[_state(channel, tuning, layout.speed) for channel in channels],
        load_n=[nan] * sum(channel.quantity is Quantity.LOAD_FORCE for channel in channels),
        tuning=tuning,
        foretold=Foretold(foretells),
        largest_deceleration_mps2=UNEXPLAINED_SIGMAS * hypot(tuning.deceleration_std, tuning.deceleration_onset_std),
        one_wsp_signal=(Quantity.WSP_ACTIVE, 1) not in by_measurand,
        has_torque_signal=has_torque_signal,
        learns_lag=tuning.speed_lag_std > 0.0,
        learns_torque_error=layout.torque_error.stop > layout.torque_error.start,
        filter=brakes,
    )


def _state(channel: Channel, tuning: Tuning, speed_place: int) -> ChannelState:
    fixed = {Quantity.AXLE_SPEED: tuning.omega_variance, Quantity.SPEED: tuning.speed_variance}
    return ChannelState(
        TELLS.get(channel.quantity, ELSE),
        channel.wheelset,
        speed_place if channel.quantity is Quantity.SPEED else channel.wheelset,
        fixed.get(channel.quantity) or channel.noise_std**2,
        TRAITS[channel.quantity].largest,
    )
