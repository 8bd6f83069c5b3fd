"""The test bed itself: vcan0 is there, carries classic and FD frames, and the kernel stamps them."""

import subprocess
import time

import can
import pytest

pytestmark = pytest.mark.vcan


def test_python_can_receives_what_can_utils_send_with_the_kernels_time_stamp() -> None:
    with can.Bus(interface="socketcan", channel="vcan0") as bus:
        before_s = time.time()
        subprocess.run(["cansend", "vcan0", "123#DEADBEEF"], check=True)
        after_s = time.time()
        message = bus.recv(60.0)
    assert message is not None
    assert (message.arbitration_id, bytes(message.data)) == (0x123, bytes.fromhex("DEADBEEF"))
    # Had the stamp been made when the frame was read, it would lie after the sender's exit.
    assert before_s <= message.timestamp <= after_s
