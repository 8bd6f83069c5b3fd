"""Input lost, input implausible: what is wrong is a sensor or its wiring, not the brake."""

from collections.abc import Mapping
from math import inf

from brake_monitor.estimation.known_inputs import RELEASED_N
from brake_monitor.monitoring.alarm import Severity, Values, signals_in
from brake_monitor.monitoring.observation import Observation
from brake_monitor.monitoring.reports import InputReport
from brake_monitor.monitoring.rule import FINE, UNKNOWN, Finding, Rule, Settings, Verdict
from brake_monitor.monitoring.rules.bus_pace import BusPace, is_quiet
from brake_monitor.monitoring.rules.losses import Losses
from brake_monitor.plural import plural
from brake_monitor.samples import ESSENTIAL, TRAITS, InputCondition, Measurand, Quantity
from brake_monitor.settings.alarm_settings import InputImplausibleRule, InputLostRule

IMPLAUSIBLE: Mapping[InputCondition, str] = {
    InputCondition.FROZEN: "repeats itself while everything else moves",
    InputCondition.REPEATED: "stands still to the last bit, as all speeds do while the wagon rolls",
    InputCondition.IMPOSSIBLE: "says what no vehicle does",
    InputCondition.OUT_OF_RANGE: "stays outside its range",
    InputCondition.NOT_AVAILABLE: "is sent as not available",
    InputCondition.BAD_COUNTER: "comes in frames whose counter does not advance",
    InputCondition.SCATTERED: "scatters far beyond its noise_std",
    InputCondition.CONTRADICTED: "contradicts the others",
}
TO_CHECK: Mapping[tuple[InputCondition, Quantity], str] = {  # beside sensor and wiring
    (InputCondition.CONTRADICTED, Quantity.SPEED): ", and that the wheelsets turn",
    (InputCondition.CONTRADICTED, Quantity.AXLE_SPEED): ", and that the wheelset turns",
    (InputCondition.CONTRADICTED, Quantity.PRESSING_FORCE): ", and that it measures what reaches the cylinder",
    (InputCondition.NOT_AVAILABLE, Quantity.SPEED): ", unless it is a satellite receiver's in a tunnel",
}
CHECK_TIME_OUT = ". Check the contacts, and that timeout_s is longer than it takes from one message to the next"
NEVER: Mapping[Measurand, int] = {}
TURNS_RADPS = 1.0  # below it a wheelset stands, or its sensor is dead
SILENT = (InputCondition.AWAITED, InputCondition.LOST)


class _InputRule(Rule[Settings]):
    """Remembers what it has told of, by its names in the DBC, until that is known to be good."""

    def __init__(self, settings: Settings, wheelset_count: int) -> None:
        super().__init__(settings, wheelset_count)
        self.wheelsets = (None, *self.wheelsets)
        self._unsure: set[str] = set()

    def resume(self, _: int, evidence: Values) -> None:
        """Go on with signals that were lost or wrong."""
        self._unsure.update(signal for signal, _ in signals_in(evidence))

    def _nothing_found(self, reports: list[InputReport]) -> Verdict:
        return UNKNOWN if any(report.channel.source in self._unsure for report in reports) else FINE


class InputLost(_InputRule[InputLostRule]):
    """Judges whether each mapped signal arrives, and does not come and go, on a bus that does carry something."""

    kind = "input_lost"

    def __init__(self, settings: InputLostRule, wheelset_count: int) -> None:
        super().__init__(settings, wheelset_count)
        self._pace = BusPace()
        self._losses = Losses(settings.losses_per_minute)
        self._lapsed_s: dict[Measurand, float] = {}  # since when each is lost
        self._has_come: set[Measurand] = set()

    def judge(self, seen: Observation) -> tuple[Verdict, ...]:
        """One verdict for the wagon's own signals and one per wheelset."""
        if len(self._has_come) < len(seen.inputs):
            self._has_come |= {r.measurand for r in seen.inputs if r.condition not in SILENT}
        heard_s = self._pace.heard_s(seen)
        quiet_since_s = {bus.name: seen.time_s - bus.silent_s for bus in seen.buses if is_quiet(bus)}
        often = self._losses.see(seen, quiet_since_s)
        if not (seen.inputs.not_good or often):
            self._lapsed_s, self._unsure = {}, set()
            return (FINE,) * len(self.wheelsets)
        self._unsure &= {report.channel.source for report in seen.inputs.not_good if report.condition in SILENT}
        lost = [r.measurand for r in seen.inputs.not_good if r.condition is InputCondition.LOST]
        self._lapsed_s = {measurand: min(self._lapsed_s.get(measurand, inf), seen.time_s) for measurand in lost}
        return tuple(self._judge(wheelset, reports_of(wheelset, seen), heard_s, often) for wheelset in self.wheelsets)

    def _judge(
        self,
        wheelset: int | None,
        reports: list[InputReport],
        heard_s: Mapping[str, float],
        often: Mapping[Measurand, int],
    ) -> Verdict:
        """Find what is lost while its bus, heard last at `heard_s`, went on without it, and what is lost `often`."""
        gone = [report for report in reports if report.condition is InputCondition.LOST]
        restless = [report for report in reports if report.measurand in often]
        lost = [r for r in gone if r not in restless and heard_s.get(r.channel.bus, -inf) > self._lapsed_s[r.measurand]]
        if not (lost or restless):
            return self._nothing_found(reports)
        came = [report for report in lost if report.measurand in self._has_come]
        never = [report for report in lost if report not in came]
        said = [
            f"{words} {', '.join(map(named, some))}{of(wheelset)}{then}."
            for words, some, then in (
                ("Nothing arrives any more of", came, ""),
                ("Nothing has arrived yet of", never, ""),
                ("Lost for moments, again and again:", restless, CHECK_TIME_OUT),
            )
            if some
        ]
        found = [report for report in reports if report in lost or report in restless]
        self._unsure.update(report.channel.source for report in found)
        return Finding(severity(found), " ".join(said), evidence(found, often), is_all=True)


