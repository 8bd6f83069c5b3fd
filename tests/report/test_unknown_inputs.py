"""Where an input is awaited or lost a report shows a gap, never the value that the estimator holds meanwhile."""

import re
from functools import cache

import numpy as np
import pytest

from brake_monitor.frame import Frame
from brake_monitor.frame_block import FrameBlock
from brake_monitor.report import tables
from brake_monitor.report.recording import Recording
from brake_monitor.report.summary import summary
from brake_monitor.report.words import number
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.simulate import run as simulate

MESSAGE_IDS = {"BCU": 0x120, "WSP": 0x1A0, "GNSS": 0x2A0}
FROM_S, TO_S = 8.0, 14.0  # of the recording, in which the brakes press


@cache
def frames() -> tuple[Frame, ...]:
    return tuple(simulate("leaf", example_settings("wagon"), seed=3).frames)


@cache
def played(missing: str, from_s: float, to_s: float) -> Recording:
    """A recording without the frames of a message between these times."""
    begun_s = frames()[0].time_s
    kept = [f for f in frames() if f.can_id != MESSAGE_IDS[missing] or not from_s <= f.time_s - begun_s < to_s]
    recording = Recording(example_settings("wagon"))
    recording.play([FrameBlock.of(kept)], lambda: ())
    return recording


def told(recording: Recording, name: str) -> tuple[np.ndarray, np.ndarray]:
    """When the report has a value, and where it has, of both wheelsets: times and shape (2, K)."""
    columns = recording.curves.columns(recording.curves.table())
    each = np.array([columns["wheelsets"][i][name] for i in (1, 2)])
    return columns["time_s"] - frames()[0].time_s, np.isfinite(each)


@pytest.mark.parametrize(
    ("missing", "names"),
    [
        ("BCU", ["pressing_force_n", "friction", "adhesion"]),
        ("WSP", ["omega_radps", "slip", "friction", "adhesion"]),
        ("GNSS", ["slip", "friction", "adhesion"]),
    ],
)
def test_what_is_lost_is_a_gap(missing: str, names: list[str]) -> None:
    recording = played(missing, FROM_S, TO_S)
    timeout_s = max(channel.timeout_s for channel in recording.decoder.channels if channel.message == missing)
    for name in names:
        time_s, known = told(recording, name)
        assert not known[:, (time_s > FROM_S + timeout_s + 0.2) & (time_s < TO_S)].any()
        assert known[:, (time_s > 1.0) & (time_s < FROM_S)].all()
        assert known[:, time_s > TO_S + 0.2].all()


def test_what_never_came_is_no_zero() -> None:
    recording = played("BCU", 0.0, 1e9)
    assert not told(recording, "pressing_force_n")[1].any()
    assert told(recording, "omega_radps")[1].any()
    cells = re.findall(r"<td>(.*?)</td>", tables.wear(recording))
    assert cells == ["1", *"–––––––", "2", *"–––––––"]


def test_a_legend_says_that_nothing_came() -> None:
    matplotlib_axes = pytest.importorskip("matplotlib.figure").Figure().subplots()
    from brake_monitor.report.figures import _figures  # noqa: PLC0415 - needs the extra

    draw = dict(_figures(played("BCU", 0.0, 1e9)))["pressing_forces"]
    draw(matplotlib_axes)
    assert [text.get_text() for text in matplotlib_axes.get_legend().get_texts()] == ["wheelset 1: –", "wheelset 2: –"]


def test_a_figure_goes_from_the_beginning_to_the_end() -> None:
    """Whatever is known in between."""
    axes = pytest.importorskip("matplotlib.figure").Figure().subplots()
    from brake_monitor.report.figures import _figures  # noqa: PLC0415 - needs the extra

    recording = played("BCU", 0.0, FROM_S)
    dict(_figures(recording))["pressing_forces"](axes)
    time_s = recording.curves.table()[:, 0]
    assert axes.get_xlim() == pytest.approx((0.0, time_s[-1] - time_s[0]))


def cells(table: str) -> set[str]:
    return set(re.findall(r"<td[^>]*>([^<]*)</td>", table))


def test_brakings_within_which_a_force_came_have_their_energy(monkeypatch: pytest.MonkeyPatch) -> None:
    recording = played("BCU", 0.0, 0.0)
    (stop,) = recording.applications
    assert recording.forces_told(stop.start_time_s, stop.end_time_s) == [True, True]
    for own in stop.wheelsets:
        assert own.energy_j > 1e5
        told = (own.energy_j / 1e6, 2), (own.sliding_distance_m, 1), (own.peak_disc_temperature_c, 0)
        assert {number(*one) for one in told} <= cells(tables.applications(recording))
    monkeypatch.setattr(recording, "forces_told", lambda *_: [False, False])
    untold = cells(tables.applications(recording))
    assert untold.isdisjoint(number(own.energy_j / 1e6, 2) for own in stop.wheelsets)
    assert "–" in untold
    lost = played("BCU", FROM_S, TO_S)
    begun_s = frames()[0].time_s
    assert lost.forces_told(begun_s + FROM_S + 2.0, begun_s + TO_S - 0.2) == [False, False]


def test_a_signal_that_comes_late_and_ends_early_says_so() -> None:
    """Kept are the forces of some seconds; that is told in words and in the table."""
    begun_s = frames()[0].time_s
    kept = [f for f in frames() if f.can_id != MESSAGE_IDS["BCU"] or FROM_S <= f.time_s - begun_s <= TO_S]
    recording = Recording(example_settings("wagon"))
    recording.play([FrameBlock.of(kept)], lambda: ())
    lines = {line.channel.signal: line for line in recording.traffic.lines(recording.decoder)}
    ended_s = kept[-1].time_s - begun_s
    assert lines["p_A"].present_only_s == pytest.approx((FROM_S, TO_S), abs=0.1)
    assert lines["p_A"].longest_gap_s == pytest.approx(max(FROM_S, ended_s - TO_S), abs=0.1)
    assert lines["n_A"].present_only_s is None
    assert f"BCU.p_A is there only from {FROM_S:.0f} to {TO_S:.0f} s" in " ".join(summary(recording))
    assert f"there only from {FROM_S:.0f} to {TO_S:.0f} s" in tables.signals(recording)
    silent = tables.signals(played("BCU", 0.0, 1e9))
    assert re.search(r"BCU.p_A</td><td>0</td><td>–</td><td><b class=bad>–</b>", silent)
