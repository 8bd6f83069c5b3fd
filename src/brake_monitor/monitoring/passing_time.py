"""How time passes from one observation to the next: it may go back, or on by so much that nobody knows what was."""

from math import inf

from brake_monitor.estimation.estimate import LONGEST_STEP_S


class LastTime:
    """When a condition held last. As time goes back it is taken to hold: what waits for it to be over waits anew."""

    def __init__(self, time_s: float = -inf) -> None:
        """`time_s`: inf where it may have held until now."""
        self.time_s = time_s

    def see(self, time_s: float, holds: bool) -> None:
        """Take whether it holds now."""
        if holds or self.time_s > time_s:
            self.time_s = time_s


class Steps:
    """The time between observations that counts: none as time goes back, or has gone on by too much."""

    def __init__(self) -> None:
        self._before_s = -inf

    def until(self, time_s: float) -> float:
        """From the observation before to this one."""
        step_s, self._before_s = time_s - self._before_s, time_s
        return step_s if 0.0 <= step_s <= LONGEST_STEP_S else 0.0
