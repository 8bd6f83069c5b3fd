"""The clock that frames are stamped with, beside one that nobody sets: when it was set, and what it shows now."""

import time

CLOCK_SET_S = 0.25  # a larger step of the system's clock is not drift
SAME_CLOCK_S = 1.0  # frames are not stamped with the system's clock where the two are further apart
SILENCE_S = 0.5  # without a frame, and none is underway any more: readers gather them for up to 0.1 s
UNDERWAY_S = 0.04  # a captured frame may take this long to get here; the time given out stays this much behind


class FrameClock:
    """The time as it would be stamped on a frame captured now, whatever clock the bus stamps with.

    It runs on from the last frame with the monotonic clock; before the first it is the wall clock, as in the kernel.
    Where that is the system's, it notices when somebody sets it, as NTP does at the start of a gateway.
    """

    def __init__(self) -> None:
        self._system_offset_s = time.time() - time.monotonic()
        self._set_by_s = 0.0  # what no frame has shown yet
        self._frame_s = time.time()  # of the newest frame, or when it was looked for first
        self.captured(self._frame_s)

    def captured(self, time_s: float) -> None:
        """A frame was captured at this time, just now."""
        self._captured_s = time.monotonic()  # by the clock that nobody sets
        self._offset_s = time_s - self._captured_s
        self._newest_s = time_s

    def now_s(self) -> float:
        """Never before the newest frame, and behind by what may still be underway."""
        return max(self._newest_s, time.monotonic() + self._offset_s - UNDERWAY_S)

    def look(self) -> None:
        """Compare the system's clock with one that nobody sets; often enough that drift is nothing beside a step."""
        offset_s = time.time() - time.monotonic()
        if abs(offset_s - self._system_offset_s) > CLOCK_SET_S:
            self._set_by_s += offset_s - self._system_offset_s
        self._system_offset_s = offset_s

    def set_by_s(self, frame_s: float) -> float:
        """By how much the clock was set, told once, with the first frame stamped with the new time; else 0."""
        passed_s, self._frame_s = frame_s - self._frame_s, frame_s
        if abs(passed_s - self._set_by_s) >= abs(passed_s):
            return 0.0
        set_by_s, self._set_by_s = self._set_by_s, 0.0
        return set_by_s

    def set_in_silence_by_s(self) -> float:
        """By how much it was set since the last frame, after a silence; no frame needs to show it then.

        0 as long as one may be underway that was stamped before, and where frames are stamped with another clock than
        the system's.
        """
        if time.monotonic() - self._captured_s < SILENCE_S:
            return 0.0
        if abs(time.time() - self._set_by_s - self.now_s()) > SAME_CLOCK_S:
            return 0.0
        set_by_s, self._set_by_s = self._set_by_s, 0.0
        self._frame_s += set_by_s
        if set_by_s:
            self.captured(self.now_s() + set_by_s)
        return set_by_s
