"""Brake units, stops and what was learned, made by hand from one number: what belongs together is recognised."""

import msgspec

from brake_monitor.estimation.learned import Learned
from brake_monitor.monitoring.brake_units.application_record import ApplicationRecord, WheelsetRecord
from brake_monitor.monitoring.brake_units.brakes import Brakes, BrakeUnit
from brake_monitor.monitoring.brake_units.wear import PadUse, PadWear
from brake_monitor.settings.wear_settings import WearSettings
from brake_monitor.storage.store_batch import Batch
from estimates import alarm

WHEELSETS = 2


def pads(number: int, wheelset: int = 1) -> PadWear:
    use = PadUse(energy_j=1.5 * number, force_travel_nm=4.0 * number * wheelset, stops=number, distance_m=0.25 * number)
    return PadWear.new(WearSettings()).used(use)


def brakes(number: int) -> Brakes:
    units = tuple(BrakeUnit(pads(number, i), 20.0 + number % 100) for i in range(1, WHEELSETS + 1))
    return Brakes(1.7e9 + number, units, ())


def learned(number: int) -> Learned:
    radius_m = 0.43 + 1e-9 * number
    return Learned(1.7e9 + number, (radius_m, 0.445), (0.3, 0.31), (0.01, 0.02), 0.01, 0.02)


def stop(number: int) -> ApplicationRecord:
    values = {"start_time_s": 1.7e9 + number, "end_time_s": 1.7e9 + number + 0.5, "calibration": number}
    wheelset = dict.fromkeys(WheelsetRecord.__struct_fields__, 1) | {"friction": None, "energy_j": 1.5}
    wagon = dict.fromkeys(ApplicationRecord.__struct_fields__, 0.25) | values | {"wheelsets": (wheelset,) * WHEELSETS}
    return msgspec.convert(wagon, ApplicationRecord)


def batch(number: int) -> Batch:
    """The state after `number` seconds, and what happened in the last of them."""
    raised = alarm(id=f"hot_disc-1-{number}", raised_time_s=1.7e9 + number)
    return Batch(
        brakes(number), learned(number), {raised.id: raised}, [stop(number)], messages={number: str(number).encode()}
    )
