"""What is thought of one pressing force, by shares of its brake that are given by hand."""

import pytest

from brake_monitor.estimation.brake_work import WheelsetWork
from brake_monitor.monitoring.inputs.watched_force import ForceState, ShownShare, WatchedForce
from estimates import estimate, wheelset


@pytest.mark.parametrize(("noise_std", "after_s"), [(0.05, 1.0), (0.3, 5.0)])
def test_the_noisier_the_wheel_speeds_the_longer_it_takes_to_contradict(noise_std: float, after_s: float) -> None:
    """Three deviations of a mean over so long: of 0.3 in a second they are half of a brake after 3.2 s."""
    force = WatchedForce()
    for _ in range(round(after_s * 10) // 2):
        force.see(ShownShare(1.0, noise_std=noise_std), None, presses=False)
    early = force.state
    for _ in range(round(after_s * 10) // 2):
        force.see(ShownShare(1.0, noise_std=noise_std), None, presses=False)
    assert force.state is ForceState.CONTRADICTED
    assert early is (ForceState.UNKNOWN if noise_std > 0.1 else ForceState.CONTRADICTED)


@pytest.mark.parametrize(
    ("lasting_std", "noise_std", "observations", "state"),
    [
        (0.0, 0.0, 4, ForceState.UNKNOWN),
        (0.0, 0.0, 5, ForceState.CONTRADICTED),
        (0.0, 0.2, 5, ForceState.UNKNOWN),  # as good as one second, in which it is half of a brake and more
        (0.0, 0.12, 5, ForceState.CONTRADICTED),
        (0.2, 0.0, 500, ForceState.UNKNOWN),  # it does not become less
        (0.15, 0.0, 50, ForceState.CONTRADICTED),
        (0.15, 0.0, 10, ForceState.UNKNOWN),  # nothing is told better than to a tenth in a second
    ],
)
def test_a_brake_that_works_unseen_is_known_by_three_deviations(
    lasting_std: float, noise_std: float, observations: int, state: ForceState
) -> None:
    """It does all that is expected of it, where half would be as good as none."""
    force = WatchedForce()
    for _ in range(observations):
        force.see(ShownShare(1.0, lasting_std=lasting_std, noise_std=noise_std), None, presses=False)
    assert force.state is state


@pytest.mark.parametrize(
    ("by_creep", "by_retardation", "works", "is_doubted"),
    [
        (0.8, 0.9, True, False),  # rather as a brake that works, and the wagon is sure
        (0.5, 0.9, None, True),
        (0.2, 0.9, None, True),  # a line that rises as the others come on looks like this, too
        (0.2, 0.1, False, False),
        (0.5, 0.1, None, False),
        (0.8, 0.1, None, False),
        (0.8, None, None, False),  # in a train
    ],
)
@pytest.mark.parametrize("presses", [False, True])
def test_where_creep_is_in_doubt_the_retardation_decides_as_creep_leans(
    by_creep: float, by_retardation: float | None, *, works: bool | None, is_doubted: bool, presses: bool
) -> None:
    """What creep shows is as uncertain as a fifth of a brake, which is less than three times what is missing to sure.

    Where the wagon says that a silent brake works, or one that presses does not, and creep does not say so, estimates
    are in doubt as long as its sensor says that.
    """
    force = WatchedForce()
    for _ in range(50):
        retardation = None if by_retardation is None else 1.0 - by_retardation if presses else by_retardation
        creep = ShownShare(1.0 - by_creep if presses else by_creep, lasting_std=0.2)
        force.see(creep, None if retardation is None else ShownShare(retardation), presses=presses)
    contradicts = {True: ForceState.CONTRADICTED, False: ForceState.BORNE_OUT, None: ForceState.UNKNOWN}
    assert force.state is contradicts[works]
    assert (force.may_be_idle, force.may_press_unseen) == (is_doubted and presses, is_doubted and not presses)
    force.forget()  # its sensor says something else
    assert (force.may_be_idle, force.may_press_unseen) == (False, False)


@pytest.mark.parametrize(("pressed_before_s", "state"), [(50.0, ForceState.CONTRADICTED), (70.0, ForceState.UNKNOWN)])
def test_a_wheelset_that_slides_anew_contradicts_a_sensor_that_has_pressed_lately(
    pressed_before_s: float, state: ForceState
) -> None:
    """Else its brake may stick."""
    force = WatchedForce()
    for time_s, force_n, slides in ((100.0, 40e3, 0), (101.0, 0.0, 0), (100.0 + pressed_before_s, 0.0, 1)):
        own = wheelset(pressing_force_n=force_n, renewed_slides=slides, work=WheelsetWork(wsp_actions=2))
        force.see_slides(estimate(time_s=time_s, wheelsets=(own,)), 0, presses=False)
    assert force.state is state


def test_a_sensor_that_a_slide_contradicts_is_not_believed_before_it_moves_however_long_that_takes() -> None:
    force = WatchedForce()
    states = {}
    for time_s, force_n, slides in (
        (100.0, 40e3, 0),
        (101.0, 0.0, 0),
        (105.0, 0.0, 1),
        (200.0, 0.0, 1),
        (201.0, 2e4, 0),
    ):
        own = wheelset(pressing_force_n=force_n, renewed_slides=slides, work=WheelsetWork(wsp_actions=2))
        force.see_slides(estimate(time_s=time_s, wheelsets=(own,)), 0, presses=False)
        states[time_s] = force.state
    assert states[105.0] is states[200.0] is ForceState.CONTRADICTED
    assert states[201.0] is ForceState.UNKNOWN
