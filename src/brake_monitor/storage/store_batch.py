"""What has changed since the memory was last written."""

from typing import NamedTuple

from msgspec import Struct, field

from brake_monitor.estimation.learned import Learned
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.monitoring.brake_units.application_record import ApplicationRecord
from brake_monitor.monitoring.brake_units.brakes import Brakes
from brake_monitor.monitoring.brake_units.gauge import Gauge

ALARMS_KEPT = 10_000  # each is about 1 kB
RECORDS_KEPT = 5000  # of brake applications
MESSAGES_KEPT = 10_000


class GaugeMark(NamedTuple):
    """Which gauge entry; the numbers begin again in a new file."""

    file: str
    number: int


class MarkedGauge(NamedTuple):
    """A gauge entry that no written `Brakes` contains yet."""

    mark: GaugeMark
    gauge: Gauge


class Batch(Struct):
    """What has changed since the last write; only the newest state counts, everything else adds up."""

    brakes: Brakes | None = None
    learned: Learned | None = None
    alarms: dict[str, Alarm] = field(default_factory=dict)  # by id, as they stand now
    applications: list[ApplicationRecord] = field(default_factory=list)
    gauges_applied: GaugeMark | None = None  # the last one that is contained in `brakes`
    messages: dict[int, bytes] = field(default_factory=dict)  # for the outbox, by sequence

    def __bool__(self) -> bool:
        return self != Batch()

    def then(self, later: "Batch") -> "Batch":
        """This batch, which could not be written, and a later one in one; of each list what the store keeps."""
        return Batch(
            later.brakes or self.brakes,
            later.learned or self.learned,
            dict(list((self.alarms | later.alarms).items())[-ALARMS_KEPT:]),
            (self.applications + later.applications)[-RECORDS_KEPT:],
            later.gauges_applied or self.gauges_applied,
            dict(list((self.messages | later.messages).items())[-MESSAGES_KEPT:]),
        )
