"""The one path: frame → samples → estimate → alarms. No threads, no clock, no I/O: time is the frames'."""

from math import floor
from typing import Self

from msgspec import Struct
from msgspec.structs import replace

from brake_monitor.config import Settings
from brake_monitor.estimator import ESSENTIAL, Estimate, Estimator
from brake_monitor.frame import Frame
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.monitoring.brake_book import BrakeBook
from brake_monitor.monitoring.brake_rules import brake_rules
from brake_monitor.monitoring.bus_watch import BusWatch
from brake_monitor.monitoring.force_watch import ForceState, ForceWatch
from brake_monitor.monitoring.input_watch import InputWatch
from brake_monitor.monitoring.monitor import Monitor
from brake_monitor.monitoring.observation import OBSERVATION_PERIOD_S, InputReport, Observation, good
from brake_monitor.monitoring.stops import StopRecord
from brake_monitor.monitoring.wheel_watch import WheelState, WheelWatch
from brake_monitor.remembered import Gauge, Remembered, after_gauge
from brake_monitor.samples import InputCondition, Quantity, Sample
from brake_monitor.signals import SignalDecoder


class Outputs(Struct, frozen=True):
    """What one step gave out: an estimate when one was due, the alarms that changed, what ended."""

    estimate: Estimate | None = None
    alarms: tuple[Alarm, ...] = ()
    stops: tuple[StopRecord, ...] = ()  # brake applications that have ended


NOTHING = Outputs()
BLIND_S = 0.5  # without any reading for longer, the estimate says so
LONGEST_SILENCE_S = 60.0  # the rules see the first minute of a gap; beyond it a recorder was off, or the clock set


