"""Brake not applied: one brake does not press while the others do."""

from math import hypot, inf
from statistics import median

from brake_monitor.estimation.brake_work import SLIDING_SLIP
from brake_monitor.estimation.estimate import Estimate
from brake_monitor.monitoring.alarm import Severity
from brake_monitor.monitoring.creep_meter import AVERAGE_S, LEAST_CREEP, Creep, CreepMeter
from brake_monitor.monitoring.misled import MisledBy
from brake_monitor.monitoring.observation import Observation
from brake_monitor.monitoring.rule import FINE, UNKNOWN, Finding, Rule, Verdict
from brake_monitor.monitoring.rules.participation import LEAST_FRICTION, Participation
from brake_monitor.samples import InputCondition, Quantity
from brake_monitor.settings.alarm_settings import BrakeNotAppliedRule

BRAKES = 0.5  # of the others' creep: a wheelset that creeps more is braked, whatever its pressing force says
CLEAR_SIGMAS = 2.0  # of the noise; nearer to BRAKES creep says nothing


class BrakeNotApplied(Rule[BrakeNotAppliedRule]):
    """Judges pressing forces against each other.

    A sensor that says 0 while the brake works is told from a brake that does not press by what the wheelset does: with
    its brake on, it creeps as the others do. Where creep says nothing, the others' friction decides: if k brakes that
    do not press, as those of one cylinder, worked unseen, theirs would appear too high by k parts in N - k. What it may
    be as well, by its deviation, counts. A brake whose motor does its work need not press.
    """

    kind = "brake_not_applied"

    def __init__(
        self,
        settings: BrakeNotAppliedRule,
        contact_force_n: float,
        friction_nominal: float,
        wheelset_count: int,
        creep: CreepMeter,
    ) -> None:
        super().__init__(settings, wheelset_count)
        self._contact_force_n = contact_force_n
        self._others_n = max(settings.others_force_n, contact_force_n)  # below the contact force none presses
        self._nominal = friction_nominal
        self._creep = creep
        self._participation = Participation(contact_force_n, wheelset_count)
        self._released_s = [-inf] * wheelset_count  # when slide protection or a motor last acted on each brake

    def judge(self, seen: Observation) -> tuple[Verdict, ...]:
        """One verdict per wheelset."""
        now, count = seen.estimate, len(self.wheelsets)
        known = seen.inputs.are_good(Quantity.PRESSING_FORCE, count)
        self._creep.note(now, known)
        for i, wheelset in enumerate(now.wheelsets):
            if seen.motors_brake[i] or wheelset.wsp_active or wheelset.slip > SLIDING_SLIP:
                self._released_s[i] = now.time_s
        if all(known):  # in a tunnel as well
            self._participation.see(now.time_s, seen.forces_n)
        if not seen.all_good:
            return self._judge_beside_wrong_inputs(seen)
        if now.speed_mps < self.settings.min_speed_mps or max(seen.forces_n) < self._others_n:
            return (UNKNOWN,) * count
        if min(seen.forces_n) >= self._others_n:
            return (FINE,) * count
        if MisledBy.IDLE in seen.misled_by:  # it may be the sensors of those that press
            return (UNKNOWN,) * count
        creep = self._creep.creep(now)
        return tuple(self._judge(i, now, creep) for i in range(count))

    def _judge_beside_wrong_inputs(self, seen: Observation) -> tuple[Verdict, ...]:
        """Nothing can be said, but of a brake that has shown that it works: its sensor has been told to be the cause.

        Creep and retardation may take longer to show so than the alarm to be raised.
        """
        works = [
            report.channel.wheelset
            for report in seen.inputs.not_good
            if report.channel.quantity is Quantity.PRESSING_FORCE
            and report.condition is InputCondition.CONTRADICTED
            and seen.forces_n[report.channel.wheelset] < self._contact_force_n
        ]
        return tuple([FINE if i in works else UNKNOWN for i in range(len(self.wheelsets))])

    def _judge(self, i: int, now: Estimate, creep: tuple[Creep, ...] | None) -> Verdict:
        forces_n = now.forces_n
        own_n, others_n = forces_n[i], median(forces_n[:i] + forces_n[i + 1 :])
        if others_n < self._others_n:
            return UNKNOWN
        if own_n >= self._contact_force_n:
            return FINE
        lately_released = 0.0 <= now.time_s - self._released_s[i] < self.settings.wsp_wait_s
        may_be_released = lately_released or self._others_may_drag(i, now)
        seems_braked = _seems_braked(i, creep)
        if may_be_released or seems_braked or (seems_braked is None and self._friction_denies_it(i, now)):
            return UNKNOWN
        cause = "isolated, or its brake gear is stuck"
        if seems_braked is None:
            cause = "isolated, its brake gear is stuck, or its sensor says too little"
        return Finding(
            Severity.ALARM,
            f"The brake of wheelset {i + 1} does not press ({own_n / 1000.0:z.1f} kN) while the others do "
            f"({others_n / 1000.0:.1f} kN): {cause}.",
            {
                "pressing_force_n": own_n,
                "others_pressing_force_n": others_n,
                "creep": creep[i].value if creep else None,
                "others_creep": _of_others(i, creep) if creep else None,
                "speed_mps": now.speed_mps,
            },
            weighed_by="others_pressing_force_n",
        )

    def _others_may_drag(self, i: int, now: Estimate) -> bool:
        """Whether rather those that press, no more than half, have failed to release, and this one did take part."""
        never_came = self._participation.begin_was_seen and not self._participation.took_part(i)
        return 2 * self._pressing(now) <= len(self.wheelsets) and not never_came

    def _pressing(self, now: Estimate) -> int:
        return sum(force_n >= self._contact_force_n for force_n in now.forces_n)

    def _friction_denies_it(self, i: int, now: Estimate) -> bool:
        """Whether the friction of the others would be usual if this one pressed unseen, or shows that they do not."""
        others = [wheelset for k, wheelset in enumerate(now.wheelsets) if k != i]
        least = median(own.friction for own in others) / self._nominal
        most = median(own.friction + own.friction_std for own in others) / self._nominal
        pressing = self._pressing(now)
        return least <= LEAST_FRICTION or most >= 1.0 + BRAKES * (len(self.wheelsets) - pressing) / pressing


def _seems_braked(i: int, creep: tuple[Creep, ...] | None) -> bool | None:
    """Whether a wheelset creeps as the others do; None where creep says nothing."""
    if creep is None or _of_others(i, creep) <= LEAST_CREEP:
        return None
    beyond = creep[i].value - BRAKES * _of_others(i, creep)
    std = hypot(creep[i].std(AVERAGE_S), (1.0 - BRAKES) * creep[i].common_std(AVERAGE_S))
    return beyond > 0.0 if abs(beyond) > CLEAR_SIGMAS * std else None


def _of_others(i: int, creep: tuple[Creep, ...]) -> float:
    return median(own.value for own in creep[:i] + creep[i + 1 :])
