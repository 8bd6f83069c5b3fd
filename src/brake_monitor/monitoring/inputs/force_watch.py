"""Whether each pressing force is to be believed, by what its brake does.

A sensor that says 0 while its brake works reads like a brake that does not come; one that is stuck high reads like a
brake that drags. Wheelset and wagon do not care what a sensor says: a braked wheelset creeps in proportion to its brake
torque, and a wagon by itself retards by it; one in a train retards as the train does. Nothing is said by these while
anything slides, nor where neither is clear enough. But who slides time and again is braked time and again.
"""

from collections import deque
from collections.abc import Collection, Sequence
from math import hypot, inf, sqrt
from statistics import median

from msgspec import Struct

from brake_monitor.estimation.core.prediction import PAUSE_S
from brake_monitor.estimation.core.regime_watch import PRESSES_N, SHOWN_S
from brake_monitor.estimation.estimate import MOTORS_ERR, Estimate
from brake_monitor.estimation.model.wagon import GRAVITY_MPS2
from brake_monitor.estimation.rolling.radius_calibration import LEAST_SPEED_MPS
from brake_monitor.monitoring.creep_meter import (
    AVERAGE_S,
    LEAST_CREEP,
    SOFTEST,
    STIFFEST,
    Creep,
    CreepMeter,
    SpeedRatios,
)
from brake_monitor.monitoring.inputs.retardation import Retardation
from brake_monitor.monitoring.inputs.watched_force import (
    INDEPENDENT,
    SURE_SIGMAS,
    WORKS,
    ForceState,
    ShownShare,
    WatchedForce,
)
from brake_monitor.settings.config import EstimatorSettings, Vehicle

STEADY_S = 1.8  # the same brakes have pressed for this long: speeds and creep have settled
SETTLED_S = 3.0  # after a slide
LINE_STD_MPS2 = 0.02  # by so much the gradient may have changed since the wagon rolled freely
LATE_STD_S = 0.03  # the vehicle's speed comes late, as behind a filter: all wheelsets seem to creep more under a brake
USUALLY_STIFFEST = 100.0  # adhesion over creep, of most contacts
LEAST_RETARDATION_MPS2 = 0.12  # to be expected, for a force that fell; less is lost in gradients
GREATEST_REST = 2.0  # retardation by the other brakes, over that of the one in doubt: their friction is not known well
FELL_S = 0.5  # a force that dies falls as quickly
COMPARED_S = 2.2  # after the fall, by when the mean retardation no longer contains it
STEADY = 0.1  # of the pressing force
OTHERS_CHANGED = 0.3  # of the greater force; then the retardation says nothing of one brake