class Pipeline:
    """Takes frames in the order they were captured; live, replay, simulation and tests all run this object."""

    def __init__(self, settings: Settings, decoder: SignalDecoder) -> None:
        self.decoder = decoder
        self.estimator = Estimator(settings.vehicle, settings.estimator, decoder.channels)
        self.shadow: Estimator | None = None  # takes the same samples, gives nothing out
        self.brake_book = BrakeBook(settings.vehicle.wheelset_count, settings.wear, settings.estimator.contact_force_n)
        self.monitor = Monitor(settings.alarms, settings.vehicle.wheelset_count, brake_rules(settings))
        self._bus_watch = BusWatch((bus.name for bus in settings.can), decoder.channels)
        self._input_watch = InputWatch(decoder.channels)
        self._wheel_watch = WheelWatch(settings.vehicle, settings.estimator.contact_force_n)
        self._force_watch = ForceWatch(
            settings.vehicle, settings.estimator.contact_force_n, settings.estimator.friction_nominal
        )
        self.memory_failure = ""  # why the memory cannot be written, told by whoever keeps one
        self._taken_s = 0.0  # when time last went on
        self._observed_turn = -1  # number of the last observation period that the rules saw
        self._wear = settings.wear
        self._rate_hz = settings.output.rate_hz
        self._begun_s: float | None = None  # output periods count from the first mapped frame
        self._turn = -1  # number of the last output period that an estimate was given out in
        self._fused_s = 0.0  # when a sample was last fused

    @classmethod
    def from_settings(cls, settings: Settings) -> Self:
        """Load the DBC files and put the stages together; InputError when the mapping does not fit them."""
        return cls(settings, SignalDecoder.from_settings(settings))

    def step(self, frame: Frame) -> Outputs:
        """Take the next frame."""
        samples = self.decoder.decode(frame)
        passed_s = frame.time_s - self._taken_s
        if not samples and 0.0 <= passed_s < OBSERVATION_PERIOD_S:
            self._bus_watch.see(frame)
            return NOTHING
        missed = self._bridge(frame.time_s) if passed_s > BLIND_S and self._begun_s is not None else NOTHING
        self._bus_watch.see(frame)
        outputs = self._take(samples, frame.time_s)
        if missed is NOTHING:
            return outputs
        return Outputs(outputs.estimate, missed.alarms + outputs.alarms, missed.stops + outputs.stops)

    def advance(self, time_s: float) -> Outputs:
        """Nothing arrived until time_s: inputs may have become stale."""
        return self._take([], time_s)

    def clock_set(self, by_s: float) -> None:
        """The clock that stamps frames was set ahead by so much, or back: what seems to be a gap is none."""
        self._taken_s += by_s
        self._bus_watch.clock_set(by_s)

    def bus_down(self, name: str, is_down: bool) -> None:
        """Note that the interface of a bus, by its configured name, went down or works again."""
        self._bus_watch.down(name, is_down)

    def acknowledge(self, alarm_id: str, time_s: float) -> Outputs:
        """A person has seen an open alarm; nothing when none has this id, or it was seen before."""
        alarm = self.monitor.acknowledge(alarm_id, time_s)
        return NOTHING if alarm is None else Outputs(None, (alarm,))

    def remembered(self) -> Remembered:
        """The state that a restart should not forget."""
        brakes = self.brake_book.brakes
        known = None if brakes.time_s is None else brakes
        return Remembered(self.estimator.learned(), known, self.monitor.open_alarms())

    def resume(self, remembered: Remembered) -> None:
        """Go on with the state of an earlier run; InputError, and nothing changed, when none can be like that."""
        if remembered.learned is not None:
            self.estimator.resume(remembered.learned)
        if remembered.brakes is not None:
            self.brake_book.resume(remembered.brakes)
        self.monitor.resume(remembered.open_alarms)

    def apply(self, gauge: Gauge) -> None:
        """Take up what a person measured."""
        self.brake_book.resume(after_gauge(self.brake_book.brakes, gauge, self._wear))

    def _bridge(self, time_s: float) -> Outputs:
        """Let the rules see the silence before a frame, as they do when a daemon tells of it meanwhile."""
        alarms: list[Alarm] = []
        stops: list[StopRecord] = []
        from_s = self._taken_s
        for k in range(1, int(min(time_s - from_s, LONGEST_SILENCE_S) / OBSERVATION_PERIOD_S)):
            outputs = self._take([], from_s + k * OBSERVATION_PERIOD_S, gives_estimate=False)
            alarms += outputs.alarms
            stops += outputs.stops
        return Outputs(None, tuple(alarms), tuple(stops))

    def _take(self, samples: list[Sample], time_s: float, *, gives_estimate: bool = True) -> Outputs:
        fused = False
        for sample in (*self.decoder.expire(time_s), *samples):
            self._input_watch.see(sample)
            self._wheel_watch.see(sample)
            fused |= self.estimator.take(sample)
            if self.shadow is not None:
                self.shadow.take(sample)
        self._taken_s = time_s
        if self._begun_s is None:
            self._begun_s = self._fused_s = time_s
        if fused:
            self._fused_s = time_s
        blind = time_s - self._fused_s > BLIND_S
        if not (fused or blind):
            return NOTHING
        wanted = gives_estimate and self._is_due(fused, time_s - self._begun_s)
        turn = floor((time_s - self._begun_s) / OBSERVATION_PERIOD_S)
        if not wanted and turn == self._observed_turn:
            return NOTHING
        estimate = self.estimator.estimate(time_s if blind else self.estimator.time_s)
        alarms: tuple[Alarm, ...] = ()
        stops: tuple[StopRecord, ...] = ()
        if turn != self._observed_turn:
            self._observed_turn = turn
            inputs, wheels = self._inputs(estimate)
            self.estimator.disbelieve(_contradicted(inputs))
            stops = self.brake_book.see(estimate, inputs)
            buses = self._bus_watch.reports(time_s)
            brakes = self.brake_book.brakes
            alarms = self.monitor.see(Observation(estimate, inputs, buses, brakes, wheels, self.memory_failure))
        return Outputs(estimate if wanted else None, alarms, stops)

    def _inputs(self, estimate: Estimate) -> tuple[tuple[InputReport, ...], tuple[WheelState, ...]]:
        """What is to be thought of each input and wheelset."""
        told = tuple(
            InputReport(
                channel.quantity,
                channel.wheelset,
                channel.message,
                channel.signal,
                self._input_watch.condition(
                    (channel.quantity, channel.wheelset),
                    estimate.time_s,
                    self.estimator.input_condition(channel.quantity, channel.wheelset),
                ),
                channel.bus,
            )
            for channel in self.decoder.channels
        )
        has_speed = good(told, Quantity.SPEED, 1)[0]
        measured = [has_speed and own for own in good(told, Quantity.AXLE_SPEED, len(estimate.wheelsets))]
        wheels = self._wheel_watch.judge(estimate, measured)
        speeds_are_good = all(measured) and WheelState.CONTRADICTED not in wheels
        forces = self._force_watch.judge(estimate, _arriving(told, len(wheels)), speeds_are_good=speeds_are_good)
        return tuple(self._beside_others(report, wheels, forces) for report in told), wheels

    def _beside_others(
        self, report: InputReport, wheels: tuple[WheelState, ...], forces: tuple[ForceState, ...]
    ) -> InputReport:
        """The report as it is in view of all the others."""
        condition = report.condition
        if condition is InputCondition.GOOD:
            is_wheel = report.quantity is Quantity.AXLE_SPEED and wheels[report.wheelset] is WheelState.CONTRADICTED
            is_speed = report.quantity is Quantity.SPEED and self._wheel_watch.speed_is_contradicted
            is_force = report.quantity is Quantity.PRESSING_FORCE and forces[report.wheelset] is ForceState.CONTRADICTED
            condition = InputCondition.CONTRADICTED if is_wheel or is_speed or is_force else condition
        elif report.quantity is Quantity.PRESSING_FORCE and condition is InputCondition.FROZEN:
            condition = InputCondition.GOOD if forces[report.wheelset] is ForceState.BORNE_OUT else condition
        return report if condition is report.condition else replace(report, condition=condition)

    def _is_due(self, fused: bool, elapsed_s: float) -> bool:
        """The first chance in each output period; at rate 0 every fused frame, and one a second when blind."""
        if self._rate_hz == 0.0 and fused:
            return True
        turn = floor(elapsed_s * (self._rate_hz or 1.0))
        is_new = turn != self._turn
        self._turn = turn
        return is_new


def _contradicted(inputs: tuple[InputReport, ...]) -> frozenset[tuple[Quantity, int]]:
    """What the estimator is not to believe, and does not know by itself."""
    return frozenset(
        (report.quantity, report.wheelset)
        for report in inputs
        if (report.condition is InputCondition.CONTRADICTED and report.quantity in ESSENTIAL)
        or (report.condition is InputCondition.FROZEN and report.quantity is Quantity.PRESSING_FORCE)
    )


def _arriving(inputs: tuple[InputReport, ...], wheelset_count: int) -> list[bool]:
    """Whether each pressing force arrives, believable by itself or standing still."""
    bad = {
        report.wheelset
        for report in inputs
        if report.quantity is Quantity.PRESSING_FORCE
        and report.condition not in {InputCondition.GOOD, InputCondition.FROZEN}
    }
    return [i not in bad for i in range(wheelset_count)]
