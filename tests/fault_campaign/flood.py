"""Puts frames on wire0 until it is ended. usage: flood.py KIND FRAMES_PER_S

unmapped    ids that the wagon does not map
errors      error frames: no acknowledgement, bus errors
malformed   mapped ids with every wrong length, as remote frames and as CAN FD
"""

import itertools
import socket
import struct
import sys
import time

BCU, WSP, GNSS, GNSS_POSITION, BCU_STATUS = 0x120, 0x1A0, 0x2A0, 0x2A1, 0x320
SANDER = 2566869040
REMOTE, ERROR = 0x40000000, 0x20000000
TURN_S = 0.02


def frame(can_id: int, data: bytes, length: int | None = None) -> bytes:
    return struct.pack("=IB3x", can_id, len(data) if length is None else length) + data.ljust(8, b"\0")


def long_frame(can_id: int, data: bytes) -> bytes:
    return struct.pack("=IB3x", can_id, len(data)) + data.ljust(64, b"\0")


UNMAPPED = [frame(can_id, bytes(8)) for can_id in (0x001, 0x121, 0x1A1, 0x7FF, 0x80000120, 0x9FFFFFFF)]
ERRORS = [frame(ERROR | 0x20, bytes(8)), frame(ERROR | 0x88, bytes((0, 0, 0x04, 0, 0, 0, 0, 0)))]
MAPPED = (BCU, WSP, GNSS, GNSS_POSITION, BCU_STATUS, SANDER)
MALFORMED = [
    *(frame(can_id, b"\xff" * length) for can_id in MAPPED for length in range(3)),
    *(frame(can_id | REMOTE, b"", 8) for can_id in MAPPED),
    *(long_frame(can_id, b"") for can_id in MAPPED),
]

kind, rate = sys.argv[1:]
frames = itertools.cycle({"unmapped": UNMAPPED, "errors": ERRORS, "malformed": MALFORMED}[kind])
with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as wire:
    wire.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FD_FRAMES, 1)
    wire.bind(("wire0",))
    due = 0.0
    before_s = time.monotonic()
    while True:
        time.sleep(TURN_S)
        now_s = time.monotonic()
        due += (now_s - before_s) * float(rate)
        before_s = now_s
        while due >= 1.0:
            wire.send(next(frames))
            due -= 1.0
