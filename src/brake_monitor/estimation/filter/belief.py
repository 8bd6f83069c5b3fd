"""What a filter believes, x and P, and what is done to single states beside predictions and corrections."""

from math import exp, inf

from brake_monitor.estimation.kalman.ekf import Matrix, Vector
from brake_monitor.estimation.model.regime import SLOW_ADHESION_DENSITY, SLOW_ADHESION_S, SLOW_SPEED_DENSITY


class Belief:
    """x and P. Written as loops over numbers that stay in their places, which run compiled as they stand."""

    speed_place: int  # of v in x, after as many omega_i as there are mu_w,i
    adhesion_place: int  # of the first mu_w,i
    adhesion_std: float  # of these as known beforehand
    x: Vector  # n numbers
    covariance: Matrix  # P, n rows of n numbers
    direction: Vector  # n numbers, see `admit_along`
    saved: Matrix  # snapshots: x and P row by row, n + n * n numbers each; `WagonMoment` says of when

    def forget(self, place: int, value: float, std: float) -> None:
        """Set a state to this value and standard deviation, without covariances to other states."""
        self.x[place] = value
        for k in range(len(self.x)):
            self.covariance[place][k] = self.covariance[k][place] = 0.0
        self.covariance[place][place] = std * std

    def scale(self, place: int, factor: float, about: float) -> None:
        """Multiply a state's distance from `about` by a known factor."""
        self.x[place] = about + factor * (self.x[place] - about)
        self.scale_error(place, factor)

    def scale_error(self, place: int, factor: float) -> None:
        """Multiply what a state is off by with a known factor."""
        for k in range(len(self.x)):
            self.covariance[place][k] *= factor
        for k in range(len(self.x)):
            self.covariance[k][place] *= factor

    def widen(self, place: int, variance: float) -> None:
        """Admit that a state has moved by an unknown amount of this variance, alone."""
        self.covariance[place][place] += variance

    def admit_jump(self, place: int, variance: float, shown_by: int, per_jump: float, lost_mps: float) -> None:
        """Admit an unknown jump of the state at `place`; another, at `shown_by`, has by `per_jump` times as much.

        v has lost `lost_mps` times as much.
        """
        moved = ((place, 1.0), (shown_by, per_jump), (self.speed_place, -lost_mps))
        for i, by in moved:
            for j, also_by in moved:
                self.covariance[i][j] += variance * by * also_by

    def learn(self, place: int, value: float, variance: float) -> None:
        """Correct x and P by what is known of one state beside all readings: this value, with this variance."""
        residual, total_variance = value - self.x[place], self.covariance[place][place] + variance
        size = len(self.x)
        for i in range(size):
            self.direction[i] = self.covariance[i][place]
        for i in range(size):
            gain = self.direction[i] / total_variance
            self.x[i] += gain * residual
            for j in range(size):
                self.covariance[i][j] -= gain * self.direction[j]
        for i in range(size):
            self.direction[i] = 0.0  # else what is admitted along some states next would move all others, too

    def admit_along(self, variance: float) -> None:
        """Admit that x has moved along `direction` by an unknown multiple of it, of this variance."""
        for i in range(len(self.direction)):
            for j in range(len(self.direction)):
                self.covariance[i][j] += variance * self.direction[i] * self.direction[j]

    def admit_unseen(self, step_s: float) -> None:
        """Let each speed and adhesion walk by itself, near standstill, where nothing is predicted.

        An adhesion falls with the brake that lets go after a stop, unseen. Were its error still tied to that of
        friction, the fall would be taken for pads that rub less as the wagon starts.
        """
        for k in range(self.speed_place + 1):
            self.covariance[k][k] += self.unseen_variance(k, step_s)
        for k in range(self.adhesion_place, self.adhesion_place + self.speed_place):
            variance = self.unseen_variance(k, step_s)
            self.scale_error(k, exp(-step_s / SLOW_ADHESION_S))
            self.covariance[k][k] += variance

    def unseen_variance(self, place: int, step_s: float) -> float:
        """By how much a speed or an adhesion may move then; it becomes no surer by what it forgets."""
        if place <= self.speed_place:
            return SLOW_SPEED_DENSITY * step_s
        variance = self.covariance[place][place]
        lost = variance * (1.0 - exp(-2.0 * step_s / SLOW_ADHESION_S))
        return lost + min(SLOW_ADHESION_DENSITY * step_s, max(self.adhesion_std * self.adhesion_std - variance, 0.0))

    def save(self, place: int) -> None:
        """Save x and P as they are now in the snapshot number `place`."""
        size = len(self.x)
        for i in range(size):
            self.saved[place][i] = self.x[i]
            for j in range(size):
                self.saved[place][size + i * size + j] = self.covariance[i][j]

    def is_sound(self) -> bool:
        """Whether state and variances are finite and no variance is negative."""
        total = 0.0
        for k in range(len(self.x)):
            total += self.x[k] + self.covariance[k][k]
            if self.covariance[k][k] < 0.0:
                return False
        return abs(total) < inf
