"""What is to be thought of each mapped signal, in view of itself and of all the others."""

from collections.abc import Callable, Mapping, Sequence, Set

import numpy as np
from msgspec.structs import replace

from brake_monitor.decoding.sample_block import SampleBlock
from brake_monitor.estimation.doubts.consistency import Doubt
from brake_monitor.estimation.estimate import Estimate
from brake_monitor.monitoring.alarm import Alarm, signals_in
from brake_monitor.monitoring.creep_meter import CreepMeter
from brake_monitor.monitoring.inputs.block_watch import BlockWatch
from brake_monitor.monitoring.inputs.dead_forces import DeadForces
from brake_monitor.monitoring.inputs.flag_watch import FlagWatch
from brake_monitor.monitoring.inputs.force_watch import ForceWatch
from brake_monitor.monitoring.inputs.frozen_forces import FrozenForces
from brake_monitor.monitoring.inputs.lone_inputs import LoneInputs
from brake_monitor.monitoring.inputs.refusals import Refusals
from brake_monitor.monitoring.inputs.scatter_watch import ScatterWatch
from brake_monitor.monitoring.inputs.watched_force import ForceState
from brake_monitor.monitoring.inputs.watched_wheelset import Origin
from brake_monitor.monitoring.inputs.wheel_state import WheelState
from brake_monitor.monitoring.inputs.wheel_watch import WheelWatch
from brake_monitor.monitoring.misled import MisledBy
from brake_monitor.monitoring.reports import InputReport, InputReports
from brake_monitor.samples import Channel, InputCondition, Measurand, Quality, Quantity, Sample
from brake_monitor.settings.config import Settings

GOOD = Quality.GOOD
CONTRADICTED = InputCondition.CONTRADICTED
WRONG = (CONTRADICTED, InputCondition.IMPOSSIBLE)
SPEED, AXLE_SPEED, PRESSING_FORCE = Quantity.SPEED, Quantity.AXLE_SPEED, Quantity.PRESSING_FORCE
NONE_UNLESS_TOLD = {Quantity.WSP_ACTIVE, Quantity.WHEEL_TORQUE}  # while one is not good it is taken to say 0
MAY_ROLL = {WheelState.ROLLING, WheelState.UNKNOWN, WheelState.CONTRADICTED}  # of such a wheelset no slide is known
LOCKED, DRAGGED = frozenset([MisledBy.LOCKED]), frozenset([MisledBy.DRAG])
SILENT, IDLE = frozenset([MisledBy.SILENT]), frozenset([MisledBy.IDLE])
NOT_MISLED = frozenset[MisledBy]()


