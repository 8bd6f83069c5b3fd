"""The brake applications of the truth."""

from dataclasses import dataclass
from math import inf

import numpy as np

from brake_monitor.arrays import Bools, Floats
from brake_monitor.simulator.due.alarm import AFTERMATH_S
from brake_monitor.simulator.due.truth import RELEASED_N, RUNNING_MPS, STEP_S, Truth, spans
from brake_monitor.simulator.physics.pad import LOW_SPEED_MPS, LOW_SPEED_RISE, NOMINAL_FRICTION, PRESSURE_LOSS
from brake_monitor.simulator.plant import GRAVITY_MPS2

TELLING_J = 300e3  # energy of the wheelset that brakes most, below which an application tells nothing
PRESSED = 0.8  # of an application
# 20 per mille: twice what a gradient may change by unseen while a brake is applied until standstill
GRADIENT_MPS2 = 0.2
STEEPEST = 0.03  # of a gradient that no signal tells; see _gradient_doubt


@dataclass(frozen=True)
class Application:
    """One brake application of the truth."""

    start_s: float
    end_s: float
    torque_nm: Floats  # mean over the way on which nothing slid, shape (N,)
    pressed: Bools  # which brakes did nearly all the time: the others are not uneven, they are not applied
    effect: Floats  # effective friction over what sound cold pads would have had, weighted by energy; NaN: unknown
    of_nominal: Floats  # effective friction over NOMINAL_FRICTION
    hottest_c: float
    gradient_doubt: float  # what a gradient that changed meanwhile would do to the friction that is seen, relative

    @property
    def told_s(self) -> tuple[float, float]:
        """From when until when an alarm may tell of it."""
        return self.start_s, self.end_s + AFTERMATH_S


def brake_applications(truth: Truth) -> list[Application]:
    """Every brake application that says something, in order of time."""
    braking = (np.max(truth["pressing_force_n"], axis=0) > RELEASED_N) & truth.supplied & (truth.speed_mps > 0.5)
    rolling = ~np.any(truth.sliding | truth.braked_by_motors, axis=0)  # and by their pads alone
    found = (_application(truth, rolling, start, end) for start, end in spans(braking, least_s=1.0, gap_s=2.0))
    return [one for one in found if one is not None]


def _application(truth: Truth, all_rolling: Bools, start: int, end: int) -> Application | None:
    """What the rows from `start` to `end` tell; None when they are too light, or something slid nearly always."""
    rows = slice(start, end + 1)
    rolling = all_rolling[rows]
    torque, omega = truth["brake_torque_nm"][:, rows], truth["omega_radps"][:, rows]
    energy_j = np.sum(torque * omega, axis=1) * STEP_S
    if np.max(energy_j) < TELLING_J or np.sum(rolling) * STEP_S < 2.0:
        return None
    gears = truth.recording.gears
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
    nominal_j = np.sum(NOMINAL_FRICTION * shown_n * radius_m * omega * rolling, axis=1) * STEP_S
    weight = omega * rolling
    return Application(
        start_s=start * STEP_S,
        end_s=end * STEP_S,
        pressed=np.mean(truth["pressing_force_n"][:, rows] > RELEASED_N, axis=1, where=rolling) > PRESSED,
        torque_nm=np.sum(torque * weight, axis=1) / np.maximum(np.sum(weight, axis=1), 1e-9),
        effect=np.where(sound_j > 0.3 * TELLING_J, own_j / np.maximum(sound_j, 1.0), np.nan),
        of_nominal=own_j / np.maximum(nominal_j, 1.0),
        hottest_c=float(np.max(truth["disc_temperature_c"][:, rows])),
        gradient_doubt=_gradient_doubt(truth, rows),
    )


def _gradient_doubt(truth: Truth, rows: slice) -> float:
    """Nobody can tell a gradient from friction while the brake is applied; rolling on afterwards shows it.

    What is steeper than railways usually are, and told by no signal, may as well be a pull, which ends as the brake
    begins; nobody knows how much of it did.
    """
    is_told = truth.recording.settings.signals.gradient is not None
    if not is_told and np.max(np.abs(truth.gradient[rows])) > STEEPEST:
        return inf
    if truth.speed_mps[min(rows.stop + round(3.0 / STEP_S), len(truth.speed_mps) - 1)] > RUNNING_MPS:
        return 0.0
    return GRADIENT_MPS2 / max(GRAVITY_MPS2 * float(np.mean(truth.adhesion[rows])), 1e-3)
