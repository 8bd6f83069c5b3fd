"""What outlives the program: the state that the pipeline goes on with."""

from collections.abc import Iterator

from msgspec import Struct

from brake_monitor.estimation.learned import Learned
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.monitoring.brake_units.brakes import Brakes
from brake_monitor.settings.config import Settings


class Remembered(Struct, frozen=True):
    """The pipeline's slow state; what is None or empty was never known."""

    learned: Learned | None = None
    brakes: Brakes | None = None
    open_alarms: tuple[Alarm, ...] = ()

    def without_use(self, settings: Settings) -> Iterator[str]:
        """What of it a pipeline does not go on with, since its settings have changed, in words for the journal."""
        radii_m, learned = settings.vehicle.wheel_radius_m, self.learned
        if learned is not None and learned.configured_radius_m is not None:
            for i, (then_m, now_m) in enumerate(zip(learned.configured_radius_m, radii_m, strict=False), 1):
                if then_m != now_m:
                    yield f"wheelset {i}: wheel_radius_m is {now_m:g} and was {then_m:g}; its radius is learned anew"
        if learned is not None and learned.calibration not in (None, settings.calibration):
            yield (
                "mass, brake_radius_m or the mapping of a force was changed: "
                "the friction of all pads is learned anew, and rules over several applications begin again"
            )
        if self.brakes is not None and self.brakes.as_configured(settings.wear) != self.brakes:
            yield "[wear] was changed: pads that nobody has measured or replaced are reckoned with it from the start"