class InputImplausible(_InputRule[InputImplausibleRule]):
    """Judges whether what arrives of each mapped signal can be used.

    A lost signal cannot be judged, nor one that has yet to come; that does not keep an alarm about others open. Nor is
    one known to be cured that says 0, as a dead sensor does: a wheel speed until the wheelset turns, a pressing force
    until the brake presses.
    """

    kind = "input_implausible"

    def judge(self, seen: Observation) -> tuple[Verdict, ...]:
        """One verdict for the wagon's own signals and one per wheelset."""
        at_zero = self._unsure and _at_zero(seen) & self._unsure
        if not (seen.inputs.not_good or at_zero):
            self._unsure = set()
            return (FINE,) * len(self.wheelsets)
        self._unsure &= {report.channel.source for report in seen.inputs.not_good} | at_zero
        self._unsure |= {report.channel.source for report in seen.inputs.not_good if report.condition in IMPLAUSIBLE}
        return tuple(self._judge(wheelset, reports_of(wheelset, seen)) for wheelset in self.wheelsets)

    def _judge(self, wheelset: int | None, reports: list[InputReport]) -> Verdict:
        wrong = [report for report in reports if report.condition in IMPLAUSIBLE]
        if not wrong:
            return self._nothing_found(reports)
        what = "; ".join(f"{named(report)}{of(wheelset)} {IMPLAUSIBLE[report.condition]}" for report in wrong)
        to_check = [TO_CHECK.get((report.condition, report.channel.quantity), "") for report in wrong]
        too = "".join(dict.fromkeys(to_check))
        if any(report.condition is InputCondition.REPEATED for report in wrong):
            too += ", and the gateway that may tell again what it was told last"
        said = f"{what[0].upper()}{what[1:]}: check sensor and wiring{too}."
        return Finding(severity(wrong), said, evidence(wrong), is_all=True)


def _at_zero(seen: Observation) -> set[str]:
    """The wheel speeds and pressing forces that say 0, and wheel speeds beside a vehicle's that says nothing."""
    wheelsets = seen.estimate.wheelsets
    alone = any(report.channel.quantity is Quantity.SPEED for report in seen.inputs.not_good)
    zero = {(Quantity.AXLE_SPEED, i) for i, own in enumerate(wheelsets) if alone or abs(own.omega_radps) < TURNS_RADPS}
    zero |= {(Quantity.PRESSING_FORCE, i) for i, own in enumerate(wheelsets) if own.pressing_force_n < RELEASED_N}
    return {r.channel.source for r in seen.inputs if (r.channel.quantity, r.channel.wheelset) in zero}


def reports_of(wheelset: int | None, seen: Observation) -> list[InputReport]:
    """Those of a wheelset (from 1), or of the wagon."""
    own_wsp = sum(report.channel.quantity is Quantity.WSP_ACTIVE for report in seen.inputs) > 1

    def wheelset_of(report: InputReport) -> int | None:
        is_shared = report.channel.quantity is Quantity.WSP_ACTIVE and not own_wsp
        return report.channel.wheelset + 1 if TRAITS[report.channel.quantity].per_wheelset and not is_shared else None

    return [report for report in seen.inputs if wheelset_of(report) == wheelset]


def severity(reports: list[InputReport]) -> Severity:
    """Without an essential input there are no estimates."""
    return Severity.WARNING if any(report.channel.quantity in ESSENTIAL for report in reports) else Severity.INFO


def evidence(reports: list[InputReport], often: Mapping[Measurand, int] = NEVER) -> Values:
    """What is wrong, by its names in the configuration; `often`: how often some were lost within a minute."""
    return {
        "inputs": ", ".join(report.channel.quantity for report in reports),
        "signals": ", ".join(report.channel.source for report in reports),
        "conditions": ", ".join(
            f"lost {plural(often[r.measurand], 'time')} within a minute" if r.measurand in often else r.condition
            for r in reports
        ),
    }


def named(report: InputReport) -> str:
    """What it tells, and its name in the DBC."""
    return f"{TRAITS[report.channel.quantity].called} ({report.channel.source})"


def of(wheelset: int | None) -> str:
    """Whose signal it is."""
    return "" if wheelset is None else f" of wheelset {wheelset}"
