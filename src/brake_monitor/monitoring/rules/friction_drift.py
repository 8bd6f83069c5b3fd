"""Friction drift: pads whose friction changes from stop to stop are glazed, wet, worn out or have been swapped."""

from math import hypot
from statistics import median

from brake_monitor.monitoring.alarm import Severity
from brake_monitor.monitoring.rule import FINE, UNKNOWN, Finding, Verdict
from brake_monitor.monitoring.rules.per_application import Applications, PerApplication
from brake_monitor.settings.alarm_settings import FrictionDriftRule

SIGNIFICANT_SIGMAS = 3.0
STD_PER_MAD = 1.4826  # of a normal distribution


class FrictionDrift(PerApplication[FrictionDriftRule]):
    """Judges the trend of each wheelset's friction over its last brake applications; one odd value does not count."""

    kind = "friction_drift"

    def _judge_applications(self, i: int, applications: Applications) -> Verdict:
        own = [record.wheelsets[i] for record in applications]
        counted = [one for one in own if one.tells_friction(self.settings.min_energy_j)][-self.settings.stops :]
        if len(counted) < self.settings.min_stops:
            return UNKNOWN
        told = [wheelset.friction or 0.0 for wheelset in counted]
        change, scatter = trend(told)
        std = hypot(scatter, median([wheelset.own_friction_std for wheelset in counted]))
        change, change_std = change / self._nominal, std / self._nominal
        if abs(change) <= max(self.settings.limit, SIGNIFICANT_SIGMAS * change_std):
            return FINE if abs(change) < self.settings.limit - self.settings.clear_margin else UNKNOWN
        return Finding(
            Severity.WARNING,
            f"The friction of the pads of wheelset {i + 1} {'rose' if change > 0.0 else 'fell'} by {abs(change):.0%} "
            f"of nominal over the last {len(told)} brake applications.",
            {"change": change, "change_std": change_std, "stops": float(len(told)), "friction": told[-1]},
        )


def trend(values: list[float]) -> tuple[float, float]:
    """Change from the first to the last of equally spaced values along their Theil-Sen line, and its deviation.

    The line's slope is the median of the slopes between all pairs; the scatter around it is told by the median
    absolute residual, so that a few outliers among the values change neither.
    """
    count = len(values)
    slope = median((values[b] - values[a]) / (b - a) for a in range(count) for b in range(a + 1, count))
    level = median(value - slope * k for k, value in enumerate(values))
    scatter = STD_PER_MAD * median(abs(value - level - slope * k) for k, value in enumerate(values))
    slope_std = scatter * (12.0 / (count * (count * count - 1.0))) ** 0.5
    return slope * (count - 1), slope_std * (count - 1)
