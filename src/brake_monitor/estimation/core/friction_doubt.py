"""What friction may have learned that is something else's: how far it is widened, and by what it comes back.

While pads press with forces that stand still, no reading tells friction from d (`observability` shows the direction).
What comes unforeseen may be the line's, the pads' or a sensor's: what each of them does, and how quickly, decides.
"""

from math import inf

from brake_monitor.estimation.core.core_numbers import LINE_CHANGE_MPS2, CoreNumbers
from brake_monitor.estimation.core.regime_watch import PULL_ENDS_S
from brake_monitor.estimation.doubts.consistency import BIASED, UNEXPLAINED
from brake_monitor.estimation.model.wheelset import braking_ratio

STRAYS_SIGMAS = 1.5  # of the pads' mean friction, as it was known when the brake application began: off by more, ...
FAR_SIGMAS = 3.0  # ... by this, it is far off; ...
BACK_SIGMAS = 1.0  # ... and so near it has come back
STRAYS_S = 0.5  # ... for so long, it has strayed, or does no more: as a brake comes on, its timing lets it come and go
NO_PADS = 0.75  # of their friction: no pads, oily or glazed, rub by so much less or more ...
DRY_AGAIN_S = 10.0  # ... for longer than wet or snowy ones take to dry
LINE_M = 1000.0  # within so long a way lines change, ...
LARGEST_LINE_CHANGE_MPS2 = 0.15  # ... hardly ever by 15 per mille at once while the brake is on
LEAST_PER_FRICTION_MPS2 = 1e-3  # d per unit of friction of a brake that hardly presses any more, to divide by
MISTIMED_FRICTION_STD = 0.04  # of friction learned from inputs that were out of step, scattered or stood still


