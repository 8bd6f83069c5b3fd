"""What the live view shows, as a value. Speeds are in km/h, forces in kN, and NaN where nothing tells them."""

from math import floor, nan
from typing import TYPE_CHECKING, Self

from msgspec import Struct
from msgspec.structs import replace

from brake_monitor.desk.text_marks import Moment, wsp
from brake_monitor.estimation.estimate import Estimate
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.samples import Quantity
from brake_monitor.settings.alarm_settings import LowAdhesionRule
from brake_monitor.settings.config import Vehicle

if TYPE_CHECKING:
    from brake_monitor.processing.pipeline import Outputs

BIN_S = 0.5  # of the sparkline
HISTORY = 240  # bins kept
ALARMS_SHOWN = 6


class Board(Struct, frozen=True):
    """Everything that the view shows, after some outputs."""

    vehicle: Vehicle
    rule: LowAdhesionRule
    begun_s: float = nan
    estimate: Estimate | None = None
    history: tuple[Moment | None, ...] = ()  # None: nothing came in that time
    alarms: tuple[Alarm, ...] = ()  # as they stand now, oldest first

    def after(self, outputs: "Outputs") -> Self:
        """Return the board with the outputs on it."""
        board = self
        if outputs.alarms:
            changed = {alarm.id for alarm in outputs.alarms}
            alarms = (*(alarm for alarm in self.alarms if alarm.id not in changed), *outputs.alarms)
            cleared = [alarm for alarm in alarms if alarm.cleared_time_s is not None]
            gone = {alarm.id for alarm in cleared[: max(0, len(alarms) - ALARMS_SHOWN)]}
            board = replace(board, alarms=tuple(alarm for alarm in alarms if alarm.id not in gone))
        if outputs.estimate is not None:
            board = board._with_estimate(outputs.estimate)
        return board

    def _with_estimate(self, estimate: Estimate) -> Self:
        moment = Moment(estimate.adhesion, estimate.saturated)
        step = HISTORY if self.estimate is None else _bin(estimate.time_s) - _bin(self.estimate.time_s)
        begun_s, history = self.begun_s, self.history
        if not 0 <= step < HISTORY:  # the beginning, or time jumped
            begun_s, history = estimate.time_s, (moment,)
        elif step == 0:
            history = (*history[:-1], moment.beside(history[-1]))
        else:
            history = (*history, *[None] * (step - 1), moment)[-HISTORY:]
        return replace(self, begun_s=begun_s, estimate=estimate, history=history)


def _bin(time_s: float) -> int:
    return floor(time_s / BIN_S)


def alarm_name(alarm: Alarm) -> str:
    """What it is and where."""
    return alarm.kind.replace("_", " ") + ("" if alarm.wheelset is None else f", wheelset {alarm.wheelset}")


def status_words(estimate: Estimate) -> str:
    """The status and its reasons."""
    return ", ".join((estimate.status, *estimate.reasons))


def speed_kmh(estimate: Estimate) -> float:
    """Speed of the vehicle; NaN when no sensor tells it, as in the functions below."""
    return estimate.speed_mps * 3.6 if estimate.knows(Quantity.SPEED) else nan


def wheel_kmh(board: Board, estimate: Estimate, place: int) -> float:
    """Circumferential speed of a wheelset, counted from 0."""
    if not estimate.knows(Quantity.AXLE_SPEED, place):
        return nan
    return estimate.wheelsets[place].omega_radps * board.vehicle.wheel_radius_m[place] * 3.6


def slip_of(estimate: Estimate, place: int) -> float:
    """Slip of a wheelset."""
    return estimate.wheelsets[place].slip if estimate.knows_slip(place) else nan


def force_kn_of(estimate: Estimate, place: int) -> float:
    """The pressing force on a wheelset."""
    return estimate.wheelsets[place].pressing_force_n / 1000 if estimate.knows(Quantity.PRESSING_FORCE, place) else nan


def wsp_of(estimate: Estimate, place: int) -> str:
    """Whether the slide protection of a wheelset acts, in three characters."""
    return wsp(estimate.wheelsets[place].wsp_active if estimate.knows(Quantity.WSP_ACTIVE, place) else None)
