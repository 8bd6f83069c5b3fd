"""Whether the signals of a recording come often enough: for good estimates, and to count as there."""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from math import inf

import numpy as np

from brake_monitor.decoding.routing import CYCLES_TO_TIMEOUT
from brake_monitor.estimation.inputs.held_input import PROMPT_S
from brake_monitor.inspection.arrivals import Arrivals, usual_s
from brake_monitor.inspection.traffic import Traffic
from brake_monitor.samples import Channel, Quantity

JITTER = 1.1  # of a period
TOO_SELDOM = {  # the longest good period (s), and what a longer one costs
    Quantity.AXLE_SPEED: (
        JITTER * 0.05,
        "jumps of adhesion in a slide are then read as friction; map speeds that come every 20 ms if there are any",
    ),
    Quantity.PRESSING_FORCE: (
        JITTER * PROMPT_S,
        "in slides friction is then held and adhesion up to three times as uncertain; map forces that come every "
        "10 to 20 ms if there are any",
    ),
}
NEVER_TOO_SELDOM = (inf, "")
LEAST_VALUES = 20  # fewer say nothing about how a sender works


def remarks_on_rates(traffic: Traffic, wheelset_count: int) -> Iterator[str]:
    """What comes too seldom for good estimates."""
    for quantity, (longest_s, costs) in TOO_SELDOM.items():
        seldom = {
            place + 1: arrivals
            for place in range(wheelset_count)
            if (arrivals := traffic.found[quantity, place].arrivals).count >= LEAST_VALUES
            and arrivals.period_s > longest_s
            and not arrivals.comes_on_change
        }
        if not seldom:
            continue
        which, most_ms = ", ".join(map(str, seldom)), 1000.0 * max(one.period_s for one in seldom.values())
        if any(one.is_bunched for one in seldom.values()):
            yield (
                f"{quantity} {which}: values come in bunches, every {most_ms:.0f} ms, as a gateway hands on what "
                "it has gathered, and are taken as measured when they come; map them where they come one by one"
            )
        else:
            yield f"{quantity} {which}: a value comes every {most_ms:.0f} ms, and {costs}"


def remarks_on_timeouts(traffic: Traffic, channels: Sequence[Channel]) -> Iterator[str]:
    """What comes regularly and yet counts as lost each time, as where the DBC's cycle time is wrong."""
    lost: defaultdict[tuple[Quantity, float], dict[int, float]] = defaultdict(dict)
    for channel in channels:
        gap_s = _gap_beyond_s(traffic.found[channel.measurand].arrivals, channel.timeout_s / JITTER)
        if gap_s is not None:
            lost[channel.quantity, channel.timeout_s][channel.wheelset + 1] = gap_s
    for (quantity, timeout_s), gaps_s in lost.items():
        most_s = max(gaps_s.values())
        yield (
            f"{quantity} {', '.join(map(str, gaps_s))}: a value comes every {1000.0 * most_s:.0f} ms, and counts "
            f"as lost {1000.0 * timeout_s:.0f} ms after it came: timeout_s should be about "
            f"{CYCLES_TO_TIMEOUT * most_s:.2g}"
        )


def _gap_beyond_s(arrivals: Arrivals, timeout_s: float) -> float | None:
    """The usual one of the gaps that are longer than that, where most of the time lies in many such.

    Of a value that comes as it changes: the one in which most of that time lies, while nothing changes.
    """
    gaps_s = arrivals.gaps_s
    longer_s = np.sort(gaps_s[gaps_s > timeout_s])
    if len(longer_s) < LEAST_VALUES or longer_s.sum() < 0.5 * gaps_s.sum():
        return None
    return usual_s(longer_s) if arrivals.comes_on_change else float(np.median(longer_s))