class FrictionDoubt(CoreNumbers):
    """What is done to friction, and to d beside it, with each reading of the vehicle's speed while pads press."""

    __slots__ = ()

    def judge_friction(self, speed_is_doubtful: bool) -> None:
        """Widen friction by what a changing line, or inputs that were in doubt, may have taught it wrongly."""
        now = self.now
        doubted = self.tuning.friction_doubted * self.readings[self.wheelset_count].spacing_s
        if self.tuning.friction_doubted > 0.0:
            if now.any_friction_observable:
                self.see_strayed_friction()
                self.see_impossible_friction()
            self.see_friction_come_back()
        if self.friction_comes_back():
            self.doubt_friction_alone(doubted)
        elif speed_is_doubtful and not self.is_deceleration_unknown():
            self.doubt_friction(doubted)
        elif now.any_friction_observable:
            std = MISTIMED_FRICTION_STD * now.consistency.taught_wrongly(now.time_s)
            if std > 0.0:
                now.consistency.deal_with_doubts(now.time_s)
                self.doubt_friction(std * std)
                self.doubt_each_friction(std * std)

    def see_strayed_friction(self) -> None:
        """Widen friction, once in a brake application, if it has strayed: the line may have changed as it began.

        A driver who holds a train's speed puts the brake on where a descent begins and lets go where it ends. What mean
        friction has strayed by may then be the gradient's, up to LINE_CHANGE_MPS2 of d.
        """
        applied, time_s = self.now.application, self.now.time_s
        if applied.line_friction_std > 0.0:
            return
        strayed = self.strayed_friction(STRAYS_SIGMAS)
        if strayed == 0.0:
            applied.strays_s = inf
            return
        applied.strays_s = min(applied.strays_s, time_s)
        if time_s - applied.strays_s < STRAYS_S:
            return
        per_friction_mps2 = max(abs(self.point_friction_against_line()), LEAST_PER_FRICTION_MPS2)
        applied.line_friction_std = min(abs(strayed), LINE_CHANGE_MPS2 / per_friction_mps2)
        line_variance = applied.line_friction_std * applied.line_friction_std
        applied.line_friction_share = line_variance / (line_variance + self.mean_friction_variance())
        self.doubt_friction(line_variance)

    def see_impossible_friction(self) -> None:
        """Learn that the pads rub as they did, once their friction has been too far off that for too long.

        Then d has what it had strayed by: the line has changed, under a driver whose brake went along with it.
        """
        now, applied = self.now, self.now.application
        off = abs(self.mean_friction() - applied.friction)
        if off <= NO_PADS * applied.friction or now.has_slid or not applied.friction_is_doubted:
            applied.impossible_s = inf
            return
        applied.impossible_s = min(applied.impossible_s, now.time_s)
        if now.time_s - applied.impossible_s < DRY_AGAIN_S:
            return
        applied.impossible_s = inf
        self.doubt_friction(off * off)  # what has led it there tells nothing
        for i in range(self.wheelset_count):
            self.filter.learn(
                self.friction_place + i, applied.friction, self.wheelset_count * applied.friction_variance
            )

    def strayed_friction(self, sigmas: float) -> float:
        """By how much friction is off what was known of it as the brake application began; 0 within so many sigmas."""
        applied = self.now.application
        strayed = self.mean_friction() - applied.friction
        return strayed if strayed * strayed > sigmas * sigmas * applied.friction_variance else 0.0

    def see_friction_come_back(self) -> None:
        """Follow whether friction that has strayed comes back, as that of wet or snowy pads does within seconds.

        So it is if the speed contradicts the model as it would then: lines hardly change as quickly, and just so. d
        gives back what it has taken of it.
        """
        now, applied = self.now, self.now.application
        if applied.back_from == 0.0:
            if now.any_friction_observable and self.is_more_than_a_line() and self.is_friction_on_its_way():
                applied.back_from, applied.away_s = self.strayed_friction(STRAYS_SIGMAS), now.time_s
                self.give_back_to_friction(applied.back_from)
            return
        if applied.back_from * self.strayed_friction(STRAYS_SIGMAS) > 0.0:
            applied.away_s = now.time_s
        if not now.consistency.is_on(BIASED, now.time_s) or now.time_s - applied.away_s >= STRAYS_S:
            applied.back_from = 0.0

    def is_friction_on_its_way(self) -> bool:
        """Whether the speed contradicts the model as friction would that comes back, or d has followed one far off."""
        now = self.now
        if self.strayed_friction(STRAYS_SIGMAS) * now.consistency.bias.doubtful_sigmas > 0.0:
            return True
        strayed_mps2 = self.filter.x[self.deceleration_place] - now.application.line_mps2
        follows = abs(strayed_mps2) > LINE_CHANGE_MPS2 and self.strayed_friction(FAR_SIGMAS) * strayed_mps2 < 0.0
        return follows and not now.consistency.is_on(UNEXPLAINED, now.time_s)

    def is_more_than_a_line(self) -> bool:
        """Whether friction that comes back moves the wagon by more than lines do: of a light brake none can tell."""
        strayed_mps2 = self.strayed_friction(STRAYS_SIGMAS) * self.point_friction_against_line()
        return abs(strayed_mps2) > LINE_CHANGE_MPS2

    def give_back_to_friction(self, strayed: float) -> None:
        """Learn that d is the line's; all of it where d has taken a part of what friction has strayed by.

        A d that has taken what friction would give, gives no more than that, or than lines change by at once.
        """
        place = self.deceleration_place
        unmodelled_mps2 = self.filter.x[place]
        returned_mps2 = unmodelled_mps2 - strayed * self.point_friction_against_line()
        least_mps2 = min(unmodelled_mps2 - LINE_CHANGE_MPS2, returned_mps2)
        most_mps2 = max(unmodelled_mps2 + LINE_CHANGE_MPS2, returned_mps2)
        line_mps2 = self.now.application.line_mps2
        if strayed * (unmodelled_mps2 - line_mps2) < 0.0:
            line_mps2 = min(max(line_mps2, least_mps2), most_mps2)
        self.filter.learn(place, line_mps2, LINE_CHANGE_MPS2 * LINE_CHANGE_MPS2)

    def see_line_change(self) -> None:
        """Follow the part of d that the line can have made, while braking only as fast as lines change; doubt any more.

        Pressing forces that stand still, and brakes of which nothing is told, drive d as a changing line would. So do
        brakes that press on when all forces are told to be gone at once, as no air goes.
        """
        now, applied, unmodelled_mps2 = self.now, self.now.application, self.filter.x[self.deceleration_place]
        passed_m, applied.line_m = now.distance_m - applied.line_m, now.distance_m
        strayed_mps2 = unmodelled_mps2 - applied.line_mps2
        pull_may_end = applied.pull_variance > 0.0 and now.time_s - applied.began_s < PULL_ENDS_S
        variance = self.filter.covariance[self.deceleration_place][self.deceleration_place]
        is_known = variance < LINE_CHANGE_MPS2 * LINE_CHANGE_MPS2 or not now.consistency.is_on(BIASED, now.time_s)
        is_released = not (now.pressed or applied.ends_at_once)
        if pull_may_end or (is_known and is_released):
            if abs(unmodelled_mps2) <= self.largest_deceleration_mps2:
                applied.line_mps2 = unmodelled_mps2
        elif abs(strayed_mps2) <= LARGEST_LINE_CHANGE_MPS2:
            applied.line_mps2 += min(passed_m / LINE_M, 1.0) * strayed_mps2
        now.consistency.see_deceleration(now.time_s, unmodelled_mps2 - applied.line_mps2, LARGEST_LINE_CHANGE_MPS2)

    def hold_on_to_unexplained(self) -> None:
        """Doubt on, while the brake is, as long as friction strays that has strayed while d was more than a line's.

        A d that is back within what lines do is no news then: friction may have taken the rest of it. In slides forces
        fall and rise, and tell friction from the line.
        """
        now = self.now
        if now.has_slid and self.knows_friction():
            return
        is_unexplained = now.pressed and now.consistency.is_on(UNEXPLAINED, now.time_s)
        if is_unexplained and now.application.line_friction_std > 0.0 and self.strayed_friction(BACK_SIGMAS) != 0.0:
            now.consistency.raised_s[UNEXPLAINED] = now.time_s

    def doubt_friction(self, variance: float) -> None:
        """Widen friction, with mu_w and d, in the direction in which no reading tells them apart (`observability`).

        While the forces do not change, more friction with a smaller d leaves all speeds as they are.
        """
        self.now.application.friction_is_doubted = True
        self.point_friction_against_line()
        self.filter.admit_along(variance)

    def doubt_friction_alone(self, variance: float) -> None:
        """Widen friction, with the mu_w it asks for, and not d: it is friction that changes now."""
        self.now.application.friction_is_doubted = True
        self.point_friction_against_line()
        self.filter.direction[self.deceleration_place] = 0.0
        self.filter.admit_along(variance)

    def point_friction_against_line(self) -> float:
        """Point `direction` to more friction, the mu_w it asks for, and the d that leaves v̇ as it is; that d."""
        n, unmodelled_mps2 = self.wheelset_count, 0.0
        for i in range(n):
            unmodelled_mps2 -= self.point_friction(i, 1.0) * self.wheels[i].wheel_load_n / self.now.mass_kg
        self.filter.direction[self.deceleration_place] = unmodelled_mps2
        return unmodelled_mps2

    def doubt_each_friction(self, variance: float) -> None:
        """Widen the friction of each wheelset by itself, with the mu_w that it asks for."""
        n = self.wheelset_count
        self.filter.direction[self.deceleration_place] = 0.0
        for k in range(n):
            for i in range(n):
                self.point_friction(i, 1.0 if i == k else 0.0)
            self.filter.admit_along(variance)

    def point_friction(self, i: int, friction: float) -> float:
        """Set mu_b,i of `direction`, 0 if not observable, and the mu_w,i that it asks for; returns that."""
        wheel = self.wheels[i]
        shows = friction * wheel.friction_observable
        asked = shows * braking_ratio(wheel, wheel.force.value, wheel.wheel_load_n)
        self.filter.direction[self.friction_place + i] = shows
        self.filter.direction[self.adhesion_place + i] = asked
        return asked
