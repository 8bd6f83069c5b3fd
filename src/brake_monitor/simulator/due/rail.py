"""What is due of a slippery rail: low adhesion, wheelsets that slide, and wheelsets that no longer turn."""

from collections.abc import Iterator

import numpy as np

from brake_monitor.simulator.due.alarm import AFTERMATH_S, DELAY_S, MARGIN, SETTLED_S, Due
from brake_monitor.simulator.due.truth import RUNNING_MPS, SLIDING_SLIP, STEP_S, WALKING_MPS, Truth, spans

LOW_ADHESION = 0.10
WINDOW_S = 0.5
NOT_ROTATING = 0.03  # circumferential over vehicle speed
SLIDE_M = 20.0  # way across the rail from which a flat is likely


def low_adhesion(truth: Truth) -> Iterator[Due]:
    """The most that the rail gave within half a second is below 0.10, while more was asked for."""
    asked = np.any(truth.sliding, axis=0) & (truth.time_s > SETTLED_S)
    window = round(WINDOW_S / STEP_S)
    given = np.where(asked, truth.adhesion, np.inf)
    most = np.lib.stride_tricks.sliding_window_view(np.concatenate((np.full(window, np.inf), given)), window + 1)
    greatest = np.max(most, axis=1)
    clearly = (greatest < 0.9 * LOW_ADHESION) & truth.supplied
    kind, level = "low_adhesion", "the rail gives less than 0.10 and more is asked for"
    for start, end in spans(asked & truth.supplied, gap_s=3.0):
        low = np.flatnonzero(clearly[start : end + 1])
        if len(low):
            from_s = (start + int(low[0])) * STEP_S
            if truth.speed_mps[start + int(low[0])] > WALKING_MPS + 1.0:
                yield truth.due(kind, None, (start * STEP_S, end * STEP_S), from_s, level)
    for start, end in spans(asked & (truth.adhesion < 1.15 * LOW_ADHESION), gap_s=3.0):
        yield truth.due(
            kind, None, (start * STEP_S, end * STEP_S + 3.0), None, "near its threshold, or a dragged wheel"
        )


def wheelset_not_rotating(truth: Truth) -> Iterator[Due]:
    """One stands while the wagon moves."""
    kind, why = "wheelset_not_rotating", "does not turn at more than 5 km/h"
    for i in range(truth.count):
        stands = np.abs(truth["omega_radps"][i] * truth.radius_m[i]) < NOT_ROTATING * truth.speed_mps
        for start, end in spans(stands & (truth.speed_mps > WALKING_MPS) & (truth.time_s > SETTLED_S)):
            span = (start * STEP_S, end * STEP_S + 2.0)
            clear = (end - start) * STEP_S > DELAY_S[kind] and truth.speed_mps[start] > RUNNING_MPS
            yield truth.due(kind, i, span, start * STEP_S if clear else None, why)


def slide(truth: Truth) -> Iterator[Due]:
    """One slides so far that it may get a flat."""
    kind = "slide"
    for i in range(truth.count):
        slides = (truth["slip"][i] > SLIDING_SLIP) & (np.abs(truth.speed_mps) > WALKING_MPS)
        for start, end in spans(slides, gap_s=3.0):
            across_m = np.cumsum(np.where(slides, truth["slip"][i] * truth.speed_mps, 0.0)[start : end + 1]) * STEP_S
            span = (start * STEP_S, end * STEP_S + AFTERMATH_S)
            far = np.flatnonzero(across_m > (1.0 + MARGIN) * SLIDE_M)
            qualified_s = (start + int(far[0])) * STEP_S if len(far) else None
            yield truth.due(kind, i, span, qualified_s, f"slides {across_m[-1]:.0f} m across the rail")
