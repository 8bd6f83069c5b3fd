"""What `replay` and `demo` say at the end."""

from brake_monitor.commands.summary import Summary
from brake_monitor.processing.pipeline import Outputs, Pipeline
from brake_monitor.settings.config_file import load_settings
from brake_monitor.settings.vehicle_files import example_config
from estimates import alarm, estimate, wheelset

SETTINGS = load_settings(example_config("wagon"))


def told(*outputs: Outputs) -> list[str]:
    """The lines after these outputs."""
    summary = Summary(SETTINGS)
    for one in outputs:
        summary.see(one)
    return summary.text(Pipeline.from_settings(SETTINGS)).splitlines()


def test_an_uncertainty_of_two_sigma_says_so() -> None:
    """The live view shows one sigma: unlabelled, the two contradict each other."""
    last = estimate(wheelsets=(wheelset(friction=0.33, friction_std=0.017),))
    assert "wheelset 1: friction 0.330 ± 0.034 (95 %) at the end" in told(Outputs(estimate=last))


def test_alarms_are_counted_in_words_that_fit() -> None:
    assert "1 alarm:" in told(Outputs(alarms=(alarm(id="a"),)))
    assert "2 alarms:" in told(Outputs(alarms=(alarm(id="a"), alarm(id="b"))))
    assert "no alarms" in told(Outputs())
