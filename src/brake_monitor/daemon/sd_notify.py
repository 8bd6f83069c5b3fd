"""What systemd is told over $NOTIFY_SOCKET (sd_notify(3)); without systemd nothing happens."""

import atexit
import os
import socket
from contextlib import suppress
from functools import cache


def notify(*assignments: str) -> None:
    """Send assignments such as READY=1 or STATUS=…, together."""
    path = os.environ.get("NOTIFY_SOCKET", "")
    if not path:
        return
    address = "\0" + path[1:] if path.startswith("@") else path
    with suppress(OSError):  # systemd is being re-executed or does not read: that must not end or stop the service
        _socket().sendto("\n".join(assignments).encode(), socket.MSG_DONTWAIT, address)


@cache
def _socket() -> socket.socket:
    """Kept until the end: a process without free file descriptors must still be able to feed the watchdog."""
    kept = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC)
    atexit.register(kept.close)
    return kept


def watchdog_s() -> float | None:
    """Return after how many seconds without WATCHDOG=1 systemd restarts this process; None when it does not."""
    watched_pid = os.environ.get("WATCHDOG_PID", "")
    period_us = os.environ.get("WATCHDOG_USEC", "")
    if not period_us.isdigit() or watched_pid not in ("", str(os.getpid())):
        return None
    return int(period_us) / 1e6
