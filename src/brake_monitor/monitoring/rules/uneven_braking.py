"""Uneven braking: one wheelset's brake torque stands apart from the others', each by the size of its brake."""

from collections.abc import Sequence
from math import hypot
from statistics import median

from brake_monitor.estimation.core.regime_watch import PRESSES_N
from brake_monitor.estimation.estimate import INTERVAL_SIGMAS
from brake_monitor.monitoring.alarm import Severity
from brake_monitor.monitoring.brake_units.application_record import ApplicationRecord
from brake_monitor.monitoring.misled import MisledBy
from brake_monitor.monitoring.observation import Observation
from brake_monitor.monitoring.rule import FINE, UNKNOWN, Finding, Verdict
from brake_monitor.monitoring.rules.per_application import Applications, PerApplication
from brake_monitor.monitoring.rules.told_apart import is_set_apart, told_apart
from brake_monitor.settings.alarm_settings import UnevenBrakingRule


class UnevenBraking(PerApplication[UnevenBrakingRule]):
    """Judges the last sufficient brake application in which all brakes pressed and nothing slid."""

    kind = "uneven_braking"
    of_pads = False

    def __init__(
        self,
        settings: UnevenBrakingRule,
        friction_nominal: float,
        brake_forces: Sequence[float],
        brake_radii_m: Sequence[float],
    ) -> None:
        """`brake_forces`: relative ones, as in `Settings`; both one per wheelset."""
        super().__init__(settings, friction_nominal, len(brake_forces))
        self._forces = tuple(brake_forces)
        self._torques = tuple(force * radius_m for force, radius_m in zip(brake_forces, brake_radii_m, strict=True))

    def judge(self, seen: Observation) -> tuple[Verdict, ...]:
        """One verdict per wheelset."""
        return (FINE,) if len(self.wheelsets) == 1 else super().judge(seen)

    def _judge_applications(self, i: int, applications: Applications) -> Verdict:
        telling = [record for record in applications if self._tells(record)]
        if not telling:
            return UNKNOWN
        shared = told_apart(telling, self._nominal)
        verdict = self._judge(i, shared, 0.0 if shared is not telling[-1] else _doubt(i, shared))
        return UNKNOWN if verdict is FINE and is_set_apart(i, telling) else verdict

    def _tells(self, record: ApplicationRecord) -> bool:
        settled = all(own.torque_nm is not None for own in record.wheelsets)
        return settled and max(own.friction_energy_j for own in record.wheelsets) >= self.settings.min_energy_j

    def _judge(self, i: int, record: ApplicationRecord, doubt: float) -> Verdict:
        """`doubt`: of how far it stands apart, where friction alone tells."""
        own = record.wheelsets[i]
        torques_nm = _by_size([wheelset.torque_nm for wheelset in record.wheelsets], self._torques)
        apart = _apart(i, torques_nm)
        if abs(apart) <= self.settings.warning:
            return FINE if abs(apart) < self.settings.warning - self.settings.clear_margin else UNKNOWN
        if apart > 0.0 and self._is_of_stronger_half(torques_nm[i], torques_nm):
            return FINE
        force_apart = _apart(i, _by_size([wheelset.pressing_force_n for wheelset in record.wheelsets], self._forces))
        by_force = abs(force_apart) > 0.5 * abs(apart) and force_apart * apart > 0.0
        if _of_others(i, record) < PRESSES_N if by_force else abs(apart) <= doubt:
            return UNKNOWN  # of a light braking sensors whose zeros differ make as much
        alike = "with the same pressing force: pads or brake gear"
        if apart < 0.0:  # creep is told against the rolling before, in which such a brake retards as well
            alike += ", or it drags when released"
        whose = self._whose(torques_nm[i], torques_nm)
        cause = f"its pressing force differs as much: brake gear or valve{whose}" if by_force else alike
        return Finding(
            Severity.ALARM if abs(apart) > self.settings.alarm else Severity.WARNING,
            f"Wheelset {i + 1} braked {abs(apart):.0%} {'more' if apart > 0.0 else 'less'} than the others in the last "
            f"brake application ({cause}).",
            {
                "torque_nm": own.torque_nm or 0.0,
                "torque_apart": apart,
                "pressing_force_n": own.pressing_force_n or 0.0,
                "pressing_force_apart": force_apart,
                "stop_start_time_s": record.start_time_s,
                "stop_end_time_s": record.end_time_s,
            },
            misled_by=None if by_force else MisledBy.UNEVEN,
        )

    def _whose(self, torque_nm: float, torques_nm: Sequence[float]) -> str:
        """Where half of all brake as little as it does, the others may press too much."""
        alike = sum(abs(other_nm - torque_nm) <= self.settings.warning * torque_nm for other_nm in torques_nm)
        if 2 * alike < len(torques_nm):
            return ""
        return " of either" if len(torques_nm) == 2 else " of either half"

    def _is_of_stronger_half(self, torque_nm: float, torques_nm: Sequence[float]) -> bool:
        """Whether half of all brake at least about as much: of two wheelsets, or bogies, the weaker one is named."""
        alike = sum(torque_nm <= (1.0 + self.settings.warning) * other_nm for other_nm in torques_nm)
        return 2 * alike >= len(torques_nm)


def _doubt(i: int, record: ApplicationRecord) -> float:
    """Half of the 95 % interval by which friction of wheelset i stands apart, relative to the others'.

    Of wheelsets that had locked little is known: their friction may differ by as much as it is in doubt.
    """
    others = [own for k, own in enumerate(record.wheelsets) if k != i and own.friction]
    if not others:
        return 0.0
    std = hypot(record.wheelsets[i].own_friction_std, median(own.own_friction_std for own in others))
    return INTERVAL_SIGMAS * std / median(own.friction or 0.0 for own in others)


def _of_others(i: int, record: ApplicationRecord) -> float:
    """The median of the others' pressing forces, N."""
    return median([own.pressing_force_n or 0.0 for k, own in enumerate(record.wheelsets) if k != i])


def _by_size(values: Sequence[float | None], sizes: Sequence[float]) -> list[float]:
    """What each would be if all brakes were of the same size."""
    return [(value or 0.0) / size for value, size in zip(values, sizes, strict=True)]


def _apart(i: int, values: list[float]) -> float:
    """How far value i lies from the median of the others, relative to it."""
    others = median(values[:i] + values[i + 1 :])
    return values[i] / others - 1.0 if others > 0.0 else 0.0
