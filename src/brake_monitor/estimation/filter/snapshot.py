"""What was known a while ago: a reading that turns out to have stood still has taught nonsense since then."""

from math import inf

SNAPSHOT_SPACING_S = 1.5  # from one to the next
SNAPSHOTS = 3


class Snapshot:
    """When x and P were what the filter keeps in the same place; without them it is alike for vehicles of any size."""

    def __init__(self) -> None:
        self.saved_s = -inf
