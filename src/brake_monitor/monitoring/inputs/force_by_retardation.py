"""What share of a brake shows in how the wagon retards, whatever its sensor says.

A brake is one of several, whose friction is not known well: the more of them press, the less one shows. But what all
together make of their forces is learned while all press.
"""

from collections.abc import Sequence
from math import hypot

from brake_monitor.estimation.estimate import MOTORS_ERR, Estimate
from brake_monitor.monitoring.inputs.nominal_brakes import NominalBrakes
from brake_monitor.monitoring.inputs.retardation import Retardation
from brake_monitor.monitoring.inputs.watched_force import ShownShare
from brake_monitor.monitoring.running_mean import RunningMean

LINE_STD_MPS2 = 0.02  # by so much the gradient may have changed since the wagon rolled freely
FRICTION_STD = 0.1  # of itself: from one brake application to the next the pads of all brakes differ by so much ...
GREATEST_REST = 2.0  # ... which counts where the others brake so many times as much as the one in doubt would
LEARNED_FROM = 500  # observations
LEAST_USUAL, MOST_USUAL = 0.5, 2.0  # of what nominal brakes make: beyond it is not their friction that differs


class ForceByRetardation:
    """Judges one wagon by itself; of one in a train, whose retardation is the train's, nothing is seen."""

    def __init__(self, retardation: Retardation, nominal: NominalBrakes) -> None:
        self._retardation = retardation
        self._nominal = nominal
        self._usual = RunningMean(LEARNED_FROM)  # retardation over what nominal brakes make, as all pressed steadily
        self._usual.value = 1.0

    def learn(self, now: Estimate) -> None:
        """Note what all brakes make of their forces, while all press steadily."""
        by_brakes_mps2 = self._retardation.by_brakes_mps2
        if by_brakes_mps2 is not None and not self._retardation.is_pulled:
            self._usual.add(by_brakes_mps2 / self._nominal.all_mps2(now.forces_n, now.mass_kg))

    def share(self, i: int, as_if_n: float, pressing: Sequence[bool], now: Estimate) -> ShownShare | None:
        """Of brake i, over what `as_if_n` would do; None where that cannot be told.

        Where others are as silent as it is, as those of its cylinder, it is what all of them take over what all would.
        """
        in_doubt = [i] if pressing[i] else [k for k, presses in enumerate(pressing) if not presses]
        forces_n = [0.0 if k in in_doubt else own_n for k, own_n in enumerate(now.forces_n)]
        usual = min(max(self._usual.value, LEAST_USUAL), MOST_USUAL)
        rest_mps2 = usual * self._nominal.all_mps2(forces_n, now.mass_kg)
        unseen_n = [as_if_n if k in in_doubt else 0.0 for k in range(len(forces_n))]
        expected_mps2 = usual * self._nominal.all_mps2(unseen_n, now.mass_kg)
        by_brakes_mps2 = self._retardation.by_brakes_mps2
        if by_brakes_mps2 is None or self._retardation.is_pulled:
            return None
        std_mps2 = hypot(LINE_STD_MPS2, MOTORS_ERR * self._retardation.by_motors_mps2)
        if rest_mps2 > GREATEST_REST * expected_mps2:
            std_mps2 = hypot(std_mps2, FRICTION_STD * rest_mps2)
        return ShownShare((by_brakes_mps2 - rest_mps2) / expected_mps2, std_mps2 / expected_mps2)
