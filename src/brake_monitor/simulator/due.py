"""When which alarm is due, told from the truth alone: the plant's state and the faults, never an estimate.

An alarm is *due* from when its condition qualifies by the truth, clearly; it *may* come (`by_s` is None) where the
condition is near its threshold, and where it is a consequence of another one. Anything else is a false alarm.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from brake_monitor.simulator.pad import AMBIENT_C, LOW_SPEED_MPS, LOW_SPEED_RISE, NOMINAL_FRICTION, PRESSURE_LOSS
from brake_monitor.simulator.plant import GRAVITY_MPS2
from brake_monitor.simulator.sensor_faults import BusFailure, BusFault, SensorFailure, SensorFault
from brake_monitor.simulator.simulate import EPOCH_S, Recording

Values = NDArray[np.float64]
Flags = NDArray[np.bool_]

STEP_S = 0.01
SETTLED_S = 4.0  # nothing is due before the monitor had time to settle
WALKING_MPS = 1.39  # 5 km/h
RUNNING_MPS = 3.0
SUPPLIED_BAR = 0.35  # the driver brakes
SLIDING_SLIP = 0.05
LOW_ADHESION = 0.10
WINDOW_S = 0.5
NOT_ROTATING = 0.03  # circumferential over vehicle speed
SLIDE_M = 20.0  # way across the rail from which a flat is likely
PRESSING_N = 4000.0
RELEASED_N = 1000.0
UNEVEN = 0.20
OUT_OF_BAND = 0.15
GRADIENT_MPS2 = (
    0.2  # 20 per mille: twice what a gradient may change by unseen while a brake is applied until standstill
)
DRIFT = 0.15
DRIFT_STOPS = (10, 20)
HOT_C = 400.0
TELLING_J = 300e3  # energy of the wheelset that brakes most, below which an application tells nothing
WEAR_DOUBT = 0.2  # of what is lost: within it a limit may be reached
MARGIN = 0.3  # of a threshold: beyond it an alarm is due, within it may come
AFTERMATH_S = 15.0  # so long after its end a condition may still be told of

DELAY_S = {
    "low_adhesion": 1.0,
    "wheelset_not_rotating": 3.0,
    "slide": 5.0,
    "dragging_brake": 30.0,
    "brake_not_applied": 10.0,
    "uneven_braking": 5.0,  # after the brake application, as the next two
    "friction_out_of_band": 5.0,
    "friction_drift": 5.0,
    "hot_disc": 30.0,
    "pad_near_limit": 5.0,  # after the brake application
    "pad_at_limit": 5.0,
    "input_lost": 5.0,
    "input_implausible": 20.0,
    "bus_silent": 5.0,
    "bus_fault": 5.0,
}


COLUMNS = (
    "omega_radps",
    "slip",
    "pressing_force_n",
    "pressure_bar",
    "wsp",
    "disc_temperature_c",
    "past_peak",
    "brake_torque_nm",
    "creep_force_n",
    "load_n",
)


class Due(Struct, frozen=True):
    """One alarm that is due or may come. Times are the log's."""

    kind: str
    wheelset: int | None  # from 1
    from_s: float  # when it qualifies
    by_s: float | None  # when it must be raised at the latest; None: it may come
    until_s: float  # when it has gone
    reason: str


def dues(recording: Recording) -> list[Due]:
    """All alarms that are due or may come, in order of time."""
    found = [due for rule in RULES for due in rule(_Truth.of(recording))]
    return sorted(found, key=lambda due: (due.from_s, due.kind, due.wheelset or 0))


