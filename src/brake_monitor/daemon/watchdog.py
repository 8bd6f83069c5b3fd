"""How systemd and the log are told whether the daemon lives: as long as every thread of it makes progress."""

import logging
import time

from brake_monitor.daemon.sd_notify import notify, watchdog_s

STATUS_EVERY_S = 5.0
STUCK_S = 10.0  # a thread that completed no turn for as long hangs

log = logging.getLogger(__name__)


class Watchdog:
    """Feeds systemd's, several times within its period."""

    def __init__(self) -> None:
        self._every_s = min(STATUS_EVERY_S, (watchdog_s() or STATUS_EVERY_S) / 3)
        self._due_s = 0.0
        self._hanging: list[str] = []
        self._dropped_frames = 0

    def is_due(self) -> bool:
        """Whether to feed it now."""
        now_s = time.monotonic()
        if now_s < self._due_s:
            return False
        self._due_s = now_s + self._every_s
        return True

    def feed(self, hanging: list[str], status: list[str]) -> None:
        """Feed it with a status, unless threads hang, which is logged."""
        if hanging != self._hanging:
            self._hanging = hanging
            log.warning("threads without progress for %.0f s: %s", STUCK_S, ", ".join(hanging) or "none any more")
        if not hanging:
            notify("WATCHDOG=1", f"STATUS={', '.join(status)}")

    def note_dropped(self, frames: int) -> None:
        """Log when the kernel has dropped more frames than these."""
        if frames > self._dropped_frames:
            log.warning("the kernel dropped %d frames: this machine is too slow", frames - self._dropped_frames)
            self._dropped_frames = frames
