"""A vehicle speed that is lost for a minute, as in a tunnel: wheelsets that roll tell how fast and how far one goes."""

from dataclasses import replace

import numpy as np
import pytest

from brake_monitor.estimation.estimate import Status
from brake_monitor.simulator.journey import Act, Leg, LegJourney
from brake_monitor.simulator.scenarios import Profile, Scenario
from drives import Judged, drive, play
from faults import Fault, changed, lagging, lost, signal_changed, silence

PULLED = Scenario(
    name="pulled through a tunnel",
    summary="a train pulls away to 20 m/s, brakes it, and pulls on",
    initial_speed_mps=8.0,
    duration_s=70.0,
    demand=LegJourney((Leg(Act.PULL, 20.0, pull_mps2=0.5), Leg(Act.BRAKE, 12.0, demand=0.5), Leg(Act.PULL, 25.0)), 5e3),
    rail_over_time=Profile(((0.0, 0.4),)),
)
FROM_S, TO_S = 10.0, 60.0
STOPPED = replace(
    PULLED,
    name="stopped in a tunnel",
    summary="a train stops, stands, and pulls away",
    initial_speed_mps=15.0,
    duration_s=90.0,
    demand=LegJourney((Leg(Act.STAND, lasts_s=20.0, demand=0.5), Leg(Act.PULL, 25.0, pull_mps2=0.5)), 5e3),
)
BRAKED = replace(
    PULLED,
    name="braked twice",
    summary="coast, brake, coast, brake, coast",
    initial_speed_mps=36.0,
    duration_s=45.0,
    demand=LegJourney(
        tuple(
            leg
            for speed_mps in (28.0, 20.0)
            for leg in (Leg(Act.COAST, lasts_s=6.0), Leg(Act.BRAKE, speed_mps, demand=0.8))
        ),
        5e3,
    ),
)


def in_the_tunnel(*faults: Fault) -> Judged:
    recording = drive(PULLED)
    frames = list(recording.frames)
    for fault in (lost("GNSS", FROM_S, TO_S), *faults):
        frames = fault(frames)
    return Judged.of(recording, play(recording.settings, frames))


def speed_errors_mps(seen: Judged) -> np.ndarray:
    return np.array([estimate.speed_mps for estimate in seen.told]) - seen.truth.speed_mps


def test_speed_and_way_are_right_though_nothing_else_is_known() -> None:
    """What pulls and holds the wagon is told by nobody; while the brake acts v is reckoned on from there."""
    seen = in_the_tunnel()
    tunnel = seen.during(FROM_S + 1.0, TO_S)
    assert tunnel.statuses == {Status.INVALID}
    assert np.ptp(tunnel.truth.speed_mps) > 5.0
    assert np.abs(speed_errors_mps(tunnel)).max() < 0.3
    way_m = tunnel.told[-1].distance_m - tunnel.told[0].distance_m
    assert way_m == pytest.approx(np.trapezoid(tunnel.truth.speed_mps, tunnel.time_s), rel=2e-3)
    seen.assert_sound()
    seen.assert_honest()


def test_wheelsets_that_stand_for_long_do_not_stop_a_wagon_whose_speed_nobody_tells() -> None:
    """Both of them, as brakes hold them on ice; in what is unknown after half a minute no standstill is found."""
    stand = changed("WSP", ("n_A", "n_B"), lambda *_: 0.0, 12.0, 70.0)
    seen = in_the_tunnel(stand).during(40.0, TO_S)
    assert min(estimate.speed_mps for estimate in seen.told) > 5.0


def test_a_wheelset_that_seizes_in_the_tunnel_does_not_take_the_speed_with_it() -> None:
    """It comes to stand within a second; the other one rolls on."""
    stands = signal_changed("wheel speed", lambda t, kmh: max(1.0 - (t - 12.0), 0.0) * kmh, 12.0, 70.0)
    assert np.abs(speed_errors_mps(in_the_tunnel(stands).during(FROM_S + 1.0, 20.0))).max() < 0.3


def test_speed_and_way_are_right_again_after_a_stop() -> None:
    """Near standstill v is what the wheelsets say, though a sensor says 0 there: else it would stand still for ever."""
    recording = drive(STOPPED)
    seen = Judged.of(recording, play(recording.settings, lost("GNSS", 10.0, 90.0)(list(recording.frames))))
    stands = seen.during(48.0, 52.0)
    assert max(estimate.speed_mps for estimate in stands.told) == 0.0 == stands.truth.speed_mps.max()
    assert seen.told[-1].speed_mps > 10.0
    assert np.abs(speed_errors_mps(seen.during(11.0, 90.0))).max() < 0.3


def test_speed_is_right_again_after_a_gap_in_which_the_wagon_went_on() -> None:
    after = in_the_tunnel(silence(18.0, 26.0)).during(27.0, TO_S)
    assert np.abs(speed_errors_mps(after)).max() < 0.3


def test_what_wheelsets_say_of_the_speed_does_not_come_late_as_the_sensor_did() -> None:
    """That one was late by a third of a second, as brakings before have shown: 0.2 m/s, which no wheelset is off by."""
    recording = drive(BRAKED)
    frames = lost("GNSS", 27.0, 45.0)(lagging("GNSS", 0.3)(list(recording.frames)))
    tunnel = Judged.of(recording, play(recording.settings, frames)).during(30.0, 45.0)
    assert np.abs(speed_errors_mps(tunnel)).max() < 0.1
