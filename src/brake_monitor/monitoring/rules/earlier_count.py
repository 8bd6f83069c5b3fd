"""A count as it was a while ago. Kept are only the values before each change: it hardly ever changes."""

from collections import deque
from typing import Generic, TypeVar

Count = TypeVar("Count", int, tuple[int, ...])


class EarlierCount(Generic[Count]):
    """Sees a count, or several, at each observation."""

    def __init__(self, span_s: float) -> None:
        """`span_s`: the while."""
        self._span_s = span_s
        self._left: deque[tuple[float, Count]] = deque()  # when it was last something else, and what
        self._last: tuple[float, Count] | None = None

    def see(self, time_s: float, count: Count) -> Count:
        """Take the count; what it was at the beginning of the span that ends now."""
        if self._last is not None and self._last[1] != count:
            self._left.append(self._last)
        self._last = time_s, count
        while self._left and not 0.0 <= time_s - self._left[0][0] <= self._span_s:
            self._left.popleft()
        return self._left[0][1] if self._left else count
