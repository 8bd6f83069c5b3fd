"""What is due of a brake unit: it presses though it was released, does not press, or has hot discs."""

from collections.abc import Iterator

import numpy as np

from brake_monitor.simulator.due.alarm import AFTERMATH_S, DELAY_S, Due
from brake_monitor.simulator.due.truth import RELEASED_N, RUNNING_MPS, STEP_S, Truth, spans
from brake_monitor.simulator.physics.pad import AMBIENT_C

PRESSING_N = 4000.0
HELD_S = 20.0  # a wheelset that stands for so long after the release is beyond doubt not let go
HOT_C = 400.0
HEAT_DOUBT = 0.1


def dragging_brake(truth: Truth) -> Iterator[Due]:
    """A brake presses though the driver has released."""
    kind, why = "dragging_brake", "presses after the release"
    released = ~truth.supplied & (truth.speed_mps > RUNNING_MPS)
    for i in range(truth.count):
        force_n = truth["pressing_force_n"][i]
        for start, end in spans(released & (force_n > RELEASED_N), least_s=2.0, gap_s=0.5):
            span = (start * STEP_S, end * STEP_S + AFTERMATH_S)
            clear = np.median(force_n[start : end + 1]) > PRESSING_N and (end - start) * STEP_S > DELAY_S[kind]
            omega_radps = truth["omega_radps"][i][start : end + 1]
            turns, stands = np.min(omega_radps) > 0.5, np.max(omega_radps[: round(HELD_S / STEP_S)]) < 0.5
            qualified_s = start * STEP_S if clear and (turns or stands) else None
            yield truth.due(kind, i, span, qualified_s, why)


def brake_not_applied(truth: Truth) -> Iterator[Due]:
    """One does not press while at least half of all do, with full force.

    No measurement on the wagon tells half of them that lost their air in mid-application from half that have released
    while the others drag: the alarm about the former is not required, and the one about the others is allowed.
    """
    kind, why = "brake_not_applied", "does not press while the others do"
    force_n = truth["pressing_force_n"]
    pressing, released = force_n > 10e3, force_n < RELEASED_N
    clearly = np.all(pressing | released, axis=0) & (2 * np.sum(pressing, axis=0) >= truth.count) & truth.supplied
    clearly &= (truth.speed_mps > RUNNING_MPS) & ~np.any(truth["wsp"] > 0.0, axis=0)
    for i in range(truth.count):
        for start, end in spans(released[i] & clearly & ~truth.braked_by_motors[i], least_s=2.0):
            begun = start - int(np.argmin(truth.supplied[start::-1]))
            took_part = np.any(pressing[i, begun:start])
            by_half = took_part and 2 * np.sum(pressing[:, start]) <= truth.count
            clear = (end - start) * STEP_S > 5.0 and not by_half
            span = (start * STEP_S, end * STEP_S + 2.0)
            yield truth.due(kind, i, span, start * STEP_S if clear else None, why)
            for k in np.flatnonzero(pressing[:, start]) if by_half else ():
                yield truth.due("dragging_brake", int(k), span, None, "alone it presses: it might be dragging")


def hot_disc(truth: Truth) -> Iterator[Due]:
    """The discs of one are hotter than 400 °C, as far as the heat that went into them can be known."""
    kind, doubt = "hot_disc", _doubt_of_heat(truth)
    for i in range(truth.count):
        temperature_c = truth["disc_temperature_c"][i]
        least_c, clear_c = (AMBIENT_C + (HOT_C - AMBIENT_C) * factor for factor in (1.0 - doubt, 1.0 + doubt))
        for start, end in spans(temperature_c > least_c):
            hot = np.flatnonzero(temperature_c[start : end + 1] > clear_c)
            qualified_s = (start + int(hot[0])) * STEP_S if len(hot) else None
            why = f"its discs reach {np.max(temperature_c[start : end + 1]):.0f} °C"
            yield truth.due(kind, i, (start * STEP_S, end * STEP_S + AFTERMATH_S), qualified_s, why)


def _doubt_of_heat(truth: Truth) -> float:
    """Relative. In a train the pads' common friction does not show: it is known as that of new pads (two sigma)."""
    estimator = truth.recording.settings.estimator
    unseen = 2.0 * estimator.friction_nominal_std / estimator.friction_nominal
    return unseen if estimator.preset == "train" else HEAT_DOUBT
