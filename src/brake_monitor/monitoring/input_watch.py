"""What becomes of each mapped signal over time: why nothing good arrives, and pressing forces that stand still."""

from collections.abc import Iterable
from math import inf

from brake_monitor.samples import Channel, InputCondition, Quality, Quantity, Sample

Place = tuple[Quantity, int]

WHY = {
    Quality.OUT_OF_RANGE: InputCondition.OUT_OF_RANGE,
    Quality.NOT_AVAILABLE: InputCondition.NOT_AVAILABLE,
    Quality.BAD_COUNTER: InputCondition.BAD_COUNTER,
}
FORCE_FROZEN_S = 5.0
FORCE_FROZEN_READINGS = 20
MOVED_N = 8000.0  # another brake's force has moved this much meanwhile: far beyond what gear and sensors differ by


class InputWatch:
    """Sees every sample, and refines what the estimator says of an input."""

    def __init__(self, channels: Iterable[Channel]) -> None:
        self._timeout_s = {(channel.quantity, channel.wheelset): channel.timeout_s for channel in channels}
        self._arrived: dict[Place, tuple[float, Quality]] = {}  # the last of each that was not made up by a time-out
        forces = [place for quantity, place in self._timeout_s if quantity is Quantity.PRESSING_FORCE]
        self._forces = {wheelset: _StandingForce() for wheelset in forces}
        self._wsp_s = -inf

    def see(self, sample: Sample) -> None:
        """Take a sample as decoded."""
        if sample.quality is Quality.STALE:
            return
        self._arrived[sample.quantity, sample.wheelset] = (sample.time_s, sample.quality)
        if sample.quality is not Quality.GOOD:
            return
        if sample.quantity is Quantity.WSP_ACTIVE and sample.value != 0.0:
            self._wsp_s = sample.time_s
        elif sample.quantity is Quantity.PRESSING_FORCE:
            for wheelset, force in self._forces.items():
                if wheelset == sample.wheelset:
                    force.see(sample.time_s, sample.value, self._wsp_s)
                else:
                    force.see_other(sample.wheelset, sample.value)

    def condition(self, place: Place, time_s: float, told: InputCondition) -> InputCondition:
        """What is to be thought of an input of which the estimator says `told`."""
        quantity, wheelset = place
        if told is InputCondition.LOST:
            arrived_s, quality = self._arrived.get(place, (-inf, Quality.STALE))
            still_arrives = time_s - arrived_s < self._timeout_s[place]
            return WHY.get(quality, told) if still_arrives else told
        if told is InputCondition.GOOD and quantity is Quantity.PRESSING_FORCE and self._forces[wheelset].is_frozen:
            return InputCondition.FROZEN
        return told


class _StandingForce:
    """Notices a force that repeats itself to the last bit while other brakes fill or empty.

    Nothing is said of a force of zero: that a brake does not fill is a fault of the brake. Nor while a wheel-slide
    protection acts, which empties one brake and leaves another as it is.
    """

    def __init__(self) -> None:
        self._value = inf
        self._since_s = 0.0
        self._repeated = 0
        self._others: dict[int, tuple[float, float]] = {}  # least and greatest of each meanwhile
        self.is_frozen = False

    def see(self, time_s: float, value: float, wsp_s: float) -> None:
        if value != self._value or wsp_s > self._since_s:
            self._value, self._since_s, self._repeated, self._others = value, time_s, 0, {}
            self.is_frozen = False
            return
        self._repeated += 1
        self.is_frozen = (
            value > 0.0
            and self._repeated >= FORCE_FROZEN_READINGS
            and time_s - self._since_s >= FORCE_FROZEN_S
            and any(most - least > MOVED_N for least, most in self._others.values())
        )

    def see_other(self, wheelset: int, value: float) -> None:
        least, most = self._others.get(wheelset, (value, value))
        self._others[wheelset] = (min(least, value), max(most, value))