@dataclass(frozen=True)
class _Truth:
    """The truth every 10 ms; shapes (K,) and (N, K). Times count from the start."""

    recording: Recording
    time_s: Values
    speed_mps: Values
    supplied: Flags  # the driver brakes
    adhesion: Values
    radius_m: Values  # shape (N, 1)
    wheels: dict[str, Values]

    @classmethod
    def of(cls, recording: Recording) -> "_Truth":
        trace, every = recording.trace, round(STEP_S / recording.trace.step_s)
        count = range(trace.wheelset_count)

        def wheels(name: str) -> Values:
            return np.array([trace.wheelset(i, name)[::every] for i in count])

        values = {name: wheels(name) for name in COLUMNS}
        speed_mps = trace.wagon("speed_mps")[::every]
        return cls(
            recording,
            np.asarray(np.arange(len(speed_mps)) * STEP_S, dtype=np.float64),
            speed_mps,
            trace.wagon("supply_pressure_bar")[::every] > SUPPLIED_BAR,
            np.asarray(values["creep_force_n"].sum(axis=0) / values["load_n"].sum(axis=0), dtype=np.float64),
            np.array(recording.settings.vehicle.wheel_radius_m)[:, None],
            values,
        )

    def __getitem__(self, name: str) -> Values:
        return self.wheels[name]

    @property
    def count(self) -> int:
        return len(self.radius_m)

    @property
    def sliding(self) -> Flags:
        """Each wheelset: it is asked for more than the rail gives. Shape (N, K)."""
        sliding: Flags = (self["slip"] > SLIDING_SLIP) | (self["past_peak"] > 0.0) | (self["wsp"] > 0.0)
        return sliding & (np.abs(self.speed_mps) > WALKING_MPS)

    def due(self, kind: str, wheelset: int | None, span: tuple[float, float], by_s: float | None, why: str) -> Due:
        """`wheelset` from 0, times from the start; what would be due after the drive's end may come."""
        if by_s is not None and by_s > self.time_s[-1]:
            by_s = None
        return Due(
            kind,
            None if wheelset is None else wheelset + 1,
            round(EPOCH_S + span[0], 3),
            None if by_s is None else round(EPOCH_S + by_s, 3),
            round(EPOCH_S + span[1], 3),
            why,
        )


@dataclass(frozen=True)
class _Application:
    """One brake application of the truth."""

    rows: slice
    start_s: float
    end_s: float
    torque_nm: Values  # mean over the way on which nothing slid, shape (N,)
    effect: Values  # effective friction over what sound cold pads would have had, weighted by energy; NaN: unknown
    of_nominal: Values  # effective friction over NOMINAL_FRICTION
    hottest_c: float
    gradient_doubt: float  # what a gradient that changed meanwhile would do to the friction that is seen, relative


