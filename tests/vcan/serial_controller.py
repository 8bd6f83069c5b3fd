"""A real CAN controller for the kernel: its serial-line driver, with the adapter at the line's other end played here.

The driver (slcan) is a CAN device like those of a gateway, with bit rate and listen-only mode. The adapter hears
everything that leaves the machine: a frame that the kernel sends is a line that begins with t, T, r or R.
"""

import fcntl
import os
import pty
import struct
import subprocess
import threading
import tty
from collections.abc import Iterator
from contextlib import contextmanager

_TIOCSETD, _N_SLCAN, _SIOCGIFNAME = 0x5423, 17, 0x8910
_FRAMES = b"tTrR"


class Adapter:
    """What hangs on the serial line; it acknowledges nothing and puts in frames as if from the bus."""

    def __init__(self, line: int) -> None:
        self.heard = b""
        self._line = line
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        try:
            while heard := os.read(self._line, 4096):
                self.heard += heard
        except OSError:  # the line is closed: the test is over
            return

    def put(self, can_id: int, data: bytes) -> None:
        """A standard frame arrives from the bus."""
        os.write(self._line, b"t%03X%d%s\r" % (can_id, len(data), data.hex().upper().encode()))

    def commands(self) -> list[bytes]:
        return [line for line in self.heard.split(b"\r") if line]

    def frames_sent(self) -> list[bytes]:
        """Frames that the kernel has put on the wire."""
        return [line for line in self.commands() if line[:1] in _FRAMES]


@contextmanager
def serial_controller() -> Iterator[tuple[str, Adapter]]:
    """Name of a new CAN interface, which is down, and what is behind it."""
    subprocess.run(["modprobe", "-a", "can-dev", "slcan"], check=True)
    ours, theirs = pty.openpty()
    try:
        tty.setraw(theirs)
        fcntl.ioctl(theirs, _TIOCSETD, struct.pack("i", _N_SLCAN))
        name = fcntl.ioctl(theirs, _SIOCGIFNAME, bytes(64)).split(b"\0")[0].decode()
        yield name, Adapter(ours)
    finally:
        os.close(theirs)
        os.close(ours)


def set_up(name: str, *, listen_only: bool) -> None:
    """Bring the controller up as an administrator would."""
    mode = "on" if listen_only else "off"
    for command in (
        ["ip", "link", "set", name, "down"],
        ["ip", "link", "set", name, "type", "can", "bitrate", "250000", "listen-only", mode],
        ["ip", "link", "set", name, "up"],
    ):
        subprocess.run(command, check=True)
