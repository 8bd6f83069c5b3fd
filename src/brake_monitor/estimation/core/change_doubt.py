"""The doubt that a change in steady braking leaves: whether it is the line's or the pads'.

While pressing forces stand still the speeds tell what d and friction give together, and soon well, but not which of
them gives it. When that changes by more than both are believed to wander by, as on a line that ends at a crest or with
discs that dry, the filter lets each have the share that its variance had. All of it may be the one's, or the other's.
"""

from brake_monitor.estimation.core.friction_doubt import LEAST_PER_FRICTION_MPS2, FrictionDoubt
from brake_monitor.estimation.doubts.braking_reference import BrakingReference
from brake_monitor.estimation.doubts.consistency import BIASED

CHANGE_SIGMAS = 3.0  # of what may have changed while all is as believed
KNOWN_MPS2 = 0.025  # standard deviation of what is given: from then on it is compared
KNOWN_BETTER = 3.0  # by that, of the variance, what is given now is a better reference
CHANGING_PADS = 0.06  # of friction: by as much it changes within a stop, as pads get hot or the wagon slows down ...
LEAST_SHARE = 0.001  # ... and by so much at least it is widened
MISPLACED = 0.5  # of a change, as a standard deviation: between none and all of it is where it does not belong


class ChangeDoubt(FrictionDoubt):
    """Widens friction against d where the deceleration of steady braking has changed."""

    __slots__ = ()

    def see_changes(self) -> None:
        """Compare what d and friction give with what they gave within the last seconds.

        In slides friction is learned, and while the speed contradicts the model it is in doubt anyway.
        """
        now, per_friction_mps2 = self.now, -self.point_friction_against_line()
        if per_friction_mps2 < LEAST_PER_FRICTION_MPS2:
            return
        self.see_followed(per_friction_mps2)
        if now.has_slid or self.friction_comes_back() or now.consistency.is_on(BIASED, now.time_s):
            return
        friction = 0.0
        for i in range(self.wheelset_count):
            friction += self.share_of_friction(i) / per_friction_mps2 * self.filter.x[self.friction_place + i]
        variance = self.given_variance()
        if variance > KNOWN_MPS2 * KNOWN_MPS2:  # what nominal friction is wrong by is no change
            return
        self.compare(now.application.lately, friction, per_friction_mps2, variance)
        self.compare(now.application.longer_ago, friction, per_friction_mps2, variance)

    def see_followed(self, per_friction_mps2: float) -> None:
        """Widen friction against d where forces have made up for something: it may be pads that fade, not the line.

        `direction` points so.
        """
        applied, friction = self.now.application, self.mean_friction()
        followed = MISPLACED * abs(self.now.force_trend.followed_mps2) / (per_friction_mps2 * friction)
        share = min(followed, CHANGING_PADS)
        if share < applied.followed + LEAST_SHARE:
            return
        self.filter.admit_along((share * share - applied.followed * applied.followed) * friction * friction)
        applied.followed = share

    def compare(
        self, reference: BrakingReference, friction: float, per_friction_mps2: float, given_variance: float
    ) -> None:
        """Doubt a change since the reference that is more than d and friction may have wandered by.

        What any line is expected to change by on the way does not count: as much, within seconds, may be the pads'.
        """
        now, unmodelled_mps2 = self.now, self.filter.x[self.deceleration_place]
        is_better_known = KNOWN_BETTER * given_variance < reference.known_variance
        if is_better_known or not reference.holds(now.time_s, per_friction_mps2):
            reference.began_s = reference.compared_s = now.time_s
            reference.friction, reference.unmodelled_mps2 = friction, unmodelled_mps2
            reference.per_friction_mps2, reference.doubted = per_friction_mps2, now.application.doubted
            reference.known_variance = reference.variance = given_variance
            return
        friction_density = self.tuning.friction + self.tuning.friction_own / self.wheelset_count
        density = (
            now.deceleration_density - now.following_density + friction_density * per_friction_mps2 * per_friction_mps2
        )
        reference.variance += density * (now.time_s - reference.compared_s)
        reference.compared_s = now.time_s
        change_mps2 = reference.change_mps2(friction, unmodelled_mps2, per_friction_mps2)
        if change_mps2 * change_mps2 > CHANGE_SIGMAS * CHANGE_SIGMAS * reference.variance:
            self.doubt_change(reference, change_mps2 / per_friction_mps2)

    def doubt_change(self, reference: BrakingReference, friction: float) -> None:
        """Widen friction, and d against it, by a change that is as much as so much friction; by each change once."""
        applied, misplaced = self.now.application, MISPLACED * friction
        variance = misplaced * misplaced - (applied.doubted - reference.doubted)
        if variance > 0.0:
            applied.doubted += variance
            self.doubt_friction(variance)

    def share_of_friction(self, i: int) -> float:
        """What mu_b,i gives of the wagon's deceleration per unit, m/s², by the `direction` of friction."""
        asked = self.filter.direction[self.adhesion_place + i]
        return asked * self.wheels[i].wheel_load_n / self.now.mass_kg

    def given_variance(self) -> float:
        """The variance of what d and friction give together, (m/s²)²."""
        covariance, place, n = self.filter.covariance, self.deceleration_place, self.wheelset_count
        variance = covariance[place][place]
        for i in range(n):
            row, share = covariance[self.friction_place + i], self.share_of_friction(i)
            variance += 2.0 * share * row[place]
            for j in range(n):
                variance += share * self.share_of_friction(j) * row[self.friction_place + j]
        return variance
