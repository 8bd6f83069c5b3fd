"""What is due of pads that wear out."""

from collections.abc import Iterator, Sequence

import numpy as np

from brake_monitor.simulator.due.alarm import Due
from brake_monitor.simulator.due.applications import Application
from brake_monitor.simulator.due.truth import STEP_S, Truth

WEAR_DOUBT = 0.2  # of what is lost: within it a limit may be reached


def worn_pads(truth: Truth, applications: Sequence[Application]) -> Iterator[Due]:
    """Thickness by the energy that the pads really took, with the configured specific wear."""
    wear = truth.recording.settings.wear
    end_s = float(truth.time_s[-1])
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
            qualified_s = None
            if len(below):
                from_s = int(below[0]) * STEP_S
                qualified_s = min((one.end_s for one in applications if one.end_s >= from_s), default=from_s)
            why = f"its pads are {wear.new_pad_thickness_mm - lost_mm[-1]:.3f} mm thick"
            yield truth.due(kind, i, (int(near[0]) * STEP_S, end_s), qualified_s, why)
