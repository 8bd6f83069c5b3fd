"""What a wheelset that turns does, by what is seen of the wagon: it rolls, slides, or turns as nothing can make it."""

from collections import deque
from math import inf

from brake_monitor.estimation.brake_work import SLIDING_SLIP
from brake_monitor.estimation.estimate import Estimate, WheelsetEstimate
from brake_monitor.monitoring.inputs.holding_force import HoldingForce
from brake_monitor.monitoring.inputs.odd_turning import UNSEEN_SLIP, OddTurning
from brake_monitor.monitoring.inputs.speed_bursts import SpeedBursts
from brake_monitor.monitoring.inputs.wheel_state import WheelState

WATCHED_FROM_MPS = 1.39  # 5 km/h, below it speed sensors cut out
ROLLING_SLIP = 0.03
SLIDING_MPS = 0.5  # below it a speed sensor that lags looks the same
SLIDES_IN_A_ROW = 3  # observations; noise alone does not slide as long
HARDEST_RETARDATION_MPS2 = 2.0  # no wagon retards as much; a wheelset that begins to slide slows down far quicker
FALL_SPAN_S = 0.35  # three observations, and what times are rounded by
LEAST_FALL_SPAN_S = 0.15
FALL_BEFORE_S = 1.0  # before its slip shows
FAR_MPS = 2.5  # more than a vehicle speed that lags by 1.5 s makes up
RELEASED_S = 3.0  # after the last braking or driving a wheelset may still slide or spin for so long


class Turning:
    """Sees one wheelset at each observation in which it turns."""

    def __init__(self, holding: HoldingForce, bursts: SpeedBursts) -> None:
        """What its readings tell: what may hold or drive it, and its bursts."""
        self._holding = holding
        self._bursts = bursts
        self.odd = OddTurning()
        self._has_rolled = False
        self._rolled_s = -inf
        self._slides = 0  # observations in a row
        self._lately: deque[tuple[float, float]] = deque()  # of the last FALL_SPAN_S, time and speed of its tread
        self._fell_s = -inf  # when it last slowed down as no rolling one does

    def judge(
        self, now: Estimate, own: WheelsetEstimate, rolling_mps: float, *, demanded: bool, all_slip_alike: bool
    ) -> WheelState:
        """What it does, by its last reading as the speed of its tread; `all_slip_alike`: none of the wagon's rolls."""
        slip, speed_mps = own.slip, now.speed_mps
        self._see_fall(now.time_s, rolling_mps)
        if self._is_odd(now, rolling_mps, demanded=demanded) or self._bursts.is_on(now.time_s):
            self._slides = 0
            return WheelState.CONTRADICTED
        if abs(slip) < ROLLING_SLIP and speed_mps > WATCHED_FROM_MPS:
            self._has_rolled, self._rolled_s = True, now.time_s
        needed = ROLLING_SLIP if own.wsp_active else SLIDING_SLIP if self._has_rolled else UNSEEN_SLIP
        slides = demanded and slip > needed and slip * speed_mps > SLIDING_MPS
        slides = slides and (not all_slip_alike or own.wsp_active or self._may_slide(slip * speed_mps))
        self._slides = self._slides + 1 if slides else 0
        if self._slides >= SLIDES_IN_A_ROW:
            return WheelState.SLIDING
        is_protected = demanded and own.is_protected and self._has_rolled
        return WheelState.PROTECTED if is_protected else WheelState.ROLLING

    def was_left_by(self, speed_mps: float, rolling_mps: float) -> bool:
        """Whether it rolled with the vehicle, and does not by what the vehicle's speed says now."""
        return self._has_rolled and abs(rolling_mps - speed_mps) > UNSEEN_SLIP * speed_mps

    def _see_fall(self, time_s: float, rolling_mps: float) -> None:
        lately = self._lately
        lately.append((time_s, rolling_mps))
        while not 0.0 <= time_s - lately[0][0] <= FALL_SPAN_S:
            lately.popleft()
        from_s, from_mps = lately[0]
        if time_s < self._fell_s:  # the clock was set back
            self._fell_s = -inf
        if from_mps - rolling_mps > HARDEST_RETARDATION_MPS2 * max(time_s - from_s, LEAST_FALL_SPAN_S):
            self._fell_s = time_s

    def _may_slide(self, slip_mps: float) -> bool:
        """Whether it is not the vehicle's speed that lags behind its wheelsets', which all slow down as it does."""
        return not self._has_rolled or slip_mps > FAR_MPS or self._fell_s > self._rolled_s - FALL_BEFORE_S

    def _is_odd(self, now: Estimate, rolling_mps: float, *, demanded: bool) -> bool:
        """Whether its readings say that it turns as nothing can make it turn."""
        slip = 1.0 - rolling_mps / max(now.speed_mps, WATCHED_FROM_MPS)
        is_driven = abs(now.time_s - self._holding.driven_s) < RELEASED_S  # a delay_s makes the estimate's time earlier
        return self.odd.see(now.time_s, slip, now.speed_mps, is_moved=is_driven if slip < 0.0 else demanded)