class ForceWatch:
    """Sees the wagon at each observation, in order of time."""

    def __init__(
        self, vehicle: Vehicle, estimator: EstimatorSettings, sensors: Sequence[Sequence[int]], ratios: SpeedRatios
    ) -> None:
        """`sensors`: of each wheelset those whose pressing forces are told by the same signal, itself among them."""
        radii_m = zip(vehicle.brake_radius_m, vehicle.wheel_radius_m, strict=True)
        self._levers = [brake_m / wheel_m for brake_m, wheel_m in radii_m]
        self._contact_force_n = estimator.contact_force_n
        self._friction = estimator.friction_nominal
        self._sensors = sensors
        self._ratios = ratios
        self._creep = CreepMeter(ratios)
        self._retardation = Retardation(vehicle)
        self._is_in_train = estimator.preset == "train"
        self._past: deque[_Moment] = deque()
        self._speeds_were_good = True
        self._measured: Sequence[bool] = ()  # as of the last observation
        self._slid_s = self._changed_s = -inf
        self._applied_s = self._pressed_s = -inf  # when brakes came on after all had been released, when any pressed
        self._pressing: tuple[bool, ...] = ()
        self._creep_per_n = 0.0  # of those that press, mean since the same ones have, while they are watched ...
        self._crept = 0  # ... observations
        self._late_per_n = 0.0  # what a late speed may have had in it ...
        self._learned_late_per_n = 0.0  # ... and in what brakes have learned
        self._brakes = [WatchedForce() for _ in self._levers]
        self.may_press_unseen = False  # a brake, while the others press by their sensors: nothing has shown yet
        self.idle = frozenset[int]()  # wheelsets whose brakes have shown to do nothing, and have not pressed since

    def judge(
        self, now: Estimate, measured: Sequence[bool], *, frozen: Collection[int] = (), speeds_are_good: bool
    ) -> tuple[ForceState, ...]:
        """What is thought of each; `measured`: whether each arrives and is good by itself.

        Those that are `frozen` are judged, and tell nothing of the others.
        """
        forces_n, motor_acts = now.forces_n, now.a_motor_acts
        if speeds_are_good and not self._speeds_were_good:  # the estimated speed is put right with a jump
            self._ratios.forget_lately()
            self._retardation.forget_lately()
        self._speeds_were_good = speeds_are_good
        known = [measured[i] and brake.state is not ForceState.CONTRADICTED for i, brake in enumerate(self._brakes)]
        self._creep.note(now, known)
        if not self._is_in_train:
            rolls_freely = max(forces_n) < self._contact_force_n and not motor_acts and all(known)
            self._retardation.see(now, rolls_freely=rolls_freely)
        told = [is_told and was for is_told, was in zip(measured, self._measured or measured, strict=True)]
        self._measured = measured
        self._note(now, _Moment(now.time_s, forces_n, told, None if motor_acts else self._retardation.total_mps2))
        self.may_press_unseen = self._may_press_unseen(now.time_s, known)
        if speeds_are_good:
            for i, brake in enumerate(self._brakes):
                if measured[i]:
                    brake.see_slides(now, i, presses=self._pressing[i])
        if speeds_are_good and now.time_s - self._slid_s >= SETTLED_S and self._may_show():
            believed = [is_known and i not in frozen for i, is_known in enumerate(known)]
            judged = [i for i, is_told in enumerate(measured) if is_told and all(believed[:i] + believed[i + 1 :])]
            creep = self._creep.creep(now)
            if not all(self._pressing):
                if creep is not None and now.time_s - self._changed_s >= STEADY_S:
                    self._see_creep(creep, now)
                for i in judged:
                    self._judge(i, now, creep)
            elif creep is not None and len(self._brakes) > 1 and self._is_steady(now.time_s):
                for i in judged:
                    self._brakes[i].learn(creep[i].value / self._forces_n[i])
                late_per_n = _late_std(now) / median(self._forces_n)
                learned = max(brake.learned for brake in self._brakes)
                self._learned_late_per_n += (late_per_n - self._learned_late_per_n) / max(learned, 1)
        states = tuple([brake.state for brake in self._brakes])
        borne_out = [i for i, state in enumerate(states) if state is ForceState.BORNE_OUT]
        self.idle = frozenset([i for i in borne_out if not self._pressing[i]])
        return states

    @property
    def _forces_n(self) -> tuple[float, ...]:
        """By what was noted last."""
        return self._past[-1].forces_n

    @property
    def may_be_idle(self) -> bool:
        """Whether brakes press by their sensors, and the wagon retards rather as if none of them did."""
        pressing = [brake for brake, presses in zip(self._brakes, self._pressing, strict=True) if presses]
        return bool(pressing) and all(brake.may_be_idle for brake in pressing)

    def _may_show(self) -> bool:
        """Whether there is anything to judge: nothing is said of brakes that all have been released for a while."""
        most_n = max(self._forces_n)
        pressed_n = max(self._past[0].forces_n)
        return most_n >= self._contact_force_n or most_n >= PRESSES_N or pressed_n >= PRESSES_N

    def _may_press_unseen(self, time_s: float, known: Sequence[bool]) -> bool:
        """Whether one is silent as the others press, and it is still too early to say why, or the wagon says it works.

        While wheelsets slide it may have been vented, if it has come on before.
        """
        if all(self._pressing) or not all(known):
            return False
        is_early = time_s - self._changed_s < SHOWN_S and time_s - self._slid_s >= SETTLED_S
        has_begun = time_s - self._applied_s < SHOWN_S
        forces_n = self._forces_n
        return any(
            not presses
            and (is_early or (has_begun and not brake.has_pressed) or brake.may_press_unseen)
            and brake.state is ForceState.UNKNOWN
            and min(forces_n[:i] + forces_n[i + 1 :], default=0.0) >= PRESSES_N
            for i, (presses, brake) in enumerate(zip(self._pressing, self._brakes, strict=True))
        )

    def _note(self, now: Estimate, moment: "_Moment") -> None:
        if self._past and self._past[-1].time_s > now.time_s:  # the clock was set back
            self._past.clear()
            self._slid_s = self._changed_s = now.time_s
        self._past.append(moment)
        while now.time_s - self._past[0].time_s > COMPARED_S + FELL_S:
            self._past.popleft()
        if now.saturated or now.protection_acts:
            self._slid_s = now.time_s
        pressing = tuple([force_n >= self._contact_force_n for force_n in moment.forces_n])
        self._note_application(now.time_s, pressing)
        if pressing == self._pressing:
            return
        for brake, presses, pressed in zip(self._brakes, pressing, self._pressing or pressing, strict=True):
            if presses is not pressed:
                brake.forget()
        self._pressing, self._changed_s, self._crept = pressing, now.time_s, 0

    def _note_application(self, time_s: float, pressing: tuple[bool, ...]) -> None:
        """Note when brakes came on, and which have since."""
        if not any(pressing):
            return
        begins = not 0.0 <= time_s - self._pressed_s <= PAUSE_S
        if begins:
            self._applied_s = time_s
        self._pressed_s = time_s
        for brake, presses in zip(self._brakes, pressing, strict=True):
            brake.has_pressed = presses or (brake.has_pressed and not begins)

    def _see_creep(self, creep: Sequence[Creep], now: Estimate) -> None:
        """Add up how far those creep that press: what the vehicle's speed errs by for a moment is none of it."""
        pressing = [
            (own.value, force_n) for own, force_n in zip(creep, self._forces_n, strict=True) if force_n >= PRESSES_N
        ]
        if pressing:
            self._crept += 1
            creep_per_n = median([value / force_n for value, force_n in pressing])
            late_per_n = _late_std(now) / median([force_n for _, force_n in pressing])
            self._creep_per_n += (creep_per_n - self._creep_per_n) / self._crept
            self._late_per_n += (late_per_n - self._late_per_n) / self._crept

    def _judge(self, i: int, now: Estimate, creep: Sequence[Creep] | None) -> None:
        brake, forces_n = self._brakes[i], self._forces_n
        own_n, others_n = forces_n[i], forces_n[:i] + forces_n[i + 1 :]
        if self._died(i, now):
            brake.state = ForceState.CONTRADICTED
        if not others_n or now.time_s - self._changed_s < STEADY_S:
            return
        is_alone = self._pressing[i] and max(others_n) < self._contact_force_n
        is_missing = not self._pressing[i] and median(others_n) >= PRESSES_N
        if is_alone or is_missing:
            as_if_n = own_n if is_alone else median(others_n)
            by_creep = None if creep is None else self._share_of_sensor(i, as_if_n, creep, now.mass_kg)
            brake.see(by_creep, self._share_by_retardation(i, as_if_n, now.mass_kg), presses=is_alone)

    def _share_by_retardation(self, i: int, as_if_n: float, mass_kg: float) -> ShownShare | None:
        """What brake i takes from the speed, over what `as_if_n` would; None where that cannot be told.

        Where others are as silent as it is, as those of its cylinder, it is what all of them take over what all would.
        """
        in_doubt = [i] if self._pressing[i] else [k for k, presses in enumerate(self._pressing) if not presses]
        expected_mps2 = sum(self._expected_mps2(k, as_if_n, mass_kg) for k in in_doubt)
        rest = [self._expected_mps2(k, own_n, mass_kg) for k, own_n in enumerate(self._forces_n) if k not in in_doubt]
        rest_mps2 = sum(rest)
        by_brakes_mps2 = self._retardation.by_brakes_mps2
        is_clear = expected_mps2 > rest_mps2 / GREATEST_REST
        if not is_clear or by_brakes_mps2 is None or self._retardation.is_pulled:
            return None
        std_mps2 = hypot(LINE_STD_MPS2, MOTORS_ERR * self._retardation.by_motors_mps2)
        return ShownShare((by_brakes_mps2 - rest_mps2) / expected_mps2, std_mps2 / expected_mps2)

    def _share_of_sensor(self, i: int, as_if_n: float, creep: Sequence[Creep], mass_kg: float) -> ShownShare | None:
        """The same by creep, of all brakes of the sensor of brake i: it is right or wrong for all of them."""
        shares = [self._share_by_creep(k, as_if_n, creep, mass_kg) for k in self._sensors[i]]
        told = [share for share in shares if share is not None]
        if len(told) < len(shares):
            return None
        value = sum(share.value for share in told) / len(told)
        return ShownShare(value, max(share.lasting_std for share in told), max(share.noise_std for share in told))

    def _share_by_creep(self, i: int, as_if_n: float, creep: Sequence[Creep], mass_kg: float) -> ShownShare | None:
        """The same by how its wheelset creeps against those of other sensors: what the speed errs by is common to all.

        How much it is expected to creep is not known as well: the speed's errors are part of what the others do.
        """
        forces_n = self._forces_n
        others = [k for k in range(len(creep)) if k not in self._sensors[i]]
        if not others:
            return None
        learned = [brake.creep_per_n for brake in self._brakes if brake.creep_per_n is not None]
        expected = as_if_n * (median(learned) if learned else self._creep_per_n)
        if expected < LEAST_CREEP:
            return None
        adhesion = self._expected_mps2(i, as_if_n, mass_kg) * len(creep) / GRAVITY_MPS2
        count = max(brake.learned for brake in self._brakes) if learned else self._crept
        common_std = creep[i].common_std(AVERAGE_S * max(count / INDEPENDENT, 1.0))
        least = max(expected - SURE_SIGMAS * common_std, min(expected, adhesion / STIFFEST))
        if len(others) > 1:  # else the other one's own creep is looked at as well
            late_std = as_if_n * (self._learned_late_per_n if learned else self._late_per_n)
            least = max(least - SURE_SIGMAS * late_std, min(least, adhesion / USUALLY_STIFFEST))
        most = min(expected + SURE_SIGMAS * common_std, max(expected, adhesion / SOFTEST))
        lag = median([creep[k].value for k in others]) - creep[i].value
        whole = median([forces_n[k] for k in others]) / as_if_n
        ends = [max(whole - lag / creeps, 0.0) for creeps in (least, most)]
        own, per_creep = sum(ends) / 2.0, (1.0 / least + 1.0 / most) / 2.0
        reference_std = hypot(creep[i].reference_std, max(creep[k].reference_std for k in others)) * per_creep
        noise_std = sqrt(creep[i].noise_s + max(creep[k].noise_s for k in others) / len(others)) * per_creep
        std = hypot(reference_std, (ends[0] - ends[1]) / 2.0 / SURE_SIGMAS)
        if len(others) > 1:
            return ShownShare(own, std, noise_std)
        alone, alone_std = creep[i].value * per_creep, creep[i].common_lasting_std * per_creep
        share = median([own, WORKS, alone])  # it may be the other one that lies
        return ShownShare(share, hypot(std, alone_std), noise_std)

    def _is_steady(self, time_s: float) -> bool:
        """Whether all brakes press as they did a while ago, so that creep is theirs."""
        before, now = self._past[0], self._past[-1]
        if time_s - self._changed_s < STEADY_S or min(now.forces_n) < PRESSES_N:
            return False
        pairs = zip(before.forces_n, now.forces_n, strict=True)
        return all(abs(now_n - before_n) < STEADY * before_n for before_n, now_n in pairs)

    def _expected_mps2(self, i: int, force_n: float, mass_kg: float) -> float:
        """What such a force takes from the speed with nominal friction."""
        return self._friction * force_n * self._levers[i] / mass_kg

    def _died(self, i: int, now: Estimate) -> bool:
        """Whether the force fell to nothing alone a while ago, and the wagon did not notice.

        One that was not told then was held, whatever its brake did: it has not fallen now.
        """
        before = self._past[0]
        if before.forces_n[i] < PRESSES_N or self._pressing[i] or not before.told[i]:
            return False
        if min(now.time_s - before.time_s, before.time_s - self._applied_s) < COMPARED_S or before.total_mps2 is None:
            return False
        since = [past for past in self._past if past.time_s >= before.time_s + FELL_S]
        total_mps2 = self._past[-1].total_mps2
        if any(past.forces_n[i] >= self._contact_force_n for past in since) or total_mps2 is None:
            return False
        others_mps2 = 0.0  # more than before
        for k, before_n in enumerate(before.forces_n):
            now_n = self._past[-1].forces_n[k]
            if k == i:
                continue
            if abs(now_n - before_n) > OTHERS_CHANGED * max(now_n, before_n):
                return False
            others_mps2 += self._expected_mps2(k, now_n - before_n, now.mass_kg)
        expected_mps2 = self._expected_mps2(i, before.forces_n[i], now.mass_kg)
        told = [past.total_mps2 for past in self._past if past.total_mps2 is not None]
        missing_mps2 = max(told) + others_mps2 - total_mps2  # these means follow a brake that has just come on
        return expected_mps2 > LEAST_RETARDATION_MPS2 and missing_mps2 < WORKS * expected_mps2


def _late_std(now: Estimate) -> float:
    """By how much all wheelsets may seem to creep for a speed that comes late."""
    retardation_mps2 = now.adhesion * GRAVITY_MPS2 + now.deceleration_mps2
    return LATE_STD_S * max(retardation_mps2, 0.0) / max(now.speed_mps, LEAST_SPEED_MPS)


class _Moment(Struct, frozen=True):
    time_s: float
    forces_n: tuple[float, ...]
    told: Sequence[bool]  # whether each was measured then and at the observation before: else it is what was held
    total_mps2: float | None  # retardation, mean before; None while motors have a part in it
