"""Whether each pressing force is to be believed, by what its brake does.

A sensor that says 0 while its brake works reads like a brake that does not come; one that is stuck high reads like a
brake that drags. Wheelset and wagon do not care what a sensor says: a braked wheelset creeps in proportion to its brake
torque, and a wagon by itself retards by it; one in a train retards as the train does. Nothing is said by these while
anything slides, nor where neither is clear enough. But who slides time and again is braked time and again.
"""

from collections.abc import Collection, Sequence
from statistics import median

from brake_monitor.estimation.core.regime_watch import PRESSES_N, SHOWN_S
from brake_monitor.estimation.estimate import Estimate
from brake_monitor.monitoring.creep_meter import Creep, CreepMeter
from brake_monitor.monitoring.inputs.fallen_force import has_died
from brake_monitor.monitoring.inputs.force_by_creep import ForceByCreep
from brake_monitor.monitoring.inputs.force_by_retardation import ForceByRetardation
from brake_monitor.monitoring.inputs.nominal_brakes import NominalBrakes
from brake_monitor.monitoring.inputs.pressed_brakes import Moment, PressedBrakes
from brake_monitor.monitoring.inputs.retardation import Retardation
from brake_monitor.monitoring.inputs.watched_force import ForceState, WatchedForce
from brake_monitor.settings.config import EstimatorSettings, Vehicle

SETTLED_S = 3.0  # after a slide


class ForceWatch:
    """Sees the wagon at each observation, in order of time."""

    def __init__(
        self, vehicle: Vehicle, estimator: EstimatorSettings, sensors: Sequence[Sequence[int]], creep: CreepMeter
    ) -> None:
        """`sensors`: of each wheelset those whose pressing forces are told by the same signal, itself among them."""
        count, self._contact_force_n = vehicle.wheelset_count, estimator.contact_force_n
        self._creep = creep
        self._retardation = Retardation(vehicle)
        self._is_in_train = estimator.preset == "train"
        self._nominal = NominalBrakes(vehicle, estimator)
        self._by_creep = ForceByCreep(sensors, self._nominal)
        self._by_retardation = ForceByRetardation(self._retardation, self._nominal)
        self._brakes = PressedBrakes(self._contact_force_n, count)
        self._forces = [WatchedForce() for _ in range(count)]
        self._speeds_were_good = True
        self.may_press_unseen = False  # a brake, while the others press by their sensors: nothing has shown yet
        self.idle = frozenset[int]()  # wheelsets whose brakes have shown to do nothing, and have not pressed since

    def judge(
        self, now: Estimate, measured: Sequence[bool], *, frozen: Collection[int] = (), speeds_are_good: bool
    ) -> tuple[ForceState, ...]:
        """What is thought of each; `measured`: whether each arrives and is good by itself.

        Those that are `frozen` are judged, and tell nothing of the others.
        """
        if speeds_are_good and not self._speeds_were_good:  # the estimated speed is put right with a jump
            self._creep.forget_lately()
            self._retardation.forget_lately()
        self._speeds_were_good = speeds_are_good
        known = [measured[i] and force.state is not ForceState.CONTRADICTED for i, force in enumerate(self._forces)]
        self._note(now, measured, known)
        self.may_press_unseen = self._may_press_unseen(now, known)
        if speeds_are_good:
            for i, force in enumerate(self._forces):
                if measured[i]:
                    force.see_slides(now, i, presses=self._brakes.pressing[i])
            if now.time_s - self._brakes.slid.time_s >= SETTLED_S and self._brakes.may_show:
                believed = [is_known and i not in frozen for i, is_known in enumerate(known)]
                judged = [i for i, told in enumerate(measured) if told and all(believed[:i] + believed[i + 1 :])]
                self._judge_each(judged, now)
        states = tuple([force.state for force in self._forces])
        borne_out = [i for i, state in enumerate(states) if state is ForceState.BORNE_OUT]
        self.idle = frozenset([i for i in borne_out if not self._brakes.pressing[i]])
        return states

    @property
    def may_be_idle(self) -> bool:
        """Whether brakes press by their sensors, and the wagon retards rather as if none of them did."""
        pressing = [force for force, presses in zip(self._forces, self._brakes.pressing, strict=True) if presses]
        return bool(pressing) and all(force.may_be_idle for force in pressing)

    def _note(self, now: Estimate, measured: Sequence[bool], known: Sequence[bool]) -> None:
        """Note what brakes, wheelsets and wagon do."""
        self._creep.note(now, known)
        if not self._is_in_train:
            is_free = max(now.forces_n) < self._contact_force_n and not now.a_motor_acts and all(known)
            self._retardation.see(now, rolls_freely=is_free)
        total_mps2 = None if now.a_motor_acts else self._retardation.total_mps2
        changed = self._brakes.note(now, Moment(now.time_s, now.forces_n, measured, total_mps2))
        if changed:
            self._by_creep.begin()
        for i in changed:
            self._forces[i].forget()

    def _may_press_unseen(self, now: Estimate, known: Sequence[bool]) -> bool:
        """Whether one is silent as the others press, and it is still too early to say why, or the wagon says it works.

        While wheelsets slide it may have been vented, if it has come on before.
        """
        brakes, forces_n = self._brakes, now.forces_n
        if all(brakes.pressing) or not all(known):
            return False
        is_early = now.time_s - brakes.changed.time_s < SHOWN_S and now.time_s - brakes.slid.time_s >= SETTLED_S
        has_begun = now.time_s - brakes.applied_s < SHOWN_S
        return any(
            not brakes.pressing[i]
            and (is_early or (has_begun and not brakes.have_pressed[i]) or force.may_press_unseen)
            and force.state is ForceState.UNKNOWN
            and min(forces_n[:i] + forces_n[i + 1 :], default=0.0) >= PRESSES_N
            for i, force in enumerate(self._forces)
        )

    def _judge_each(self, judged: Sequence[int], now: Estimate) -> None:
        """Judge these by what shows now, or learn of them how far wheelsets creep, where all brakes press."""
        creep = self._creep.creep(now)
        if not all(self._brakes.pressing):
            if creep is not None and self._brakes.are_the_same:
                self._by_creep.see(creep, now)
            for i in judged:
                self._judge(i, now, creep)
        elif len(self._forces) > 1 and self._brakes.are_steady:
            self._by_retardation.learn(now)
            if creep is not None:
                self._by_creep.learn(judged, creep, now)

    def _judge(self, i: int, now: Estimate, creep: Sequence[Creep] | None) -> None:
        force, presses, forces_n = self._forces[i], self._brakes.pressing[i], now.forces_n
        if has_died(i, self._brakes, self._nominal, now.mass_kg):
            force.state = ForceState.CONTRADICTED
        others_n = forces_n[:i] + forces_n[i + 1 :]
        if not others_n or not self._brakes.are_the_same:
            return
        is_alone = presses and max(others_n) < self._contact_force_n
        is_missing = not presses and median(others_n) >= PRESSES_N
        if is_alone or is_missing:
            as_if_n = forces_n[i] if is_alone else median(others_n)
            by_creep = None if creep is None else self._by_creep.share(i, as_if_n, creep, now)
            by_retardation = self._by_retardation.share(i, as_if_n, self._brakes.pressing, now)
            force.see(by_creep, by_retardation, presses=is_alone)
