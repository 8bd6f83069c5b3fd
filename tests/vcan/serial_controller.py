"""A real CAN controller for the kernel: its serial-line driver, with the adapter at the line's other end played here.

The driver (slcan) is a CAN device like those of a gateway, with bit rate and listen-only mode. The adapter hears
everything that leaves the machine: a frame that the kernel sends is a line that begins with t, T, r or R. It hears on a
thread of its own, later than the kernel writes: what it heard is told once the command has come that ends it.
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

from program import until

_TIOCSETD, _N_SLCAN, _SIOCGIFNAME = 0x5423, 17, 0x8910
_FRAMES = b"tTrR"
_OPEN, _OPEN_TO_LISTEN, _CLOSE = b"O", b"L", b"C"


class Adapter:
    """What hangs on the serial line of an interface; it acknowledges nothing and puts in frames as if from the bus."""

    def __init__(self, name: str, line: int) -> None:
        self.name = name
        self.heard = b""
        self._line = line
        self._listener = threading.Thread(target=self._listen, daemon=True)
        self._listener.start()

    def _listen(self) -> None:
        try:
            while heard := os.read(self._line, 4096):
                self.heard += heard
        except OSError:  # the line is closed: the test is over
            return

    def join(self) -> None:
        """After the other end was closed: it hears nothing any more, which a new line of the same number may carry."""
        self._listener.join()

    def put(self, can_id: int, data: bytes) -> None:
        """A standard frame arrives from the bus."""
        os.write(self._line, b"t%03X%d%s\r" % (can_id, len(data), data.hex().upper().encode()))

    def set_up(self, *, listen_only: bool) -> None:
        """Bring the controller up as an administrator would; returns when the adapter was told to open."""
        self._set_down()
        mode = "on" if listen_only else "off"
        _ip("set", self.name, "type", "can", "bitrate", "250000", "listen-only", mode)
        _ip("set", self.name, "up")
        self._wait_for(_OPEN_TO_LISTEN if listen_only else _OPEN)

    def frames_heard(self) -> list[bytes]:
        """Frames that the kernel has put on the wire so far, the adapter perhaps not all yet."""
        return [line for line in self._lines() if line[:1] in _FRAMES]

    def frames_sent(self) -> list[bytes]:
        """All frames that the kernel has put on the wire; the controller is down afterwards."""
        self._set_down()
        return self.frames_heard()

    def _set_down(self) -> None:
        was_open = self._lines() != []
        _ip("set", self.name, "down")
        if was_open:
            self._wait_for(_CLOSE)

    def _wait_for(self, command: bytes) -> None:
        until(lambda: self._lines()[-1:] == [command])

    def _lines(self) -> list[bytes]:
        return [line for line in self.heard.split(b"\r") if line]


@contextmanager
def serial_controller() -> Iterator[Adapter]:
    """The adapter of a new CAN interface, which is down."""
    subprocess.run(["modprobe", "-a", "can-dev", "slcan"], check=True)
    ours, theirs = pty.openpty()
    tty.setraw(theirs)
    fcntl.ioctl(theirs, _TIOCSETD, struct.pack("i", _N_SLCAN))
    name = fcntl.ioctl(theirs, _SIOCGIFNAME, bytes(64)).split(b"\0")[0].decode()
    adapter = Adapter(name, ours)
    try:
        yield adapter
    finally:
        os.close(theirs)
        adapter.join()
        os.close(ours)


def _ip(*arguments: str) -> None:
    subprocess.run(["ip", "link", *arguments], check=True)
