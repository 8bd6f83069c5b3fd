"""Whether the flags of the wheel-slide protection say anything: one that stays set over a rolling wheelset does not.

A flag that is stuck would excuse every brake for ever: what does not press might be released by its protection, and
what drags might be about to slide. But no protection acts on a brake that is released, and none that acts leaves slip
and pressing force alone for a minute.
"""

from collections.abc import Iterable, Sequence

from brake_monitor.estimation.brake_work import SLIDING_SLIP
from brake_monitor.estimation.estimate import Estimate, WheelsetEstimate
from brake_monitor.monitoring.passing_time import Steps
from brake_monitor.samples import Channel, Quantity

STUCK_S = 10.0  # so long without any brake, longer than a flag outlasts its slide
BRAKED_SHARE = 1.0 / 6.0  # a second under a steady brake counts for so much: some flags stay set until the release
STEADY = 0.1  # of the pressing force
STEADY_N = 1000.0
WATCHED_FROM_MPS = 3.0  # slower, and at standstill, slip shows nothing and valves are tested


class FlagWatch:
    """Sees every sample, and the wagon at each observation."""

    def __init__(self, channels: Iterable[Channel], wheelset_count: int, contact_force_n: float) -> None:
        mapped = [channel.wheelset for channel in channels if channel.quantity is Quantity.WSP_ACTIVE]
        told_of = {i: (i,) for i in mapped} if len(mapped) > 1 else {0: tuple(range(wheelset_count))}
        self.flags = {i: Flag(told_of[i], contact_force_n) for i in mapped}
        self.watchers = {(Quantity.WSP_ACTIVE, i): flag.see for i, flag in self.flags.items()}
        self._steps = Steps()

    def judge(self, now: Estimate, measured: Sequence[bool]) -> frozenset[int]:
        """The wheelsets whose flags are stuck; `measured`: of which wheelsets speeds and pressing force are good."""
        step_s = self._steps.until(now.time_s)
        return frozenset([i for i, flag in self.flags.items() if flag.judge(now, measured, step_s)])


class Flag:
    """One flag, and since when it has been set over wheelsets that roll."""

    def __init__(self, wheelsets: tuple[int, ...], contact_force_n: float) -> None:
        self._wheelsets = wheelsets  # those that it tells of
        self._contact_force_n = contact_force_n
        self._forces_n = dict.fromkeys(wheelsets, 0.0)  # at the beginning of what is steady
        self._rolled_s = 0.0
        self.is_set = False

    def see(self, _: float, value: float) -> None:
        """Take a sample."""
        self.is_set = value != 0.0

    def judge(self, now: Estimate, measured: Sequence[bool], step_s: float) -> bool:
        """Go on by one observation; whether it has been set over wheelsets that roll for too long, until it falls."""
        if not self.is_set:
            self._rolled_s = 0.0
        elif self._rolled_s < STUCK_S and now.speed_mps >= WATCHED_FROM_MPS:
            self._go_on(now, measured, step_s)
        return self._rolled_s >= STUCK_S

    def _go_on(self, now: Estimate, measured: Sequence[bool], step_s: float) -> None:
        own = {i: now.wheelsets[i] for i in self._wheelsets}
        if all(measured[i] and self._is_left_alone(i, wheelset) for i, wheelset in own.items()):
            braked = any(wheelset.pressing_force_n >= self._contact_force_n for wheelset in own.values())
            self._rolled_s += step_s * (BRAKED_SHARE if braked else 1.0)
        else:
            self._rolled_s = 0.0
            self._forces_n = {i: wheelset.pressing_force_n for i, wheelset in own.items()}

    def _is_left_alone(self, i: int, own: WheelsetEstimate) -> bool:
        """Whether the wheelset rolls and its brake does not move."""
        moved_n = abs(own.pressing_force_n - self._forces_n[i])
        return abs(own.slip) < SLIDING_SLIP and moved_n <= STEADY_N + STEADY * self._forces_n[i]
