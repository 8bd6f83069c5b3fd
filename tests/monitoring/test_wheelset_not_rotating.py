"""A wheelset that was dragged, and came to stand again before anybody has looked at it."""

import pytest

from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.monitoring.inputs.wheel_state import WheelState
from brake_monitor.monitoring.monitor import Monitor
from brake_monitor.monitoring.rules.all_rules import wagon_rules
from brake_monitor.settings.alarm_settings import AlarmSettings
from estimates import estimate, observation, wheelset

SPEED_MPS = 20.0
ROLLING, STOPPED, DOUBTFUL = WheelState.ROLLING, WheelState.STOPPED, WheelState.DOUBTFUL


class Track:
    """A wagon at constant speed, seen ten times a second; all wheelsets but the first one roll."""

    def __init__(self, wheelsets: int = 1) -> None:
        self.wheelsets = wheelsets
        self.monitor = Monitor(wagon_rules(AlarmSettings(), wheelsets))
        self.time_s = self.distance_m = 0.0
        self.given: list[Alarm] = []

    def go(self, state: WheelState, lasts_s: float) -> None:
        for _ in range(round(lasts_s * 10)):
            self.time_s += 0.1
            self.distance_m += 0.1 * SPEED_MPS
            now = estimate(
                time_s=self.time_s,
                speed_mps=SPEED_MPS,
                distance_m=self.distance_m,
                wheelsets=(wheelset(),) * self.wheelsets,
            )
            states = (state, *[ROLLING] * (self.wheelsets - 1))
            self.given += [
                alarm
                for alarm in self.monitor.see(observation(now, wheels=states))
                if alarm.kind == "wheelset_not_rotating"
            ]

    @property
    def alarm(self) -> Alarm:
        (found,) = [alarm for alarm in self.monitor.open_alarms() if alarm.kind == "wheelset_not_rotating"]
        return found

    def clear(self) -> Alarm:
        """Somebody has seen it, and it rolls on."""
        self.monitor.acknowledge(self.alarm.id, self.time_s)
        self.go(ROLLING, 5.0)
        assert self.given[-1].cleared_time_s is not None
        return self.given[-1]


def dragged_km(alarm: Alarm) -> float:
    dragged_m = alarm.evidence["dragged_m"]
    assert isinstance(dragged_m, float)
    return round(dragged_m / 1000.0, 2)


@pytest.mark.parametrize("wheelsets", [1, 2])
def test_a_second_standstill_adds_to_the_first_until_the_alarm_is_cleared(wheelsets: int) -> None:
    """Six kilometres are what may have broken it, not the last twenty metres, nor the twelve in which it rolled."""
    track = Track(wheelsets)
    track.go(STOPPED, 300.0)
    track.go(ROLLING, 600.0)
    track.go(STOPPED, 30.0)
    assert (dragged_km(track.alarm), track.alarm.evidence["started_time_s"]) == (6.6, 0.1)
    assert "runs at 72 km/h, and has been dragged 6596 m in all, the first time from 72 km/h on" in track.alarm.message
    track.go(ROLLING, 10.0)
    track.go(STOPPED, 0.9)  # too short for an alarm of its own, and yet of this one
    assert dragged_km(track.alarm) == 6.61
    track.go(ROLLING, 10.0)
    assert dragged_km(track.clear()) == 6.61


def test_after_it_was_cleared_all_begins_anew() -> None:
    track = Track()
    track.go(STOPPED, 300.0)
    track.go(ROLLING, 1.0)
    first = track.clear()
    began_s = track.time_s
    track.go(STOPPED, 5.0)
    assert track.alarm.id != first.id
    assert dragged_km(track.alarm) == 0.1
    assert track.alarm.evidence["started_time_s"] > began_s


def test_moments_of_standing_that_were_no_alarm_do_not_add_up() -> None:
    track = Track()
    for _ in range(20):
        track.go(STOPPED, 0.5)
        track.go(ROLLING, 0.5)
    track.go(STOPPED, 0.6)
    track.go(DOUBTFUL, 0.5)
    track.go(STOPPED, 0.6)
    track.go(ROLLING, 0.5)
    assert track.given == []
    began_s = track.time_s
    track.go(STOPPED, 5.0)
    assert dragged_km(track.alarm) == 0.1
    assert track.alarm.evidence["started_time_s"] > began_s


def test_the_way_adds_up_over_a_restart() -> None:
    """The alarm stays open meanwhile: 598 m before the program ended, and 38 m since: each run sees where it begins."""
    before, after = Track(), Track()
    before.go(STOPPED, 30.0)
    after.monitor.resume(before.monitor.open_alarms())
    after.go(STOPPED, 2.0)
    assert after.alarm.id == before.alarm.id
    assert dragged_km(after.alarm) == 0.64
    assert "dragged 636 m in all, the first time from 72 km/h on" in after.alarm.message
    assert after.alarm.evidence["started_time_s"] == before.alarm.evidence["started_time_s"]