def _spans(flags: Flags, least_s: float = 0.0, gap_s: float = 0.0) -> Iterator[tuple[int, int]]:
    """First and last row of every run of true flags; shorter gaps are bridged, shorter runs left out."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], flags.astype(np.int8), [0]))))
    merged: list[list[int]] = []
    for start, end in edges.reshape(-1, 2).tolist():
        if merged and (start - merged[-1][1]) * STEP_S < gap_s:
            merged[-1][1] = end
        else:
            merged.append([start, end])
    for start, end in merged:
        if (end - start) * STEP_S >= least_s:
            yield start, end - 1


def _applications(truth: _Truth) -> list[_Application]:
    """Every brake application that says something."""
    braking = (np.max(truth["pressing_force_n"], axis=0) > RELEASED_N) & truth.supplied & (truth.speed_mps > 0.5)
    gears = truth.recording.gears
    found = []
    for start, end in _spans(braking, least_s=1.0, gap_s=2.0):
        rows = slice(start, end + 1)
        rolling = ~np.any(truth.sliding[:, rows], axis=0)
        torque, omega = truth["brake_torque_nm"][:, rows], truth["omega_radps"][:, rows]
        energy_j = np.sum(torque * omega, axis=1) * STEP_S
        if np.max(energy_j) < TELLING_J or np.sum(rolling) * STEP_S < 2.0:
            continue
        radius_m = np.array(truth.recording.settings.vehicle.brake_radius_m)[:, None]
        shown_n = np.array(
            [
                np.maximum(gear.force_per_bar_n * bar + gear.offset_n, 0.0)
                for gear, bar in zip(gears, truth["pressure_bar"][:, rows], strict=True)
            ]
        )
        full_n = np.array([gear.full_force_n for gear in gears])[:, None]
        rise = LOW_SPEED_RISE * np.exp(-np.abs(omega) * radius_m / LOW_SPEED_MPS)
        sound = (NOMINAL_FRICTION + rise - PRESSURE_LOSS * shown_n / full_n) * shown_n * radius_m * omega
        sound_j = np.sum(sound * rolling, axis=1) * STEP_S
        own_j = np.sum(torque * omega * rolling, axis=1) * STEP_S
        effect = np.where(sound_j > 0.3 * TELLING_J, own_j / np.maximum(sound_j, 1.0), np.nan)
        weight = omega * rolling
        nominal_j = np.sum(NOMINAL_FRICTION * shown_n * radius_m * omega * rolling, axis=1) * STEP_S
        of_nominal = own_j / np.maximum(nominal_j, 1.0)
        hottest_c = float(np.max(truth["disc_temperature_c"][:, rows]))
        mean_nm = np.sum(torque * weight, axis=1) / np.maximum(np.sum(weight, axis=1), 1e-9)
        doubt = _gradient_doubt(truth, rows)
        found.append(_Application(rows, start * STEP_S, end * STEP_S, mean_nm, effect, of_nominal, hottest_c, doubt))
    return found


def _gradient_doubt(truth: _Truth, rows: slice) -> float:
    """Nobody can tell a gradient from friction while the brake is applied; rolling on afterwards shows it."""
    if truth.speed_mps[min(rows.stop + round(3.0 / STEP_S), len(truth.speed_mps) - 1)] > RUNNING_MPS:
        return 0.0
    return GRADIENT_MPS2 / max(GRAVITY_MPS2 * float(np.mean(truth.adhesion[rows])), 1e-3)


# -- the rail -----------------------------------------------------------------------------------------------------


def _low_adhesion(truth: _Truth) -> Iterator[Due]:
    """The most that the rail gave within half a second is below 0.10, while more was asked for."""
    asked = np.any(truth.sliding, axis=0) & (truth.time_s > SETTLED_S)
    window = round(WINDOW_S / STEP_S)
    given = np.where(asked, truth.adhesion, np.inf)
    most = np.lib.stride_tricks.sliding_window_view(np.concatenate((np.full(window, np.inf), given)), window + 1)
    greatest = np.max(most, axis=1)
    clearly = (greatest < 0.9 * LOW_ADHESION) & truth.supplied
    kind, level = "low_adhesion", "the rail gives less than 0.10 and more is asked for"
    for start, end in _spans(asked & truth.supplied, gap_s=3.0):
        low = np.flatnonzero(clearly[start : end + 1])
        if len(low):
            from_s = (start + int(low[0])) * STEP_S
            if truth.speed_mps[start + int(low[0])] > WALKING_MPS + 1.0:
                yield truth.due(kind, None, (start * STEP_S, end * STEP_S), from_s + DELAY_S[kind], level)
    for start, end in _spans(asked & (truth.adhesion < 1.15 * LOW_ADHESION), gap_s=3.0):
        yield truth.due(
            kind, None, (start * STEP_S, end * STEP_S + 3.0), None, "near its threshold, or a dragged wheel"
        )


def _not_rotating(truth: _Truth) -> Iterator[Due]:
    kind, why = "wheelset_not_rotating", "does not turn at more than 5 km/h"
    for i in range(truth.count):
        stands = np.abs(truth["omega_radps"][i] * truth.radius_m[i]) < NOT_ROTATING * truth.speed_mps
        for start, end in _spans(stands & (truth.speed_mps > WALKING_MPS) & (truth.time_s > SETTLED_S)):
            span = (start * STEP_S, end * STEP_S + 2.0)
            clear = (end - start) * STEP_S > DELAY_S[kind] and truth.speed_mps[start] > RUNNING_MPS
            yield truth.due(kind, i, span, start * STEP_S + DELAY_S[kind] if clear else None, why)


def _slide(truth: _Truth) -> Iterator[Due]:
    kind = "slide"
    for i in range(truth.count):
        slides = (truth["slip"][i] > SLIDING_SLIP) & (np.abs(truth.speed_mps) > WALKING_MPS)
        for start, end in _spans(slides, gap_s=3.0):
            across_m = np.cumsum(np.where(slides, truth["slip"][i] * truth.speed_mps, 0.0)[start : end + 1]) * STEP_S
            span = (start * STEP_S, end * STEP_S + AFTERMATH_S)
            far = np.flatnonzero(across_m > (1.0 + MARGIN) * SLIDE_M)
            by_s = (start + int(far[0])) * STEP_S + DELAY_S[kind] if len(far) else None
            yield truth.due(kind, i, span, by_s, f"slides {across_m[-1]:.0f} m across the rail")


# -- the brakes ---------------------------------------------------------------------------------------------------


def _dragging(truth: _Truth) -> Iterator[Due]:
    """A brake presses though the driver has released."""
    kind, why = "dragging_brake", "presses after the release"
    released = ~truth.supplied & (truth.speed_mps > RUNNING_MPS)
    for i in range(truth.count):
        force_n = truth["pressing_force_n"][i]
        for start, end in _spans(released & (force_n > RELEASED_N), least_s=2.0, gap_s=0.5):
            span = (start * STEP_S, end * STEP_S + AFTERMATH_S)
            clear = np.median(force_n[start : end + 1]) > PRESSING_N and (end - start) * STEP_S > DELAY_S[kind]
            turns = np.min(truth["omega_radps"][i][start : end + 1]) > 0.5
            by_s = start * STEP_S + DELAY_S[kind] if clear and turns else None
            yield truth.due(kind, i, span, by_s, why)


def _not_applied(truth: _Truth) -> Iterator[Due]:
    """One does not press while the others do."""
    kind, why = "brake_not_applied", "does not press while the others do"
    force_n = truth["pressing_force_n"]
    for i in range(truth.count):
        others = np.delete(force_n, i, axis=0)
        if not len(others):
            continue
        lacks = (force_n[i] < RELEASED_N) & (np.min(others, axis=0) > 10e3) & truth.supplied
        lacks &= (truth.speed_mps > RUNNING_MPS) & ~np.any(truth["wsp"] > 0.0, axis=0)
        for start, end in _spans(lacks, least_s=2.0):
            clear = (end - start) * STEP_S > 5.0
            span = (start * STEP_S, end * STEP_S + 2.0)
            yield truth.due(kind, i, span, start * STEP_S + DELAY_S[kind] if clear else None, why)


def _per_application(truth: _Truth) -> Iterator[Due]:
    """Uneven braking and friction out of band, at the end of each application."""
    for one in _applications(truth):
        for i in range(truth.count):
            yield from _uneven(truth, one, i)
            off = float(abs(one.effect[i] - 1.0))
            if off > (1.0 - MARGIN) * OUT_OF_BAND:
                kind, why = "friction_out_of_band", f"{one.effect[i]:.2f} of sound pads' friction"
                least = max((1.0 + MARGIN) * OUT_OF_BAND, OUT_OF_BAND + one.gradient_doubt)
                clear = min(off, float(abs(one.of_nominal[i] - 1.0))) > least
                by_s = one.end_s + DELAY_S[kind] if clear else None
                yield truth.due(kind, i, (one.start_s, one.end_s + AFTERMATH_S), by_s, why)


def _uneven(truth: _Truth, one: _Application, i: int) -> Iterator[Due]:
    """The weak one is due; that the others stand apart from it is its consequence."""
    if truth.count == 1:
        return
    kind, others_nm = "uneven_braking", float(np.mean(np.delete(one.torque_nm, i)))
    apart = float(one.torque_nm[i]) / max(others_nm, 1e-9) - 1.0
    if abs(apart) > (1.0 - MARGIN) * UNEVEN:
        clear = apart < -(1.0 + MARGIN) * UNEVEN and one.torque_nm[i] > 100.0
        by_s = one.end_s + DELAY_S[kind] if clear else None
        why = f"{1.0 + apart:.2f} of the others' torque"
        yield truth.due(kind, i, (one.start_s, one.end_s + AFTERMATH_S), by_s, why)


def _drift(truth: _Truth) -> Iterator[Due]:
    """A straight line through the last applications' friction changes by more than 15 %; not because it is hot."""
    kind, (least, most) = "friction_drift", DRIFT_STOPS
    applications = _applications(truth)
    for i in range(truth.count):
        effects = [(one, one.effect[i]) for one in applications if np.isfinite(one.effect[i])]
        for k in range(least - 1, len(effects)):
            last = [effect for _, effect in effects[max(0, k + 1 - most) : k + 1]]
            change = float(np.polyfit(np.arange(len(last)), last, 1)[0]) * (len(last) - 1)
            if abs(change) > (1.0 - MARGIN) * DRIFT:
                one = effects[k][0]
                clear = abs(change) > (1.0 + MARGIN) * DRIFT and one.hottest_c < HOT_C - 100.0
                by_s = one.end_s + DELAY_S[kind] if clear else None
                why = f"friction changed by {change:+.2f} over {len(last)} stops"
                yield truth.due(kind, i, (one.start_s, one.end_s + AFTERMATH_S), by_s, why)


