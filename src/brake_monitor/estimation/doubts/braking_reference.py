"""What d and friction were at a moment of steady braking, against which they are compared later in it."""

from math import inf

STEADY = 0.1  # brakes that press with so much more or less than they did do not brake steadily
GAP_S = 0.5  # without a comparison for longer, the moment is of another braking


class BrakingReference:
    """The moment when steady braking began, or one some seconds ago."""

    def __init__(self, lasts_s: float) -> None:
        """`lasts_s`: after as long, another moment takes its place."""
        self.lasts_s = lasts_s
        self.began_s = -inf
        self.compared_s = -inf  # when it was last compared
        self.per_friction_mps2 = 0.0  # what the brakes gave per unit of friction
        self.friction = 0.0  # mean of the pads, by what each of them gave
        self.unmodelled_mps2 = 0.0  # d
        self.known_variance = 0.0  # (m/s²)², of what both gave together, ...
        self.variance = 0.0  # ... and of what that may have changed by since
        self.doubted = 0.0  # `BrakeApplication.doubted` then

    def holds(self, time_s: float, per_friction_mps2: float) -> bool:
        """Whether it may be compared with: it is young, of this braking, and the brakes press as they did.

        Not from before it was last compared: the clock was set back.
        """
        is_steady = abs(per_friction_mps2 - self.per_friction_mps2) <= STEADY * self.per_friction_mps2
        return is_steady and time_s < self.began_s + self.lasts_s and 0.0 <= time_s - self.compared_s < GAP_S

    def change_mps2(self, friction: float, unmodelled_mps2: float, per_friction_mps2: float) -> float:
        """By how much more d and friction slow down the wagon now, with what the brakes give now."""
        return unmodelled_mps2 - self.unmodelled_mps2 + per_friction_mps2 * (friction - self.friction)
