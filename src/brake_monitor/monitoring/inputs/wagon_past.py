"""How speed and brakes of the wagon were in the last seconds: whether it retards as if a wheelset dragged."""

from collections import deque

from brake_monitor.estimation.estimate import Estimate
from brake_monitor.monitoring.inputs.retardation import mean_retardation_mps2
from brake_monitor.settings.config import Vehicle

WAIT_S = 1.3  # until a wheelset that stands is judged by its drag ...
FALLING_S = 0.3  # ... of which the time of the fall itself says nothing
BEFORE_S = 2.0
PAST_S = BEFORE_S + WAIT_S + 1.0
DRAG_MPS2 = 0.15  # rise of the retardation at the fall
FORCE_ROSE_N = 4000.0  # then the retardation may be the brakes'


class WagonPast:
    """Sees the wagon at each observation. Retardations are means in m/s², None where they cannot be told."""

    def __init__(self, vehicle: Vehicle, contact_force_n: float) -> None:
        self._vehicle = vehicle
        self._contact_force_n = contact_force_n
        self._past: deque[tuple[float, float, float]] = deque()  # time, speed, and force of all brakes and motors

    def note(self, now: Estimate, forces_n: float) -> None:
        """Take an observation, and with how much all brakes and motors press."""
        past = self._past
        past.append((now.time_s, now.speed_mps, forces_n))
        while not 0.0 <= now.time_s - past[0][0] <= PAST_S:
            past.popleft()

    def retardation_mps2(self, from_s: float, to_s: float) -> float | None:
        """All of it."""
        span = [(time_s, speed_mps) for time_s, speed_mps, _ in self._past if from_s <= time_s <= to_s]
        return mean_retardation_mps2([time_s for time_s, _ in span], [speed_mps for _, speed_mps in span])

    def unbraked_mps2(self, now: Estimate) -> float | None:
        """By how much the wagon retards with no pad pressing, beyond what the track takes; None while one presses."""
        forces_n = [force_n for time_s, _, force_n in self._past if time_s >= now.time_s - WAIT_S]
        retardation_mps2 = self.retardation_mps2(now.time_s - WAIT_S, now.time_s)
        if retardation_mps2 is None or max(forces_n) > self._contact_force_n:
            return None
        return retardation_mps2 - self._vehicle.resistance_n(now.speed_mps) / now.mass_kg

    def drags_since(self, fell_s: float, time_s: float) -> bool:
        """Whether the wagon retards more since a wheelset fell, although the pads do not press more."""
        before = self.retardation_mps2(fell_s - BEFORE_S, fell_s)
        after = self.retardation_mps2(fell_s + FALLING_S, time_s)
        if before is None or after is None:
            return False
        forces_before = [force_n for past_s, _, force_n in self._past if fell_s - BEFORE_S <= past_s < fell_s]
        forces_after = [force_n for past_s, _, force_n in self._past if past_s >= fell_s]
        rose = max(forces_after) > sum(forces_before) / len(forces_before) + FORCE_ROSE_N
        return not rose and after - before > DRAG_MPS2
