"""What to do about a force that slides show to be late, early or another wheelset's: which signal to look at."""

import pytest
from msgspec.structs import replace

from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.inspection import lags
from brake_monitor.inspection.force_lag import Obeyed
from brake_monitor.inspection.remarks import remarks_on_mapping
from brake_monitor.inspection.traffic import Traffic
from brake_monitor.settings.example_vehicles import example_settings


def told(monkeypatch: pytest.MonkeyPatch, obeyed: Obeyed, force_s: float = 0.0, wheel_s: float = 0.0) -> list[str]:
    """What is said where wheelset 1 obeys so, and these delays of it are configured."""
    monkeypatch.setattr(lags, "obeyed_forces", lambda *_: [obeyed, None])
    settings = example_settings("wagon")
    force, wheel = settings.signals.pressing_force, settings.signals.axle_speed
    signals = replace(
        settings.signals,
        pressing_force=(replace(force[0], delay_s=force_s), force[1]),
        axle_speed=(replace(wheel[0], delay_s=wheel_s), wheel[1]),
    )
    settings = replace(settings, signals=signals)
    decoder = SignalDecoder.from_settings(settings)
    return list(remarks_on_mapping(Traffic(decoder.channels), decoder, settings))


FORCE_LATE = "pressing_force 1 comes about 0.06 s later than axle_speed 1, as slides show: "
WHEEL_LATE = "axle_speed 1 comes about 0.06 s later than pressing_force 1, as slides show: "


@pytest.mark.parametrize(
    ("lag_s", "force_s", "wheel_s", "said"),
    [
        (0.06, 0.0, 0.0, f"{FORCE_LATE}its delay_s should be about 0.06, not 0"),
        (0.06, 0.04, 0.0, f"{FORCE_LATE}its delay_s should be about 0.10, not 0.04"),
        (0.06, 0.0, 0.06, f"{FORCE_LATE}of axle_speed 1 the delay_s should be about 0 (leave it out), not 0.06"),
        (0.06, 0.0, 0.16, f"{FORCE_LATE}of axle_speed 1 the delay_s should be about 0.10, not 0.16"),
        (-0.06, 0.0, 0.0, f"{WHEEL_LATE}its delay_s should be about 0.06, not 0, unless it is the pads that press as "
         "much later than told"),
        (-0.06, 0.16, 0.0, f"{WHEEL_LATE}of pressing_force 1 the delay_s should be about 0.10, not 0.16"),
    ],
)  # fmt: skip
def test_the_delay_to_change_is_named_with_what_it_should_be(
    monkeypatch: pytest.MonkeyPatch, lag_s: float, force_s: float, wheel_s: float, said: str
) -> None:
    assert told(monkeypatch, Obeyed(0, lag_s, 0.1), force_s, wheel_s) == [said]


def test_wheelsets_that_are_taken_for_each_other_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    assert told(monkeypatch, Obeyed(1, 0.0, 0.1)) == [
        "axle_speed 1 does what pressing_force 2 says, not 1, as slides show: look at the order in both lists"
    ]


def test_what_is_in_step_is_in_no_doubt(monkeypatch: pytest.MonkeyPatch) -> None:
    assert told(monkeypatch, Obeyed(0, 0.0, 0.1)) == []