class InputJudge:
    """Watches the signals one by one, speeds beside each other, forces and flags beside what brakes and wheels do."""

    def __init__(self, settings: Settings, channels: Sequence[Channel], creep: CreepMeter) -> None:
        """`creep` is what others ask as well."""
        contact_force_n = settings.estimator.contact_force_n
        self._refusals = Refusals(channels)
        self._refused = self._refusals.refused  # of a signal that says something good again it forgets
        self._frozen = FrozenForces(channels, contact_force_n)
        self._wheels = WheelWatch(settings.vehicle, contact_force_n, is_in_train=settings.estimator.preset == "train")
        self._alone = LoneInputs(channels, self._refusals, self._wheels)
        self._scatter = ScatterWatch(settings.vehicle.wheelset_count)
        self._flags = FlagWatch(channels, settings.vehicle.wheelset_count, contact_force_n)
        watching = (self._frozen.watchers, self._wheels.watchers, self._flags.watchers)
        self._watchers = {  # who is to see what is said of a measurand
            channel.measurand: [part[channel.measurand] for part in watching if channel.measurand in part]
            for channel in channels
        }
        self._block: SampleBlock | None = None  # whose samples are being taken, by:
        self._block_watch: BlockWatch | None = None
        self._forces = ForceWatch(settings.vehicle, settings.estimator, _by_sensor(channels), creep)
        self._dead = DeadForces(contact_force_n)
        self._froze = frozenset[int]()  # as of the last observation

    def resume(self, open_alarms: Sequence[Alarm]) -> None:
        """Go on with wheelsets that stood, and with speeds and forces that were wrong: 0 of them need not be true."""
        stood = {alarm.wheelset for alarm in open_alarms if alarm.kind == "wheelset_not_rotating"}
        for i, wheel in enumerate(self._wheels.wheels, 1):
            if i in stood:
                wheel.unseen = Origin.STOPPED
        told = {pair for alarm in open_alarms for pair in signals_in(alarm.evidence)}
        for channel in (report.channel for report in self._alone.reports):
            if told.isdisjoint((channel.source, condition) for condition in WRONG):
                continue
            if channel.quantity is AXLE_SPEED:
                self._wheels.wheels[channel.wheelset].unseen = Origin.DROPPED
            elif channel.quantity is PRESSING_FORCE:
                self._dead.resume(channel.wheelset)

    def see(self, sample: Sample) -> None:
        """Take a sample as it was decoded."""
        time_s, quantity, wheelset, value, quality = sample
        measurand = (quantity, wheelset)
        if quality is GOOD:
            if self._refused:
                self._refused.pop(measurand, None)
            for see in self._watchers[measurand]:
                see(time_s, value)
        else:
            self._refusals.refuse(sample)
            if quantity in NONE_UNLESS_TOLD:
                for see in self._watchers[measurand]:
                    see(time_s, 0.0)

    def see_together(self, samples: SampleBlock, begin: int, end: int) -> None:
        """Take the samples in these places of a block, as `see` takes each."""
        if samples is not self._block:
            self._begin(samples)
        watch = self._block_watch
        if watch is not None and not self._refused and watch.are_ordinary(begin, end):
            watch.pass_over(begin, end)
            return
        for sample in samples.at(np.arange(begin, end)):
            self.see(sample)

    def _begin(self, samples: SampleBlock) -> None:
        self._block = samples
        self._block_watch = BlockWatch(samples, self._frozen, self._wheels, self._flags)

    def judge(
        self, estimate: Estimate, condition: Callable[[Measurand], InputCondition], changes: int
    ) -> tuple[InputReports, tuple[WheelState, ...]]:
        """One report per signal and one state per wheelset; `condition` is what the estimator thinks of a signal.

        It thinks the same as long as its `changes` are as many.
        """
        alone = self._alone
        alone.judge(estimate.time_s, condition, changes)
        measured, arriving = alone.measured, alone.arriving
        dead = self._dead.see(estimate.time_s, estimate.forces_n, alone.impossible)
        if dead:
            arriving = [is_told and i not in dead for i, is_told in enumerate(arriving)]
        wheels = self._wheels.judge(estimate, measured)
        self._scatter.see(estimate)
        if self._scatter.wheels:  # what slides such a speed seems to tell of are none
            scattered, contradicted = self._scatter.wheels, WheelState.CONTRADICTED
            wheels = tuple([contradicted if i in scattered else state for i, state in enumerate(wheels)])
        is_contradicted = WheelState.CONTRADICTED in wheels
        speeds_are_good = all(measured) and not is_contradicted
        forces = self._forces.judge(estimate, arriving, frozen=self._froze, speeds_are_good=speeds_are_good)
        if dead:
            forces = tuple([ForceState.CONTRADICTED if i in dead else state for i, state in enumerate(forces)])
        self._froze = frozen = self._frozen_forces(estimate, arriving, wheels, forces)
        told = alone.told
        if is_contradicted:  # what its speed says shows nothing of its flag
            told = [own and state is not WheelState.CONTRADICTED for own, state in zip(told, wheels, strict=True)]
        stuck = self._flags.judge(estimate, told)
        repeats = Doubt.REPEATED in estimate.reasons
        found = self._found(wheels, forces, frozen, stuck)
        if not (found or repeats):  # the usual case
            return alone.reports, wheels
        beside = InputReports(_beside_others(report, found) for report in alone.reports)
        return InputReports(map(speed_is_repeated, beside)) if repeats else beside, wheels

    def _found(
        self, wheels: Sequence[WheelState], forces: Sequence[ForceState], frozen: Set[int], stuck: Set[int]
    ) -> dict[Measurand, InputCondition]:
        """What signals show beside each other: of each wheelset and force what it does, and whose flag is stuck."""
        wrong = {(AXLE_SPEED, i) for i, state in enumerate(wheels) if state is WheelState.CONTRADICTED}
        wrong |= {(PRESSING_FORCE, i) for i, state in enumerate(forces) if state is ForceState.CONTRADICTED}
        wrong |= {(Quantity.WSP_ACTIVE, i) for i in stuck}
        scattered = {(AXLE_SPEED, i) for i in self._scatter.wheels}
        if self._wheels.speed_is_contradicted:
            wrong.add((SPEED, 0))
        if self._scatter.speed_scatters:
            scattered.add((SPEED, 0))
        found: dict[Measurand, InputCondition] = dict.fromkeys(wrong, CONTRADICTED)
        found |= dict.fromkeys(scattered, InputCondition.SCATTERED)
        return found | {(PRESSING_FORCE, i): InputCondition.FROZEN for i in frozen}

    @property
    def misled_by(self) -> frozenset[MisledBy]:
        """Why estimates err that do not know of it, for all that can be told."""
        if self._wheels.any_is_blocked:
            return DRAGGED
        if self._forces.may_be_idle:
            return IDLE
        if self._forces.may_press_unseen:
            return SILENT
        return LOCKED if self._wheels.may_be_locked else NOT_MISLED

    @property
    def idle_brakes(self) -> frozenset[int]:
        """The wheelsets whose brakes have shown that they do nothing, see `ForceWatch`."""
        return self._forces.idle

    def _frozen_forces(
        self, now: Estimate, arriving: list[bool], wheels: tuple[WheelState, ...], forces: tuple[ForceState, ...]
    ) -> frozenset[int]:
        believed = [arriving[i] and state is not ForceState.CONTRADICTED for i, state in enumerate(forces)]
        slides = now.saturated or now.protection_acts or not MAY_ROLL.issuperset(wheels)
        frozen = self._frozen.frozen(now.time_s, now.speed_mps, believed, slides=slides)
        return frozenset([i for i in frozen if forces[i] is not ForceState.BORNE_OUT]) if frozen else frozen


def _beside_others(report: InputReport, found: Mapping[Measurand, InputCondition]) -> InputReport:
    if report.condition is not InputCondition.GOOD or report.measurand not in found:
        return report
    return replace(report, condition=found[report.measurand])


def _by_sensor(channels: Sequence[Channel]) -> list[list[int]]:
    """Of each wheelset those whose pressing forces are told by the same signal."""
    forces = sorted((one.wheelset, one.bus, one.source) for one in channels if one.quantity is PRESSING_FORCE)
    return [[i for i, *signal in forces if signal == own] for _, *own in forces]


def speed_is_repeated(report: InputReport) -> InputReport:
    """That of a speed says so unless it has something to say of this one alone; so does what is frozen with them."""
    is_speed = report.channel.quantity in (SPEED, AXLE_SPEED) and report.condition is InputCondition.GOOD
    is_told_again = is_speed or report.condition is InputCondition.FROZEN
    return replace(report, condition=InputCondition.REPEATED) if is_told_again else report
