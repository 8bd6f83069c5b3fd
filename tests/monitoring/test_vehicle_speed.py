"""Between two readings a speed changes by no more than brakes and rail allow: else its wheelsets are believed."""

import pytest

from brake_monitor.monitoring.inputs.speed_doubt import SpeedDoubt
from brake_monitor.monitoring.inputs.vehicle_speed import VehicleSpeed
from brake_monitor.monitoring.inputs.wagon_past import WagonPast
from brake_monitor.monitoring.inputs.watched_wheelset import WatchedWheelset
from brake_monitor.settings.example_vehicles import example_settings

VEHICLE = example_settings("wagon").vehicle


@pytest.mark.parametrize(
    ("from_mps", "to_mps", "within_s", "is_doubted"),
    [
        (20.0, 20.0, 0.05, False),
        (20.0, 15.0, 0.05, False),  # wheel-speed sensors may differ by as much
        (20.0, 14.0, 0.05, True),
        (20.0, 28.0, 0.05, True),
        (20.0, 14.0, 2.0, True),
        (20.0, 14.0, 3.0, False),  # an emergency braking through a tunnel
        (-20.0, 20.0, 0.05, False),  # some receivers give a direction
        (20.0, 28.0, -5.0, True),  # the clock was set back
    ],
)
def test_a_speed_that_jumps_away_from_its_wheelsets_is_doubted(
    from_mps: float, to_mps: float, within_s: float, *, is_doubted: bool
) -> None:
    speed = VehicleSpeed()
    doubt = SpeedDoubt(speed, WagonPast(VEHICLE, 2000.0), 2)
    wheels = [WatchedWheelset(VEHICLE, i, 2000.0, speed) for i in range(2)]
    for time_s, mps in ((100.0, from_mps), (100.0 + within_s, to_mps), (100.1 + within_s, to_mps)):
        speed.see(time_s, mps)
        for wheel in wheels:
            wheel.see_speed(time_s, 20.0 / wheel.radius_m)
        doubt.see(time_s, wheels, is_free=False)
    assert doubt.is_doubted is is_doubted  # until the wheelsets bear it out
    speed.see(100.2 + within_s, 20.0)
    doubt.see(100.2 + within_s, wheels, is_free=False)
    assert not doubt.is_doubted
