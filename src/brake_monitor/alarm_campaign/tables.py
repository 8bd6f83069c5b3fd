"""The campaign's result as tables for a person, and every miss and false alarm with how to see it again."""

from collections import Counter
from collections.abc import Iterator, Sequence
from statistics import median

from brake_monitor.alarm_campaign.outcome import Answer, Outcome
from brake_monitor.plural import plural
from brake_monitor.simulator.due.alarm import AFTER_BRAKING, DELAY_S
from brake_monitor.simulator.ordinary_service import SERVICE


def markdown(outcomes: Sequence[Outcome]) -> str:
    """Detection delays by kind, and false alarms in ordinary service."""
    return "\n".join((*_delays(outcomes), "", *_service(outcomes))) + "\n"


def _delays(outcomes: Sequence[Outcome]) -> Iterator[str]:
    troubles = [outcome for outcome in outcomes if outcome.drive.name != SERVICE]
    answers = [answer for outcome in troubles for answer in outcome.answers]
    wrong = Counter(alarm.kind for outcome in troubles for alarm in outcome.false_alarms)
    yield "| kind | due | in time | open before | late | missed | delay, median / most | stated | false |"
    yield "|---|---|---|---|---|---|---|---|---|"
    for kind, stated_s in DELAY_S.items():
        ours = [answer for answer in answers if answer.kind == kind]
        yield f"| `{kind}` | {_row(ours)} | {_stated(kind, stated_s)} | {wrong[kind]} |"
    yield ""
    yield f"{plural(len(troubles), 'drive')} on which something is wrong, {sum(o.hours for o in troubles):.1f} hours."


def _row(answers: Sequence[Answer]) -> str:
    """Counts and delays of one kind."""
    delays = [answer.delay_s for answer in answers if answer.delay_s is not None]
    late = sum(answer.delay_s is not None and not answer.is_in_time for answer in answers)
    missed = sum(answer.delay_s is None and not answer.is_in_time for answer in answers)
    told = f"{median(delays):.1f} / {max(delays):.1f} s" if delays else "–"
    in_time = sum(answer.is_in_time and answer.delay_s is not None for answer in answers)
    before = sum(answer.is_in_time and answer.delay_s is None for answer in answers)
    return f"{len(answers)} | {in_time} | {before} | {late} | {missed} | {told}"


def _stated(kind: str, stated_s: float) -> str:
    return f"{stated_s:g} s" + (" after the braking" if kind in AFTER_BRAKING else "")


def _service(outcomes: Sequence[Outcome]) -> Iterator[str]:
    service = [outcome for outcome in outcomes if outcome.drive.name == SERVICE]
    counts = Counter(alarm.kind for outcome in service for alarm in outcome.false_alarms)
    told = ", ".join(f"{count} `{kind}`" for kind, count in sorted(counts.items())) or "none"
    yield f"Ordinary service: {sum(o.hours for o in service):.1f} hours, false alarms: {told}."


def failures(outcomes: Sequence[Outcome]) -> Iterator[str]:
    """One line for each alarm that did not come in time, or should not have come."""
    for outcome in sorted(outcomes, key=lambda outcome: outcome.drive):
        for answer in outcome.answers:
            if not answer.is_in_time:
                came = "never raised" if answer.delay_s is None else f"raised after {answer.delay_s:.1f} s"
                at = f"{answer.kind} {answer.wheelset or ''} at {answer.qualified_s:.1f} s"
                yield f"{outcome.drive.path}: {at}: {came} ({answer.reason})"
        for alarm in outcome.false_alarms:
            at = f"{alarm.kind} {alarm.wheelset or ''} at {alarm.raised_s:.1f} s"
            yield f"{outcome.drive.path}: {at}: false ({alarm.message})"


def by_drive(outcomes: Sequence[Outcome]) -> str:
    """One line per trouble and vehicle: due, raised in time or open from before, late, missed, false."""
    lines = [
        "| drive | due | in time | open before | late | missed | delay, median / most | false |",
        "|---|---|---|---|---|---|---|---|",
    ]
    groups: dict[tuple[str, str], list[Outcome]] = {}
    for outcome in sorted(outcomes, key=lambda outcome: outcome.drive):
        groups.setdefault((outcome.drive.name, outcome.drive.vehicle), []).append(outcome)
    for (name, vehicle), ours in sorted(groups.items()):
        answers = [answer for outcome in ours for answer in outcome.answers]
        wrong = Counter(alarm.kind for outcome in ours for alarm in outcome.false_alarms)
        told = ", ".join(f"{count} `{kind}`" for kind, count in sorted(wrong.items())) or "0"
        lines.append(f"| {name}, {vehicle} | {_row(answers)} | {told} |")
    return "\n".join(lines) + "\n"
