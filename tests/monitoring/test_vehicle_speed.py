"""Between two readings a wagon's speed changes by no more than brakes and rail allow."""

import pytest

from brake_monitor.monitoring.inputs.vehicle_speed import VehicleSpeed


@pytest.mark.parametrize(
    ("from_mps", "to_mps", "within_s", "jumps"),
    [
        (20.0, 21.5, 0.05, False),  # a coarse receiver
        (20.0, 22.0, 0.05, True),
        (20.0, 18.0, 0.05, True),
        (20.0, 15.0, 2.0, False),  # an emergency braking through a tunnel
        (20.0, 14.0, 2.0, True),
        (-20.0, 20.0, 0.05, False),  # some receivers give a direction
        (20.0, 22.0, -5.0, True),  # the clock was set back
    ],
)
def test_a_speed_jumps_by_more_than_a_wagon_can_change_it(
    from_mps: float, to_mps: float, within_s: float, *, jumps: bool
) -> None:
    speed = VehicleSpeed()
    speed.see(100.0, from_mps)
    assert not speed.jumped  # the first reading is none
    speed.see(100.0 + within_s, to_mps)
    assert speed.jumped is jumps
    assert speed.mps == abs(to_mps)
    speed.see(100.1 + within_s, to_mps)
    assert speed.jumped is jumps  # until the wheelsets bear it out
