"""Whether frames of a bus bear the time at which an adapter or a gateway handed on a batch of them.

No two frames of a bus end closer together than one of them lasts. Stamps that are rounded to a millisecond may, and
those of a driver that empties its queue; but then each message still comes as regularly as it is sent.
"""

from collections.abc import Iterator, Sequence
from math import inf
from typing import NamedTuple

import numpy as np

from brake_monitor.inspection.arrivals import Arrivals
from brake_monitor.inspection.rates import NEVER_TOO_SELDOM, TOO_SELDOM
from brake_monitor.inspection.traffic import Traffic
from brake_monitor.samples import Channel

FRAME_S = 1e-4  # one of eight bytes lasts longer, at 1 Mbit/s by a tenth; from a queue they are read closer
TOGETHER = 0.3  # of the frames; rounding to a millisecond brings a sixth of them together
DISPLACED_S = 3e-3  # from how a message usually comes; waiting for a free bus takes less
DISPLACED = 0.15  # of the frames
LEAST_COUNT = 100  # frames


class Batches(NamedTuple):
    """How frames of a bus are gathered."""

    every_s: float
    together: float  # share of the mapped frames that come closer to the one before than a frame lasts


def batches(traffic: Traffic, channels: Sequence[Channel]) -> Batches | None:
    """How the mapped frames of one bus are gathered, by the channels on it; None where nothing shows that they are."""
    by_message: dict[str, Arrivals] = {}
    for channel in channels:  # those of one message have its frames in common
        arrivals = traffic.found[channel.measurand].arrivals
        if arrivals.count > by_message.get(channel.message, Arrivals()).count:
            by_message[channel.message] = arrivals
    until_s = min((float(own.times_s[-1]) for own in by_message.values() if not own.all_kept), default=inf)
    own_times_s = [own.times_s[own.times_s <= until_s] for own in by_message.values()]
    own_gaps_s = [np.diff(times_s) for times_s in own_times_s if len(times_s) > 1]
    if sum(map(len, own_gaps_s)) < LEAST_COUNT:
        return None
    times_s = np.sort(np.concatenate(own_times_s))
    begins = np.diff(times_s, prepend=-inf) >= FRAME_S  # a batch, or what comes alone
    together = 1.0 - float(begins.mean())
    displaced = np.concatenate([np.abs(own_s - np.median(own_s)) > DISPLACED_S for own_s in own_gaps_s])
    if together < TOGETHER or displaced.mean() < DISPLACED or np.count_nonzero(begins) < 2:
        return None
    return Batches(float(np.median(np.diff(times_s[begins]))), together)


def remarks_on_batches(traffic: Traffic, channels: Sequence[Channel]) -> Iterator[str]:
    """Frames that bear the time of their batch; of longer batches `remarks_on_rates` tells."""
    for bus in dict.fromkeys(channel.bus for channel in channels):
        own = [channel for channel in channels if channel.bus == bus]
        longest_s = min(TOO_SELDOM.get(channel.quantity, NEVER_TOO_SELDOM)[0] for channel in own)
        found = batches(traffic, own)
        if found is not None and found.every_s <= longest_s:
            yield (
                f"bus {bus}: {found.together:.0%} of the mapped frames come sooner after another than a frame lasts, "
                f"in batches about every {1000.0 * found.every_s:.0f} ms, as an adapter or a gateway stamps what it "
                "has gathered: estimates are then less certain than they say (with 30 ms, adhesion was in its 95 % "
                "interval 68 % of the time); have each frame stamped as it comes, as by hardware time stamps"
            )
