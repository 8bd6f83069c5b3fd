"""What a gateway goes through: every fault of the campaign on the shipped unit, one after the other.

`tests/fault_campaign/run` plays them all and writes docs/faults.md; a test run plays the everyday ones.
"""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from campaign import FAULTS, Fault
from gateway import Gateway

pytestmark = pytest.mark.systemd


@pytest.fixture(scope="module")
def gateway(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Gateway]:
    with Gateway(Path(tmp_path_factory.mktemp("campaign"))).set_up() as gateway:
        yield gateway


@pytest.mark.parametrize(
    "fault",
    [pytest.param(f, id=f.name, marks=() if f.everyday else pytest.mark.whole_campaign) for f in FAULTS],
)
def test_fault(fault: Fault, gateway: Gateway, record_property: Callable[[str, object], None]) -> None:
    gateway.begin()
    record_property("expected", fault.expected)
    record_property("whole", not fault.everyday)
    record_property("seen", fault.play(gateway))
