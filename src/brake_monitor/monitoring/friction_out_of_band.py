"""Friction out of band: what a brake application's pads gave, weighted by energy, against nominal."""

from statistics import median

from brake_monitor.alarm_settings import FrictionOutOfBandRule
from brake_monitor.monitoring.alarm import Severity, Values
from brake_monitor.monitoring.creep_shares import told_apart
from brake_monitor.monitoring.observation import Observation
from brake_monitor.monitoring.per_stop import PerStop, Stops
from brake_monitor.monitoring.rule import FINE, UNKNOWN, Finding, Verdict
from brake_monitor.monitoring.stops import StopRecord, WheelsetStop

INTERVAL_SIGMAS = 1.96  # 95 %
TOGETHER = (
    0.5  # of the deviation is common to all: the cause is more likely the mass, the weather or the pressing force
)


class FrictionOutOfBand:
    """Judges the last brake application that says enough. Finds only what the estimate's own interval bears out."""

    kind = "friction_out_of_band"

    def __init__(self, settings: FrictionOutOfBandRule, nominal: float, wheelset_count: int) -> None:
        self.settings = settings
        self.places = tuple(range(1, wheelset_count + 1))
        self._nominal = nominal
        self._per_stop = PerStop(self._judge_last, wheelset_count)

    def judge(self, seen: Observation) -> tuple[Verdict, ...]:
        """One verdict per wheelset."""
        return self._per_stop.see(seen.brakes.stops)

    def closing_evidence(self, _: int | None) -> Values:
        """Nothing more than raised it."""
        return {}

    def _judge_last(self, i: int, stops: Stops) -> Verdict:
        telling = [stop for stop in stops if self._tells(stop.wheelsets[i])]
        return self._judge(i, told_apart(telling, self._nominal)) if telling else UNKNOWN

    def _judge(self, i: int, stop: StopRecord) -> Verdict:
        own = stop.wheelsets[i]
        assert own.friction is not None
        assert own.friction_std is not None
        deviation = own.friction / self._nominal - 1.0
        doubt = INTERVAL_SIGMAS * own.friction_std / self._nominal
        if abs(deviation) - doubt <= self.settings.warning:
            return FINE if abs(deviation) < self.settings.warning - self.settings.clear_margin else UNKNOWN
        return Finding(
            Severity.ALARM if abs(deviation) > self.settings.alarm else Severity.WARNING,
            f"The pads of wheelset {i + 1} had a friction of {own.friction:.2f} ± {doubt * self._nominal:.2f} in the "
            f"last brake application, {abs(deviation):.0%} {'above' if deviation > 0.0 else 'below'} nominal "
            f"({self._nominal:g}){self._what_of_the_others(i, stop, deviation)}.",
            {
                "friction": own.friction,
                "friction_std": own.friction_std,
                "friction_nominal": self._nominal,
                "energy_j": own.friction_energy_j,
                "stop_start_time_s": stop.start_time_s,
                "stop_end_time_s": stop.end_time_s,
            },
        )

    def _tells(self, wheelset: WheelsetStop) -> bool:
        return wheelset.friction is not None and wheelset.friction_energy_j >= self.settings.min_energy_j

    def _what_of_the_others(self, i: int, stop: StopRecord, deviation: float) -> str:
        others = [own.friction for k, own in enumerate(stop.wheelsets) if k != i and own.friction is not None]
        if not others:
            return ""
        common = (median(others) / self._nominal - 1.0) / deviation
        return "; so had the others: a wrong mass or force scale shows like this" if common > TOGETHER else ""
