"""What is due at the end of a brake application: uneven braking, pads with another friction, friction that drifts."""

from collections.abc import Iterator, Sequence

import numpy as np

from brake_monitor.simulator.due.alarm import MARGIN, Due
from brake_monitor.simulator.due.applications import Application
from brake_monitor.simulator.due.brakes import HOT_C
from brake_monitor.simulator.due.truth import Truth

UNEVEN = 0.20
OUT_OF_BAND = 0.15
BAND_STOPS = 20
KNOWN_TO = 0.1  # two standard deviations of what mass and pressing force are known to, 5 % in all
DRIFT = 0.15
DRIFT_STOPS = (10, 20)


def uneven_braking(truth: Truth, applications: Sequence[Application]) -> Iterator[Due]:
    """The weak one is due; that the others stand apart from it is its consequence."""
    if truth.count == 1:
        return
    kind = "uneven_braking"
    for one in applications:
        for i in range(truth.count):
            others_nm = float(np.mean(np.delete(one.torque_nm, i)))
            apart = float(one.torque_nm[i]) / max(others_nm, 1e-9) - 1.0
            if abs(apart) > (1.0 - MARGIN) * UNEVEN:
                clear = apart < -(1.0 + MARGIN) * UNEVEN and bool(one.pressed[i])
                qualified_s = one.end_s if clear else None
                yield truth.due(kind, i, one.told_s, qualified_s, f"{1.0 + apart:.2f} of the others' torque")


def friction_out_of_band(truth: Truth, applications: Sequence[Application]) -> Iterator[Due]:
    """The pads gave another friction than sound ones would have."""
    kind = "friction_out_of_band"
    for k, one in enumerate(applications):
        for i in range(truth.count):
            off = float(abs(one.effect[i] - 1.0))
            if off > (1.0 - MARGIN) * OUT_OF_BAND:
                clear = _is_beyond_doubt(applications[: k + 1], i)
                qualified_s = one.end_s if clear else None
                yield truth.due(kind, i, one.told_s, qualified_s, f"{one.effect[i]:.2f} of sound pads' friction")


def _is_beyond_doubt(applications: Sequence[Application], i: int) -> bool:
    """Whether some number of the last ones shows it, by more than friction can be known.

    The unseen gradient differs between them: the doubt that it puts on their mean falls with the root of their number.
    The doubt about mass and pressing force stays.
    """
    for count in range(1, min(len(applications), BAND_STOPS) + 1):
        last = applications[-count:]
        off, of_nominal = (
            np.array([values[i] for values in which]) - 1.0
            for which in ([one.effect for one in last], [one.of_nominal for one in last])
        )
        if not np.min(off * np.sign(off[-1])) > (1.0 + MARGIN) * OUT_OF_BAND:
            return False
        gradient = float(np.sqrt(np.sum(np.square([one.gradient_doubt * one.effect[i] for one in last])))) / count
        if min(abs(np.mean(off)), abs(np.mean(of_nominal))) > OUT_OF_BAND + float(np.hypot(gradient, KNOWN_TO)):
            return True
    return False


def friction_drift(truth: Truth, applications: Sequence[Application]) -> Iterator[Due]:
    """A straight line through the last applications' friction changes by more than 15 %; not because it is hot."""
    kind, (least, most) = "friction_drift", DRIFT_STOPS
    for i in range(truth.count):
        effects = [(one, one.effect[i]) for one in applications if np.isfinite(one.effect[i])]
        for k in range(least - 1, len(effects)):
            last = [effect for _, effect in effects[max(0, k + 1 - most) : k + 1]]
            change = float(np.polyfit(np.arange(len(last)), last, 1)[0]) * (len(last) - 1)
            if abs(change) > (1.0 - MARGIN) * DRIFT:
                one = effects[k][0]
                clear = abs(change) > (1.0 + MARGIN) * DRIFT and one.hottest_c < HOT_C - 100.0
                qualified_s = one.end_s if clear else None
                why = f"friction changed by {change:+.2f} over {len(last)} stops"
                yield truth.due(kind, i, one.told_s, qualified_s, why)
