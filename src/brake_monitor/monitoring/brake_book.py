"""Keeps the books of the brake units: use of the pads, heat of the discs, one record per brake application."""

from collections.abc import Sequence

from brake_monitor.brake_work import WheelsetWork
from brake_monitor.estimate import Estimate
from brake_monitor.monitoring.brakes import Brakes, BrakeUnit
from brake_monitor.monitoring.disc_temperature import disc_temperature_c
from brake_monitor.monitoring.observation import InputReport, good
from brake_monitor.monitoring.stops import LONGEST_GAP_S, StopRecord, StopRecorder
from brake_monitor.monitoring.wear import PadUse, PadWear
from brake_monitor.samples import InputCondition, Quantity
from brake_monitor.wear_settings import WearSettings

STOPS_KEPT = 30


class BrakeBook:
    """Sees every estimate of one run of the program, whose totals of work begin at 0; `brakes` is what it knows."""

    def __init__(self, wheelset_count: int, settings: WearSettings, contact_force_n: float) -> None:
        self._settings = settings
        self._recorder = StopRecorder(contact_force_n)
        self._seen: tuple[WheelsetWork, ...] = tuple(WheelsetWork() for _ in range(wheelset_count))
        self._distance_m = 0.0
        unit = BrakeUnit(PadWear.new(settings), settings.ambient_c)
        self.brakes = Brakes(None, (unit,) * wheelset_count, ())

    def resume(self, brakes: Brakes) -> None:
        """Go on with what was known when the program ended."""
        self.brakes = brakes

    def see(self, now: Estimate, inputs: Sequence[InputReport]) -> tuple[StopRecord, ...]:
        """Take the next estimate; the brake application that it ended, if it did."""
        count = len(now.wheelsets)
        known = good(inputs, Quantity.PRESSING_FORCE, count)
        turning = good(inputs, Quantity.AXLE_SPEED, count)
        temperatures_c = [unit.disc_temperature_c for unit in self.brakes.units]
        gradient_is_known = _gradient_is_known(inputs)
        finished = self._recorder.see(now, known, temperatures_c, gradient_is_known=gradient_is_known)
        stops = () if finished is None else (finished,)
        work = [_since(before, wheelset.work) for before, wheelset in zip(self._seen, now.wheelsets, strict=True)]
        measured = [force and speed for force, speed in zip(known, turning, strict=True)]
        distance_m = now.distance_m - self._distance_m
        self._seen, self._distance_m = tuple(wheelset.work for wheelset in now.wheelsets), now.distance_m
        step_s = 0.0 if self.brakes.time_s is None else now.time_s - self.brakes.time_s
        units = tuple(
            self._unit(unit, done, PadUse(stops=float(len(stops)), distance_m=distance_m), now.speed_mps, step_s)
            for unit, done in zip(self.brakes.units, _believable(work, measured), strict=True)
        )
        self.brakes = Brakes(now.time_s, units, (*self.brakes.stops, *stops)[-STOPS_KEPT:])
        return stops

    def _unit(self, unit: BrakeUnit, work: WheelsetWork, use: PadUse, speed_mps: float, step_s: float) -> BrakeUnit:
        use = PadUse(work.pad_energy_j, work.force_travel_nm, use.stops, work.sliding_distance_m, use.distance_m)
        power_w = work.pad_energy_j / step_s if 0.0 < step_s <= LONGEST_GAP_S else 0.0
        temperature_c = disc_temperature_c(unit.disc_temperature_c, power_w, speed_mps, step_s, self._settings)
        return BrakeUnit(unit.pads.used(use), temperature_c)


def _gradient_is_known(inputs: Sequence[InputReport]) -> bool:
    conditions = {report.condition for report in inputs if report.quantity is Quantity.GRADIENT}
    return conditions == {InputCondition.GOOD}


def _since(before: WheelsetWork, now: WheelsetWork) -> WheelsetWork:
    return WheelsetWork(
        now.pad_energy_j - before.pad_energy_j,
        now.force_travel_nm - before.force_travel_nm,
        now.sliding_distance_m - before.sliding_distance_m,
        now.wsp_actions - before.wsp_actions,
    )


def _believable(work: list[WheelsetWork], known: list[bool]) -> list[WheelsetWork]:
    """A wheelset whose pressing force or speed is not measured is taken to do what the others do on average."""
    measured = [done for done, is_known in zip(work, known, strict=True) if is_known]
    count = max(len(measured), 1)
    energy_j = sum(done.pad_energy_j for done in measured) / count
    travel_nm = sum(done.force_travel_nm for done in measured) / count
    return [
        done if is_known else WheelsetWork(energy_j, travel_nm, done.sliding_distance_m, done.wsp_actions)
        for done, is_known in zip(work, known, strict=True)
    ]
