"""How much later than the wheel speeds the vehicle speed of a recording comes, as satellite receivers and filters do.

To the estimator a speed that lags by tau is a slip of tau times the deceleration on all wheelsets, and it takes what is
missing of the deceleration for d: nothing gives it away live. Over a recording it does. While the wagon brakes or pulls
and its wheels roll, the speed repeats what the wheels did before; while they slide it does not, and nothing is said.
Creep looks like a lag of up to a tenth of a second.
"""

from array import array
from collections.abc import Sequence

import numpy as np

from brake_monitor.decoding.sample_block import SampleBlock
from brake_monitor.frame_block import Floats
from brake_monitor.samples import Channel, Place, Quality, Quantity

LONGEST_S = 3600.0  # of a recording is looked at
LAGS_S = np.arange(0.0, 5.01, 0.05)  # the last one may be any beyond
LEAST_LAG_S = 0.15  # more than creep looks like
EXPLAINED = 0.25  # of the difference between speed and wheels, what a lag may leave of it
STEADY_MPS2, CHANGING_MPS2, SLIDING_MPS2 = 0.15, 0.3, 2.0
SPAN_S = 0.5  # to both sides, for the deceleration
LEAST_MPS = 3.0
LEAST_COUNT = 40  # speeds while it brakes or pulls, and while it does neither


class SpeedLag:
    """Keeps the speeds of a recording's first hour."""

    def __init__(self, channels: Sequence[Channel], wheel_radius_m: Sequence[float]) -> None:
        self._scale: dict[Place, float] = {(Quantity.SPEED, 0): 1.0}
        self._scale |= {(Quantity.AXLE_SPEED, place): radius_m for place, radius_m in enumerate(wheel_radius_m)}
        self._delay_s = {(channel.quantity, channel.wheelset): channel.delay_s for channel in channels}
        self._times_s = {place: array("d") for place in self._scale}
        self._speeds_mps = {place: array("d") for place in self._scale}
        self._begun_s: float | None = None

    def see(self, samples: SampleBlock) -> None:
        """Take successive samples."""
        if not len(samples.time_s):
            return
        if self._begun_s is None:
            self._begun_s = float(samples.time_s[0])
        if float(samples.time_s[0]) - self._begun_s > LONGEST_S:
            return
        for number, channel in enumerate(samples.channels):
            place = (channel.quantity, channel.wheelset)
            if place in self._scale:
                own = np.flatnonzero((samples.channel == number) & (samples.quality == Quality.GOOD))
                self._times_s[place].frombytes((samples.time_s[own] - self._delay_s[place]).tobytes())
                self._speeds_mps[place].frombytes((np.abs(samples.value[own]) * self._scale[place]).tobytes())

    def find_s(self) -> float | None:
        """By how much the speed comes later, in s; None where it does not, or nothing tells."""
        (told_s, told_mps), *wheels = every = [self._series(place) for place in self._scale]
        if not all(len(times_s) > 1 and (np.diff(times_s) >= 0.0).all() for times_s, _ in every):
            return None  # nothing is there, or its clock was set

        def rolling_mps(at_s: Floats) -> Floats:
            """Of the wheelset that slides least."""
            fastest: Floats = np.max([np.interp(at_s, *series) for series in wheels], axis=0)
            return fastest

        begin_s = max(float(times_s[0]) for times_s, _ in wheels) + LAGS_S[-1]
        end_s = min(float(times_s[-1]) for times_s, _ in wheels) - SPAN_S
        during = (told_s >= begin_s) & (told_s <= end_s) & (told_mps > LEAST_MPS) & (rolling_mps(told_s) > LEAST_MPS)
        time_s, speed_mps = told_s[during], told_mps[during]
        change_mps2 = np.abs(rolling_mps(time_s + SPAN_S) - rolling_mps(time_s - SPAN_S)) / (2.0 * SPAN_S)
        steady, changing = change_mps2 < STEADY_MPS2, (change_mps2 > CHANGING_MPS2) & (change_mps2 < SLIDING_MPS2)
        if min(np.count_nonzero(steady), np.count_nonzero(changing)) < LEAST_COUNT:
            return None
        radius_error = np.median(speed_mps[steady] / rolling_mps(time_s[steady]))
        changing_s, changing_mps = time_s[changing], speed_mps[changing] / radius_error
        off_mps = [np.median(np.abs(changing_mps - rolling_mps(changing_s - lag_s))) for lag_s in LAGS_S]
        best = int(np.argmin(off_mps))
        lag_s = float(LAGS_S[best])
        is_one = LEAST_LAG_S <= lag_s < LAGS_S[-1] and off_mps[best] < EXPLAINED * off_mps[0]
        return lag_s if is_one else None

    def _series(self, place: Place) -> tuple[Floats, Floats]:
        return np.frombuffer(self._times_s[place]), np.frombuffer(self._speeds_mps[place])
