"""What is noted of a recording by the block must be, to the bit, what is noted of it frame by frame."""

import numpy as np
import pytest

from brake_monitor.frame import Frame, FrameKind
from brake_monitor.inspection.first_hour import FirstHour
from brake_monitor.inspection.traffic import Found, Traffic
from brake_monitor.report.page import page
from brake_monitor.report.recording import Recording
from brake_monitor.samples import Quality, Sample
from mixed_traffic import cut, mixed, two_buses


def note(traffic: Traffic, frame: Frame, samples: list[Sample]) -> None:
    """A frame and its samples, one by one."""
    traffic._first_s, traffic._last_s = min(traffic._first_s, frame.time_s), max(traffic._last_s, frame.time_s)
    for sample in samples:
        found = traffic.found[sample.quantity, sample.wheelset]
        found.arrivals.see(np.array([sample.time_s]))
        found.can_ids.add(frame.can_id)
        if sample.quality is Quality.GOOD:
            found.good += 1
            found.least, found.greatest = min(found.least, sample.value), max(found.greatest, sample.value)
            note_kept(found, sample.value)
            note_reading(traffic.first_hour, sample)
        else:
            found.bad[sample.quality] += 1
    if not samples and frame.kind is FrameKind.DATA:
        traffic.unmapped[frame.bus, frame.extended, frame.can_id] += 1


def note_kept(found: Found, value: float) -> None:
    """What three in a row had."""
    three = [*found._last, value]
    if len(three) == 3:
        found.kept_least = min(found.kept_least, max(three))
        found.kept_greatest = max(found.kept_greatest, min(three))
    found._last = three[-2:]


def note_reading(first_hour: FirstHour, sample: Sample) -> None:
    """A good sample, if it is of a kind that is kept. No mapped signal of these lags."""
    place = (sample.quantity, sample.wheelset)
    if place in first_hour._times_s:
        first_hour._times_s[place].append(sample.time_s)
        first_hour._values[place].append(sample.value)


def everything(traffic: Traffic) -> dict[str, object]:
    """What was noted of a recording; of when it began, only what its readings say."""
    readings = {name: kept for name, kept in vars(traffic.first_hour).items() if name != "_begun_s"}
    return vars(traffic) | {"first_hour": readings}


@pytest.mark.parametrize("seed", range(3))
def test_a_report_says_the_same(seed: int) -> None:
    frames = mixed(seed)
    expected, found = Recording(two_buses()), Recording(two_buses())
    for frame in frames:
        note(expected.traffic, frame, expected.decoder.decode(frame))
        expected._take(expected.pipeline.step(frame))
    expected.play([], tuple)
    found.play(cut(frames, seed), tuple)
    assert everything(found.traffic) == everything(expected.traffic)
    assert any(found.traffic.first_hour._times_s.values())
    assert list(found.traffic.unmapped) == list(expected.traffic.unmapped)
    assert found.decoder.counts == expected.decoder.counts
    assert found.curves.table().tobytes() == expected.curves.table().tobytes()
    assert (found.applications, found.alarms, found.statuses) == (
        expected.applications,
        expected.alarms,
        expected.statuses,
    )
    assert page(found, "x.log", "") == page(expected, "x.log", "")
