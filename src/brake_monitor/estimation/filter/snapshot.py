"""Snapshots of x and P to go back to: a speed that turns out to be frozen has taught nonsense since it froze."""

from math import inf

SNAPSHOT_SPACING_S = 1.5  # between two
SNAPSHOTS = 3


class Snapshot:
    """When a snapshot was saved; its numbers, as many as the vehicle's size makes them, are in `Belief.saved`."""

    def __init__(self) -> None:
        self.saved_s = -inf
