"""When something was so last, in a time that may go back."""

from math import inf


class LastTime:
    """When a condition held last. As time goes back it is taken to hold: what waits for it to be over waits anew."""

    def __init__(self, time_s: float = -inf) -> None:
        """`time_s`: inf where it may have held until now."""
        self.time_s = time_s

    def see(self, time_s: float, holds: bool) -> None:
        """Take whether it holds now."""
        if holds or self.time_s > time_s:
            self.time_s = time_s
