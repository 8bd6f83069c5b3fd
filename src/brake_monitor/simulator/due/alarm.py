"""One alarm that is due, and how soon each kind must be raised."""

from msgspec import Struct
from msgspec.structs import replace

SETTLED_S = 4.0  # nothing is due before the monitor had time to settle
MARGIN = 0.3  # of a threshold: beyond it an alarm is due, within it may come
AFTERMATH_S = 15.0  # for so long after its end a condition may still raise an alarm

DELAY_S = {
    "low_adhesion": 1.0,
    "wheelset_not_rotating": 3.0,
    "slide": 5.0,
    "dragging_brake": 30.0,
    "brake_not_applied": 10.0,
    "uneven_braking": 5.0,
    "friction_out_of_band": 5.0,
    "friction_drift": 5.0,
    "hot_disc": 30.0,
    "pad_near_limit": 5.0,
    "pad_at_limit": 5.0,
    "input_lost": 5.0,
    "input_implausible": 20.0,
    "bus_silent": 5.0,
    "bus_fault": 5.0,
}
# Their delay counts from the end of the brake application.
AFTER_BRAKING = {"uneven_braking", "friction_out_of_band", "friction_drift", "pad_near_limit", "pad_at_limit"}


class Due(Struct, frozen=True):
    """One alarm that is due or may come. Times are the log's."""

    kind: str
    wheelset: int | None  # from 1
    from_s: float  # when it qualifies
    by_s: float | None  # when it must be raised at the latest; None: it may come
    until_s: float  # when it has gone
    reason: str

    def since(self, zero_s: float) -> "Due":
        """The same with times that count from `zero_s`."""
        by_s = None if self.by_s is None else self.by_s - zero_s
        return replace(self, from_s=self.from_s - zero_s, by_s=by_s, until_s=self.until_s - zero_s)
