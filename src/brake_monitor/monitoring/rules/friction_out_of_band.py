"""Friction out of band: what the pads gave in the last brake applications, weighted by energy, against nominal."""

from statistics import median

from brake_monitor.estimation.estimate import INTERVAL_SIGMAS
from brake_monitor.monitoring.alarm import Severity
from brake_monitor.monitoring.brake_units.application_record import ApplicationRecord, WheelsetRecord
from brake_monitor.monitoring.rule import FINE, UNKNOWN, Finding, Verdict
from brake_monitor.monitoring.rules.creep_shares import are_known
from brake_monitor.monitoring.rules.mean_friction import pooled
from brake_monitor.monitoring.rules.per_application import Applications, PerApplication
from brake_monitor.monitoring.rules.told_apart import is_set_apart, told_apart
from brake_monitor.settings.alarm_settings import FrictionOutOfBandRule

# Where so much of the deviation is common to all, the cause is more likely mass, weather or pressing force.
TOGETHER = 0.5


class FrictionOutOfBand(PerApplication[FrictionOutOfBandRule]):
    """Judges as few of the last brake applications as suffice, and finds only what their 95 % interval bears out.

    The last one alone where its gradient is known; stops to standstill together, since their gradients differ.
    """

    kind = "friction_out_of_band"

    def __init__(
        self,
        settings: FrictionOutOfBandRule,
        friction_nominal: float,
        wheelset_count: int,
        alike_std: float | None = None,
    ) -> None:
        """`alike_std`: of what friction errs by in all applications alike; None: all of it, as in a train."""
        super().__init__(settings, friction_nominal, wheelset_count)
        self._alike_std = alike_std

    def _judge_applications(self, i: int, applications: Applications) -> Verdict:
        least_energy_j = self.settings.min_energy_j
        telling = [record for record in applications if record.wheelsets[i].tells_friction(least_energy_j)]
        telling = telling[-self.settings.stops :]
        verdict: Verdict = UNKNOWN
        for count in range(1, len(telling) + 1):
            mean = pooled(telling[-count:], self._alike_std)
            if not self._allows(telling[-1].wheelsets[i], mean.wheelsets[i]):
                break
            shared = told_apart([*telling[:-1], mean], self._nominal)
            verdict = self._judge(i, shared, count)
            deviation, doubt = self._deviation(shared.wheelsets[i])
            if abs(abs(deviation) - self.settings.warning) > doubt:
                break
        return UNKNOWN if verdict is FINE and is_set_apart(i, telling) else verdict

    def _deviation(self, own: WheelsetRecord) -> tuple[float, float]:
        """From nominal, and half of its 95 % interval; both relative to nominal."""
        assert own.friction is not None
        assert own.friction_std is not None
        return own.friction / self._nominal - 1.0, INTERVAL_SIGMAS * own.friction_std / self._nominal

    def _allows(self, last: WheelsetRecord, mean: WheelsetRecord) -> bool:
        """Whether the last application agrees with these; else the earlier ones were with other pads."""
        deviation, doubt = self._deviation(last)
        return abs(self._deviation(mean)[0] - deviation) <= doubt

    def _judge(self, i: int, record: ApplicationRecord, count: int) -> Verdict:
        """`count`: how many applications this one stands for."""
        own = record.wheelsets[i]
        deviation, doubt = self._deviation(own)
        if abs(deviation) - doubt <= self.settings.warning:
            return FINE if abs(deviation) < self.settings.warning - self.settings.clear_margin else UNKNOWN
        applications = "brake application" if count == 1 else f"{count} brake applications"
        return Finding(
            Severity.ALARM if abs(deviation) > self.settings.alarm else Severity.WARNING,
            f"The pads of wheelset {i + 1} had a friction of {own.friction:.2f} ± {doubt * self._nominal:.2f} in the "
            f"last {applications}, {abs(deviation):.0%} {'above' if deviation > 0.0 else 'below'} nominal "
            f"({self._nominal:g}){self._what_of_the_others(i, record, deviation)}.",
            {
                "friction": own.friction,
                "friction_std": own.friction_std,
                "friction_nominal": self._nominal,
                "energy_j": own.friction_energy_j,
                "applications": float(count),
                "stop_start_time_s": record.start_time_s,
                "stop_end_time_s": record.end_time_s,
            },
        )

    def _what_of_the_others(self, i: int, record: ApplicationRecord, deviation: float) -> str:
        others = [own.friction for k, own in enumerate(record.wheelsets) if k != i and own.friction is not None]
        if not others:
            return ""
        common = (median(others) / self._nominal - 1.0) / deviation
        if common <= TOGETHER:
            return ""
        alone = "" if are_known(record) else ", or one brake that is much further off and cannot be told from them"
        return f"; so had the others: a wrong mass or force scale shows like this{alone}"
