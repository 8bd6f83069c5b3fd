"""Keeps the books of the brake units: use of the pads, heat of the discs, one record per brake application."""

from math import inf

from msgspec.structs import replace

from brake_monitor.estimation.brake_work import WheelsetWork
from brake_monitor.estimation.estimate import Estimate
from brake_monitor.monitoring.brake_units.application_record import ApplicationRecord
from brake_monitor.monitoring.brake_units.application_recorder import ApplicationRecorder
from brake_monitor.monitoring.brake_units.brakes import Brakes, BrakeUnit
from brake_monitor.monitoring.brake_units.disc_temperature import Cooling, EarlierHeat
from brake_monitor.monitoring.brake_units.running_application import LONGEST_GAP_S
from brake_monitor.monitoring.brake_units.wear import PadUse
from brake_monitor.monitoring.creep_meter import CreepMeter
from brake_monitor.monitoring.reports import InputReports
from brake_monitor.samples import Quantity
from brake_monitor.settings.alarm_settings import APPLICATIONS_JUDGED
from brake_monitor.settings.wear_settings import WearSettings

AXLE_SPEED, PRESSING_FORCE = Quantity.AXLE_SPEED, Quantity.PRESSING_FORCE


class BrakeBook:
    """Sees every estimate of one run of the program, whose totals of work begin at 0; `brakes` is what it knows."""

    def __init__(
        self, wheelset_count: int, settings: WearSettings, contact_force_n: float, creep: CreepMeter, calibration: int
    ) -> None:
        self._settings = settings
        self._calibration = calibration  # of the friction that it is told
        self._recorder = ApplicationRecorder(contact_force_n, creep)
        self._seen = [WheelsetWork() for _ in range(wheelset_count)]
        self._distance_m = 0.0
        self._resumed_s = -inf  # when an earlier run ended, by the clock
        self._seen_s: float | None = None  # when anything was, in this run
        self._earlier_heat = EarlierHeat(settings)
        self.brakes = Brakes.new(wheelset_count, settings)

    @property
    def kept(self) -> Brakes:
        """What to go on with after the program has ended."""
        running = self._recorder.running
        return replace(self.brakes, running=running and self._marked(running))

    def resume(self, earlier: Brakes) -> None:
        """Go on with what was known when the program ended.

        That may become known only after this run has begun with new pads and cold discs: then both are added.
        """
        earlier = earlier.as_configured(self._settings)
        self.brakes = replace(earlier, running=None) if self._seen_s is None else self._joined(earlier)
        if earlier.running is not None:
            self._recorder.resume(earlier.running)
        if earlier.time_s is not None:
            self._resumed_s = earlier.time_s

    def _marked(self, record: ApplicationRecord) -> ApplicationRecord:
        """The record of this run, or as an earlier one left it."""
        return record if record.calibration is not None else replace(record, calibration=self._calibration)

    def _joined(self, earlier: Brakes) -> Brakes:
        now, heat = self.brakes, self._earlier_heat
        since_s = 0.0 if now.time_s is None or earlier.time_s is None else now.time_s - earlier.time_s
        units = tuple(
            BrakeUnit(
                old.pads.used(new.pads.since_fitted),
                new.disc_temperature_c + heat.left_c(old.disc_temperature_c, since_s),
            )
            for old, new in zip(earlier.units, now.units, strict=True)
        )
        return Brakes(now.time_s, units, (*earlier.applications, *now.applications)[-APPLICATIONS_JUDGED:])

    def see(self, now: Estimate, inputs: InputReports, *, a_brake_drags: bool = False) -> tuple[ApplicationRecord, ...]:
        """Take the next estimate; the brake application that it ended, if it did.

        Where `a_brake_drags` unseen no friction is kept: the drag is part of the line that a brake is told against.
        """
        temperatures_c = [unit.disc_temperature_c for unit in self.brakes.units]
        finished = self._recorder.see(now, inputs, temperatures_c, a_brake_drags=a_brake_drags)
        ended = () if finished is None else (self._marked(finished),)
        count, distance_m = float(len(ended)), now.distance_m - self._distance_m
        works = [wheelset.work for wheelset in now.wheelsets]
        uses = [_since(before, work, count, distance_m) for before, work in zip(self._seen, works, strict=True)]
        self._seen, self._distance_m = works, now.distance_m
        step_s = self._step_s(now)
        cooling = Cooling(now.speed_mps, step_s, self._settings)
        if self._resumed_s == -inf:
            self._earlier_heat.cool(cooling, now.speed_mps, step_s)
        if inputs.not_good:
            uses = _believable(uses, inputs)
        units = [_used(unit, use, cooling, step_s) for unit, use in zip(self.brakes.units, uses, strict=True)]
        kept = self.brakes.applications
        if ended:
            kept = (*kept, *ended)[-APPLICATIONS_JUDGED:]
        self.brakes, self._seen_s = Brakes(now.clock_s, tuple(units), kept), now.time_s
        return ended

    def _step_s(self, now: Estimate) -> float:
        """Since the last observation, perhaps of an earlier run: how long ago that was may become known later."""
        step_s = 0.0 if self._seen_s is None else now.time_s - self._seen_s
        before_s = self.brakes.time_s
        if before_s is not None and before_s <= self._resumed_s <= now.clock_s:
            step_s = max(step_s, now.clock_s - self._resumed_s)
        return step_s


def _used(unit: BrakeUnit, use: PadUse, cooling: Cooling, step_s: float) -> BrakeUnit:
    power_w = use.energy_j / step_s if 0.0 < step_s <= LONGEST_GAP_S else 0.0
    return BrakeUnit(unit.pads.used(use), cooling.temperature_c(unit.disc_temperature_c, power_w))


def _since(before: WheelsetWork, now: WheelsetWork, applications: float, distance_m: float) -> PadUse:
    """What the pads did meanwhile."""
    return PadUse(
        now.pad_energy_j - before.pad_energy_j,
        now.force_travel_nm - before.force_travel_nm,
        applications,
        now.sliding_distance_m - before.sliding_distance_m,
        distance_m,
    )


def _believable(uses: list[PadUse], inputs: InputReports) -> list[PadUse]:
    """A wheelset whose pressing force or speed is not measured counts like the others' average."""
    forces, speeds = (inputs.are_good(quantity, len(uses)) for quantity in (PRESSING_FORCE, AXLE_SPEED))
    is_measured = [force and speed for force, speed in zip(forces, speeds, strict=True)]
    measured = [use for use, is_known in zip(uses, is_measured, strict=True) if is_known]
    count = max(len(measured), 1)
    energy_j = sum(use.energy_j for use in measured) / count
    travel_nm = sum(use.force_travel_nm for use in measured) / count
    return [
        use if is_known else replace(use, energy_j=energy_j, force_travel_nm=travel_nm)
        for use, is_known in zip(uses, is_measured, strict=True)
    ]
