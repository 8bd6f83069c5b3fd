"""A pressing force that stands still while its wheelset slides on: its sensor, not its brake.

A sensor that says the same to the last bit is dead. One that only trembles, slide after slide, measures the air before
the valves of the slide protection, not what they leave in the cylinder; once or twice it may be the rail that changes.

Slide protection holds a brake until the wheelset has found back to rolling; to slide anew the wheelset must be braked
anew. So slip that grows again while the measured force stands still is due to a force that is not measured. Slip that
has just begun to grow proves nothing: a steady brake may come upon a slippery rail, and a valve needs its time.
"""

from math import inf

STILL = 0.01  # of the pressing force: no slide protection works with less
TREMBLES_FOR = 3  # slides anew until a force that only trembles is not believed any more
SLIDES = 0.02  # slip from which on something ought to move the force
RENEWED_SLIP = 0.05  # by which slip falls and grows again on a rail that changes, and more
UNBRAKED_SLIP = 0.02  # ... where nothing seems to press: there it only falls
RENEWED_MPS = 0.5  # ... and in any case more than a vehicle speed that lags makes up
HELD_S = 0.1  # slip must have grown, or fallen, for this long
ROLLED_S = 2.0  # without slip for so long, the next slide is another one
STANDS_S = 1.0  # the force must have stood still since the wheelset slid first ...
CUT_OUT_SLIP = 0.9  # a wheelset that slips so much from one reading to the next has not: its speed's sensor says 0
STANDS_READINGS = 10  # ... and over this many readings: one that is told slowly may have moved between two of them


class StillForce:
    """Counts how often a wheelset begins to slide anew at the same pressing force."""

    def __init__(self) -> None:
        self.renewals = 0  # how often the wheelset has slid anew at the present value of the force
        self._value = -inf
        self._trembles = False  # the force has not been quite the same since
        self._first_slid_s = inf  # when the wheelset slid first at this value; inf: it has not
        self._repeated = 0  # readings of the force since then
        self._last_slid_s = inf  # when the wheelset slid last, at any value
        self._turns_s = inf  # since when slip has grown where it fell before, or the other way round
        self._turned = 0.0  # slip at its last turning point
        self._grows = False  # slip does, since then
        self._slips = False  # it did at the last reading
        self._is_cut_out = False  # the sensor of the wheel speed is

    def see(self, time_s: float, pressing_force_n: float, slip: float, speed_mps: float) -> bool:
        """Take force, slip and vehicle speed; True as the wheelset slides anew at a force not to be believed."""
        if moves(self._value, pressing_force_n) or time_s < self._last_slid_s < inf:  # or the clock was set back
            self._value, self._trembles = pressing_force_n, False
            self._await_slide()
        self._trembles = self._trembles or pressing_force_n != self._value
        slip = max(slip, 0.0)  # a wheelset that spins under its motor and finds back is not braked
        self._is_cut_out = slip > CUT_OUT_SLIP and (self._is_cut_out or not self._slips)
        self._slips = slip > SLIDES
        if self._is_cut_out:
            return False
        if slip > SLIDES:
            self._last_slid_s = time_s
        elif time_s - self._last_slid_s > ROLLED_S:
            self._await_slide()
        if self._first_slid_s == inf:
            if slip > SLIDES:
                self._first_slid_s, self._turned, self._grows, self._turns_s = time_s, slip, True, inf
            return False
        self._repeated += 1
        swing = max(RENEWED_SLIP if pressing_force_n > 0.0 else UNBRAKED_SLIP, RENEWED_MPS / max(speed_mps, 1.0))
        if not self._see_turn(time_s, slip, swing) or not self._grows:
            return False
        if self._repeated < STANDS_READINGS or time_s - self._first_slid_s < STANDS_S:
            return False
        self.renewals += 1
        return not self._trembles or self.renewals >= TREMBLES_FOR

    def _await_slide(self) -> None:
        """Begin anew: the next slide is the first one."""
        self._first_slid_s, self._repeated, self.renewals = inf, 0, 0

    def _see_turn(self, time_s: float, slip: float, swing: float) -> bool:
        """Take slip; whether, having fallen, it has now grown by `swing` for HELD_S, or the other way round."""
        self._turned = max(self._turned, slip) if self._grows else min(self._turned, slip)
        if abs(slip - self._turned) <= swing:
            self._turns_s = inf
            return False
        self._turns_s = min(self._turns_s, time_s)
        if time_s - self._turns_s < HELD_S:
            return False
        self._turned, self._grows, self._turns_s = slip, not self._grows, inf
        return True


def moves(before_n: float, now_n: float) -> bool:
    """Whether a pressing force has changed by more than STILL of itself, or at all from 0."""
    return abs(now_n - before_n) > STILL * before_n