def _hot(truth: _Truth) -> Iterator[Due]:
    kind = "hot_disc"
    for i in range(truth.count):
        temperature_c = truth["disc_temperature_c"][i]
        least_c, clear_c = (AMBIENT_C + (HOT_C - AMBIENT_C) * factor for factor in (0.9, 1.1))
        for start, end in _spans(temperature_c > least_c):
            hot = np.flatnonzero(temperature_c[start : end + 1] > clear_c)
            by_s = (start + int(hot[0])) * STEP_S + DELAY_S[kind] if len(hot) else None
            why = f"its discs reach {np.max(temperature_c[start : end + 1]):.0f} °C"
            yield truth.due(kind, i, (start * STEP_S, end * STEP_S + AFTERMATH_S), by_s, why)


def _pads(truth: _Truth) -> Iterator[Due]:
    """Thickness by the energy that the pads really took, with the configured specific wear."""
    wear = truth.recording.settings.wear
    applications, end_s = _applications(truth), float(truth.time_s[-1])
    for i in range(truth.count):
        power_w = truth["brake_torque_nm"][i] * np.abs(truth["omega_radps"][i])
        lost_cm3 = wear.specific_wear_cm3_per_mj * np.cumsum(power_w) * STEP_S / 1e6 / wear.pads_per_wheelset
        lost_mm = 10.0 * lost_cm3 / wear.pad_area_cm2
        for kind, limit_mm in (("pad_near_limit", wear.pad_limit_mm + 3.0), ("pad_at_limit", wear.pad_limit_mm)):
            above_mm = wear.new_pad_thickness_mm - limit_mm
            near, below = (
                np.flatnonzero(lost_mm * factor > above_mm) for factor in (1.0 + WEAR_DOUBT, 1.0 - WEAR_DOUBT)
            )
            if not len(near):
                continue
            by_s = None
            if len(below):
                from_s = int(below[0]) * STEP_S
                by_s = min((one.end_s for one in applications if one.end_s >= from_s), default=from_s) + DELAY_S[kind]
            why = f"its pads are {wear.new_pad_thickness_mm - lost_mm[-1]:.3f} mm thick"
            yield truth.due(kind, i, (int(near[0]) * STEP_S, end_s), by_s, why)


