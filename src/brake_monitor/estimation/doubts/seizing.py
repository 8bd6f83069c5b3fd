"""Whether a wheelset is stopped by more than its brake and its motor: by a bearing that seizes, or pads that stick.

A rail turns what slides. Where a wheelset loses its speed as if its rail stopped it, something else does.
"""

from math import inf

from brake_monitor.estimation.brake_work import SLIDING_SLIP

LEAST_ADHESION = 0.02  # below 0, of a wheelset that slides: pressing forces may come late ...
SIGMAS = 4.0  # ... and the estimate may be off
SEIZING_S = 0.1  # for so long: a spike of a wheel speed may be believed for a reading


class Seizing:
    """Sees one wheelset whose torque and speed are known."""

    def __init__(self) -> None:
        self.is_on = False
        self._since_s = inf  # it seems so; inf: it does not

    def see(self, time_s: float, slip: float, adhesion: float, adhesion_std: float) -> bool:
        """Take slip and adhesion; whether it seizes, from now on until it `rolls`."""
        if slip > SLIDING_SLIP and adhesion < -max(LEAST_ADHESION, SIGMAS * adhesion_std):
            self._since_s = min(self._since_s, time_s)
        else:
            self._since_s = inf
        self.is_on = time_s - self._since_s >= SEIZING_S
        return self.is_on

    def rolls(self) -> None:
        """Note that it rolls."""
        self.is_on, self._since_s = False, inf
