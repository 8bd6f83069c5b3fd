"""The vehicle's speed as it is read."""

from math import inf


class VehicleSpeed:
    """The last good reading, by itself or of many taken together."""

    def __init__(self) -> None:
        self.mps: float | None = None
        self.time_s = -inf

    def see(self, time_s: float, value: float) -> None:
        """Take it."""
        self.time_s, self.mps = time_s, abs(value)