# -- sensors and buses --------------------------------------------------------------------------------------------

PER_WHEELSET = frozenset({"axle_speed", "pressing_force", "wsp_active"})


def _sensors(truth: _Truth) -> Iterator[Due]:
    for fault in truth.recording.modifiers.sensor_faults:
        end_s = min(fault.to_s, float(truth.time_s[-1]))
        yield from _sensor(truth, fault, end_s)


def _sensor(truth: _Truth, fault: SensorFault, end_s: float) -> Iterator[Due]:
    """Lost is what no longer arrives, implausible what arrives and says nothing; nobody sees a bias within the range.

    With a message all signals in it are lost, whosever they are.
    """
    due_kind = "input_lost" if fault.failure is SensorFailure.LOST else "input_implausible"
    place = fault.place if fault.quantity in PER_WHEELSET else None
    span = (fault.from_s, end_s + AFTERMATH_S)
    why = f"{fault.quantity} {fault.place + 1}: {fault.failure}"
    from_s = _tells_from(truth, fault)
    if from_s is not None:
        yield truth.due(due_kind, place, span, from_s + DELAY_S[due_kind], why)
    for kind in ("input_lost", "input_implausible"):
        for wheelset in (None, *range(truth.count)):
            yield truth.due(kind, wheelset, span, None, why)


def _tells_from(truth: _Truth, fault: SensorFault) -> float | None:
    """When the fault can be seen, None: never.

    What a pressing force says wrongly shows once the brakes are applied, beside those of other wheelsets.
    """
    from_s = max(fault.from_s, SETTLED_S)
    if fault.failure is SensorFailure.BIASED:
        return None
    if fault.quantity != "pressing_force" or fault.failure in (SensorFailure.LOST, SensorFailure.ERROR_CODE):
        return from_s
    braked = truth.time_s[truth.supplied & (truth.time_s >= from_s)]
    return float(braked[0]) if truth.count > 1 and len(braked) else None


def _buses(truth: _Truth) -> Iterator[Due]:
    for fault in truth.recording.modifiers.bus_faults:
        yield from _bus(truth, fault)


def _bus(truth: _Truth, fault: BusFault) -> Iterator[Due]:
    due_kind = "bus_silent" if fault.failure is BusFailure.SILENT else "bus_fault"
    span, why = (fault.from_s, fault.to_s + AFTERMATH_S), f"the bus: {fault.failure}"
    yield truth.due(due_kind, None, span, fault.from_s + DELAY_S[due_kind], why)
    yield truth.due("bus_silent", None, span, None, why)
    for kind in ("input_lost", "input_implausible"):
        for wheelset in (None, *range(truth.count)):
            yield truth.due(kind, wheelset, span, None, f"nothing arrives: {why}")


RULES: tuple[Any, ...] = (
    _low_adhesion,
    _not_rotating,
    _slide,
    _dragging,
    _not_applied,
    _per_application,
    _drift,
    _hot,
    _pads,
    _sensors,
    _buses,
)
