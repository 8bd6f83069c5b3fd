"""A pressing force that falls to nothing alone, and the wagon does not notice: its sensor has died."""

from brake_monitor.estimation.core.regime_watch import PRESSES_N
from brake_monitor.monitoring.inputs.nominal_brakes import NominalBrakes
from brake_monitor.monitoring.inputs.pressed_brakes import REMEMBERED_S, PressedBrakes
from brake_monitor.monitoring.inputs.watched_force import WORKS

FELL_S = 0.5  # a force that dies falls as quickly
COMPARED_S = REMEMBERED_S - FELL_S  # after the fall, by when the mean retardation no longer contains it
LEAST_RETARDATION_MPS2 = 0.12  # to be expected of it; less is lost in gradients
SHOWED = 0.7  # of what the forces make, before the fall: else they came and went more often than they are looked at
OTHERS_CHANGED = 0.3  # of the greater force; then the retardation says nothing of one brake


def has_died(i: int, brakes: PressedBrakes, nominal: NominalBrakes, mass_kg: float) -> bool:
    """Whether the force of brake i fell so a while ago, and has not come back."""
    before, now = brakes.past[0], brakes.past[-1]
    if not _fell(i, brakes) or before.total_mps2 is None or now.total_mps2 is None:
        return False
    others = [pair for k, pair in enumerate(zip(before.forces_n, now.forces_n, strict=True)) if k != i]
    if any(abs(now_n - before_n) > OTHERS_CHANGED * max(now_n, before_n) for before_n, now_n in others):
        return False
    before_mps2 = nominal.all_mps2(before.forces_n, mass_kg)
    if before.total_mps2 < SHOWED * before_mps2:
        return False
    expected_mps2 = nominal.retardation_mps2(i, before.forces_n[i] - now.forces_n[i], mass_kg)
    more_mps2 = nominal.all_mps2(now.forces_n, mass_kg) - before_mps2 + expected_mps2  # by the others than before
    told = [past.total_mps2 for past in brakes.past if past.total_mps2 is not None]
    missing_mps2 = max(told) + more_mps2 - now.total_mps2  # these means follow a brake that has just come on
    return expected_mps2 > LEAST_RETARDATION_MPS2 and missing_mps2 < WORKS * expected_mps2


def _fell(i: int, brakes: PressedBrakes) -> bool:
    """Whether it did, in mid-application. One that was not told then was held: it has not fallen now."""
    before, now_s = brakes.past[0], brakes.past[-1].time_s
    if before.forces_n[i] < PRESSES_N or not before.told[i]:
        return False
    if min(now_s - before.time_s, before.time_s - brakes.applied_s) < COMPARED_S:
        return False
    since = [past for past in brakes.past if past.time_s >= before.time_s + FELL_S]
    return all(past.forces_n[i] < brakes.contact_force_n for past in since)
