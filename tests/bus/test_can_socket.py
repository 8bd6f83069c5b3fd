"""The socket as it asks the kernel, on a processor that is not this one's kind. With a real bus: tests/vcan."""

import socket
import struct

import pytest

from brake_monitor.bus.can_socket import CanSocket
from brake_monitor.frame import CanFilter, Frame

SO_RCVTIMEO_OLD = 20  # asm-generic/socket.h: with a timeval of two longs
EFF_FLAG = 0x80000000  # linux/can.h
FILTERS = (
    CanFilter(can_id=0x123, can_mask=0x7FF, extended=False),
    CanFilter(can_id=0x18FF5030, can_mask=0x1FFFFFFF, extended=True),
)


class Kernel:
    """What is asked of the kernel, which has one extended frame."""

    def __init__(self, *_: int) -> None:
        self.options: dict[tuple[int, int], int | bytes] = {}

    def setsockopt(self, level: int, name: int, value: int | bytes) -> None:
        self.options[level, name] = value

    def bind(self, _: tuple[str]) -> None:
        pass

    def close(self) -> None:
        pass

    def recvmsg(self, *_: int) -> tuple[bytes, list[tuple[int, int, bytes]], int, None]:
        return struct.pack("=IB3x8s", 0x18FF5030 | EFF_FLAG, 2, b"\x01\x02"), [], 0, None


@pytest.fixture
def kernel(monkeypatch: pytest.MonkeyPatch) -> Kernel:
    """That of an ARM of 32 bits whose Python has times of 64: a long is too short for flag and mask."""
    kernel = Kernel()
    monkeypatch.setattr(socket, "CAN_EFF_FLAG", -(2**31))
    monkeypatch.setattr(socket, "CAN_RTR_FLAG", 2**30)
    monkeypatch.setattr(socket, "CAN_ERR_FLAG", 2**29)
    monkeypatch.setattr(socket, "SO_RCVTIMEO", 66)  # SO_RCVTIMEO_NEW: it wants 16 bytes
    monkeypatch.setattr(socket, "socket", lambda *_: kernel)
    return kernel


def test_filters_and_frames_go_by_the_flag_in_the_highest_of_32_bits(kernel: Kernel) -> None:
    bus = CanSocket("can0", FILTERS, "can0")
    asked = kernel.options[socket.SOL_CAN_RAW, socket.CAN_RAW_FILTER]
    assert asked == struct.pack("=4I", 0x123, 0x7FF | EFF_FLAG, 0x18FF5030 | EFF_FLAG, 0x1FFFFFFF | EFF_FLAG)
    assert bus.recv(0.0) == Frame(0.0, "can0", 0x18FF5030, True, b"\x01\x02")


def test_a_time_out_is_the_one_that_takes_two_longs(kernel: Kernel) -> None:
    bus = CanSocket("can0", (), "can0")
    bus.recv(1.5)
    assert kernel.options[socket.SOL_SOCKET, SO_RCVTIMEO_OLD] == struct.pack("@ll", 1, 500_000)
    bus.recv(0.25)
    assert kernel.options[socket.SOL_SOCKET, SO_RCVTIMEO_OLD] == struct.pack("@ll", 0, 250_000)
