from collections.abc import Iterator

import can
import pytest


@pytest.fixture
def sender() -> Iterator[can.BusABC]:
    """Another node on vcan0, where the frames of a test come from."""
    with can.Bus(interface="socketcan", channel="vcan0", fd=True) as bus:
        yield bus
