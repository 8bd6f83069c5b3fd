"""What `replay` and `demo` say at the end."""

from brake_monitor.commands.summary import Summary
from brake_monitor.estimation.estimate import Status
from brake_monitor.processing.pipeline import Outputs, Pipeline
from brake_monitor.settings.example_vehicles import example_settings
from estimates import alarm, estimate, wheelset

SETTINGS = example_settings("wagon")


def told(*outputs: Outputs) -> list[str]:
    """The lines after these outputs."""
    summary = Summary(SETTINGS)
    for one in outputs:
        summary.see(one)
    return summary.text(Pipeline.from_settings(SETTINGS)).splitlines()


def test_an_uncertainty_of_95_percent_says_so() -> None:
    """The live view shows one sigma: unlabelled, the two contradict each other."""
    last = estimate(wheelsets=(wheelset(friction=0.33, friction_std=0.017),))
    assert "wheelset 1: friction 0.330 ± 0.033 (95 %) at the end" in told(Outputs(estimate=last))


def test_friction_that_was_never_valid_is_no_result() -> None:
    """The nominal value and its doubt look like one."""
    first = estimate(wheelsets=(wheelset(), wheelset(friction=0.35, friction_std=0.04, friction_status=Status.INVALID)))
    last = estimate(
        wheelsets=tuple(wheelset(friction=0.35, friction_std=0.04, friction_status=Status.HELD) for _ in range(2))
    )
    lines = told(Outputs(estimate=first), Outputs(estimate=last))
    assert "wheelset 1: friction 0.350 ± 0.078 (95 %) at the end" in lines
    assert "wheelset 2: friction was not learned: it was never valid" in lines


def test_what_the_rail_gave_is_told_of_valid_estimates_alone() -> None:
    seen = [(Status.VALID, True, adhesion) for adhesion in (0.05, 0.08, 0.07)]
    seen += [(Status.VALID, False, 0.15), (Status.CONVERGING, True, 0.30), (Status.HELD, True, 0.01)]
    moments = [
        estimate(status=status, saturated=saturated, adhesion=adhesion, speed_mps=30.0 - k)
        for k, (status, saturated, adhesion) in enumerate(seen)
    ]
    lines = told(*(Outputs(estimate=moment, alarms=(alarm(kind="slide"),)) for moment in moments))
    assert lines[1] == "6 estimates, 4 valid; top speed 108.0 km/h"
    assert lines[2].endswith(": median 0.070, greatest 0.080 (3 estimates)")


def test_a_bump_tells_nothing_of_the_rail() -> None:
    """Impacts of shunting make slip for a moment, and so does walking pace."""
    slides = estimate(saturated=True, adhesion=0.05, speed_mps=3.0)
    crawls = estimate(saturated=True, adhesion=0.02, speed_mps=1.0)
    slid = (alarm(kind="slide"),)
    assert not [line for line in told(Outputs(estimate=slides)) if "rail" in line]
    assert not [line for line in told(Outputs(estimate=crawls, alarms=slid)) if "rail gave" in line]
    assert [line for line in told(Outputs(estimate=slides, alarms=slid)) if "the rail gave: median 0.050" in line]


def test_no_number_is_a_negative_zero() -> None:
    barely = estimate(adhesion=-0.0002, saturated=True)
    assert "-0.0" not in "\n".join(told(Outputs(estimate=barely, alarms=(alarm(),))))


def test_a_clock_that_was_set_back_leaves_times_that_can_be() -> None:
    alarms = (alarm(id="a", raised_time_s=101.0, cleared_time_s=102.0),)
    lines = told(Outputs(estimate=estimate(time_s=147.0)), Outputs(estimate=estimate(time_s=100.0), alarms=alarms))
    assert lines[0].startswith("wagon-8127: 47.0 s of recording")
    assert " 1.0 -     2.0 s " in lines[-2]


def test_alarms_are_counted_in_words_that_fit() -> None:
    assert "1 alarm:" in told(Outputs(alarms=(alarm(id="a"),)))
    assert "2 alarms:" in told(Outputs(alarms=(alarm(id="a"), alarm(id="b"))))
    assert "no alarms" in told(Outputs())


def test_what_an_alarm_says_has_a_line_of_its_own() -> None:
    lines = told(Outputs(alarms=(alarm(id="a", raised_time_s=3.0, cleared_time_s=None, message="Too much."),)))
    assert lines[-2].startswith("      3.0 -    open    ")
    assert lines[-1] == "    Too much."


def test_one_estimate_is_not_several() -> None:
    lines = told(Outputs(estimate=estimate(saturated=True), alarms=(alarm(),)))
    assert lines[1].startswith("1 estimate, 1 valid; ")
    assert lines[2].endswith(" (1 estimate)")
