"""What a person wants to know first of a recording, in a few lines."""

from collections.abc import Iterator
from math import inf

from brake_monitor.estimation.estimate import INTERVAL_SIGMAS, Estimate, Status, WheelsetEstimate
from brake_monitor.monitoring.alarm import TELL_OF_SLIDES, Alarm
from brake_monitor.monitoring.brake_units.brakes import Brakes
from brake_monitor.monitoring.brake_units.wear import pad_life
from brake_monitor.plural import plural
from brake_monitor.processing.pipeline import Outputs, Pipeline
from brake_monitor.settings.config import Settings
from brake_monitor.settings.wear_settings import WearSettings


class Summary:
    """Gathers figures while a recording is played."""

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self._earliest_s, self._latest_s = inf, -inf  # of the estimates: a clock may be set back on the way
        self._estimates = 0
        self._valid = 0
        self._saturated_adhesion: list[float] = []
        self._top_speed_mps = 0.0
        self._last: Estimate | None = None
        self._learned: set[int] = set()  # the wheelsets, from 1, whose friction was valid at any time
        self._alarms: dict[str, Alarm] = {}

    def see(self, outputs: Outputs) -> None:
        """Take what one step gave."""
        for alarm in outputs.alarms:
            self._alarms[alarm.id] = alarm
        estimate = outputs.estimate
        if estimate is None:
            return
        self._earliest_s = min(self._earliest_s, estimate.time_s)
        self._latest_s = max(self._latest_s, estimate.time_s)
        self._estimates += 1
        self._last = estimate
        self._top_speed_mps = max(self._top_speed_mps, estimate.speed_mps)
        self._learned.update(i for i, own in enumerate(estimate.wheelsets, 1) if own.friction_status is Status.VALID)
        if estimate.status is Status.VALID:
            self._valid += 1
            if estimate.saturated and estimate.speed_mps > self._settings.alarms.low_adhesion.min_speed_mps:
                self._saturated_adhesion.append(estimate.adhesion)

    def finish(self, pipeline: Pipeline) -> None:
        """Take what was not given out: open alarms as they stand at the end."""
        self._alarms |= {alarm.id: alarm for alarm in pipeline.monitor.open_alarms()}

    @property
    def alarms(self) -> tuple[Alarm, ...]:
        """Every alarm as last known, in the order of raising."""
        return tuple(self._alarms.values())

    def text(self, pipeline: Pipeline) -> str:
        """The summary."""
        lines = [
            f"{self._settings.vehicle.id}: {max(self._latest_s - self._earliest_s, 0.0):.1f} s of recording, "
            f"{plural(pipeline.decoder.counts.frames, 'frame')}, {pipeline.decoder.counts.mapped} of them mapped",
            f"{plural(self._estimates, 'estimate')}, {self._valid} valid; "
            f"top speed {self._top_speed_mps * 3.6:.1f} km/h",
        ]
        slid = any(alarm.kind in TELL_OF_SLIDES for alarm in self.alarms)  # what no alarm calls a slide is a bump
        if self._saturated_adhesion and slid:
            seen = sorted(self._saturated_adhesion)
            lines.append(
                f"adhesion while the wheels asked for more than the rail gave: median {seen[len(seen) // 2]:z.3f}, "
                f"greatest {seen[-1]:z.3f} ({plural(len(seen), 'estimate')})"
            )
        if self._last is not None:
            lines += [self._friction_line(i, wheelset) for i, wheelset in enumerate(self._last.wheelsets, 1)]
        lines += _wear_lines(pipeline.brake_book.brakes, self._settings.wear)
        if self._alarms:
            lines += [f"{plural(len(self._alarms), 'alarm')}:", *(self._alarm_line(alarm) for alarm in self.alarms)]
        else:
            lines.append("no alarms")
        return "\n".join(lines)

    def _friction_line(self, i: int, last: WheelsetEstimate) -> str:
        """The last value; not where it is still what the settings assume."""
        if i not in self._learned:
            return f"wheelset {i}: friction was not learned: it was never valid"
        doubt = INTERVAL_SIGMAS * last.friction_std
        return f"wheelset {i}: friction {last.friction:z.3f} ± {doubt:.3f} (95 %) at the end"

    def _alarm_line(self, alarm: Alarm) -> str:
        begun_s = self._earliest_s if self._estimates else 0.0
        until = "    open  " if alarm.cleared_time_s is None else f"{alarm.cleared_time_s - begun_s:8.1f} s"
        place = "wagon" if alarm.wheelset is None else f"wheelset {alarm.wheelset}"
        return (
            f"  {alarm.raised_time_s - begun_s:7.1f} -{until}  {alarm.severity:7} {alarm.kind:21} {place}\n"
            f"    {alarm.message}"
        )


def _wear_lines(brakes: Brakes, settings: WearSettings) -> Iterator[str]:
    for wheelset, unit in enumerate(brakes.units, 1):
        thickness, use = pad_life(unit.pads, settings).by_energy, unit.pads.since_fitted
        yield (
            f"wheelset {wheelset}: {use.energy_j / 1e6:.2f} MJ of braking, "
            f"{plural(round(use.stops), 'application')} ended, slid {use.sliding_distance_m:.0f} m; "
            f"pads {thickness.value_mm:.3f} mm "
            f"({thickness.low_mm:.1f} to {thickness.high_mm:.1f} mm), discs {unit.disc_temperature_c:.0f} °C"
        )
