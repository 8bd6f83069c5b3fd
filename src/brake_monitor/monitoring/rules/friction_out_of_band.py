"""Friction out of band: what the pads gave in the last brake applications, weighted by energy, against nominal."""

from collections.abc import Sequence
from math import hypot, sqrt
from statistics import median

from msgspec.structs import replace

from brake_monitor.estimation.estimate import INTERVAL_SIGMAS
from brake_monitor.monitoring.alarm import Severity
from brake_monitor.monitoring.brake_units.application_record import ApplicationRecord, WheelsetRecord
from brake_monitor.monitoring.rule import FINE, UNKNOWN, Finding, Verdict
from brake_monitor.monitoring.rules.creep_shares import can_tell_apart
from brake_monitor.monitoring.rules.per_application import Applications, PerApplicationOfPads
from brake_monitor.monitoring.rules.told_apart import is_set_apart, told_apart
from brake_monitor.settings.alarm_settings import FrictionOutOfBandRule

# Where so much of the deviation is common to all, the cause is more likely mass, weather or pressing force.
TOGETHER = 0.5
# How much gradients may change is said before any stop was seen. It weighs as much as what so many stops show of it.
GUESS_STOPS = 3.0


class FrictionOutOfBand(PerApplicationOfPads[FrictionOutOfBandRule]):
    """Judges as few of the last brake applications as suffice, and finds only what their 95 % interval bears out.

    The last one alone where its gradient is known; stops to standstill together, since their gradients differ.
    """

    kind = "friction_out_of_band"

    def _judge_pads(self, i: int, applications: Applications) -> Verdict:
        least_energy_j = self.settings.min_energy_j
        telling = [record for record in applications if record.wheelsets[i].tells_friction(least_energy_j)]
        telling = telling[-self.settings.stops :]
        verdict: Verdict = UNKNOWN
        for count in range(1, len(telling) + 1):
            pooled = _pooled(telling[-count:])
            if not self._allows(telling[-1].wheelsets[i], pooled.wheelsets[i]):
                break
            shared = told_apart([*telling[:-1], pooled], self._nominal)
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

    def _allows(self, last: WheelsetRecord, pooled: WheelsetRecord) -> bool:
        """Whether the last application agrees with these; else the earlier ones were with other pads."""
        deviation, doubt = self._deviation(last)
        return abs(self._deviation(pooled)[0] - deviation) <= doubt

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
        alone = "" if can_tell_apart(record) else ", or one brake that is much further off and cannot be told from them"
        return f"; so had the others: a wrong mass or force scale shows like this{alone}"


def _pooled(records: Sequence[ApplicationRecord]) -> ApplicationRecord:
    """The last of these applications, with each wheelset's friction averaged over all of them."""
    return replace(records[-1], wheelsets=tuple(map(_mean, zip(*(one.wheelsets for one in records), strict=True))))


def _mean(records: Sequence[WheelsetRecord]) -> WheelsetRecord:
    """Of one wheelset, weighted by certainty. Errors by gradients differ from stop to stop; other errors do not.

    Stops that agree by more than gradients were taken to let them show that gradients change less there, and stops
    that scatter by more, that they change more.
    """
    known = [own for own in records if own.friction is not None and own.friction_std]
    if not known:
        return records[-1]
    weights = [1.0 / (own.friction_std or 1.0) ** 2 for own in known]
    shares = [weight / sum(weights) for weight in weights]
    friction = sum(share * (own.friction or 0.0) for share, own in zip(shares, known, strict=True))
    scatter = sum(weight * ((own.friction or 0.0) - friction) ** 2 for weight, own in zip(weights, known, strict=True))
    shown = sqrt((GUESS_STOPS + scatter) / (GUESS_STOPS + len(known) - 1))
    guessed = hypot(*(share * (own.friction_gradient_std or 0.0) for share, own in zip(shares, known, strict=True)))
    apart = shown * guessed
    common = sum(share * own.own_friction_std for share, own in zip(shares, known, strict=True))
    return replace(
        records[-1],
        friction=friction,
        friction_std=hypot(common, apart),
        friction_gradient_std=apart,
        friction_energy_j=sum(own.friction_energy_j for own in known),
    )
