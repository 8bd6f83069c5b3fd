"""A gateway that tells what it was told last, when nothing reaches it any more: all speeds agree, and are wrong."""

import pytest

from brake_monitor.estimation.doubts.consistency import Doubt
from brake_monitor.estimation.doubts.still_speeds import MANY_TIMES, STILL_S, TURNS_SEEN, StillSpeeds
from brake_monitor.estimation.estimate import Status
from drives import DRY, Judged, drive, play
from faults import Fault, changed

SIGNALS = (("GNSS", "v_ground"), ("WSP", "n_A"), ("WSP", "n_B"), ("BCU", "p_A"), ("BCU", "p_B"))
PERIOD_S = 0.01


def told_again(message: str, signal: str, from_s: float, to_s: float) -> Fault:
    """A value is told again and again."""
    told: list[float] = []

    def again(_: float, value: float) -> float:
        told.append(value)
        return told[0]

    return changed(message, (signal,), again, from_s, to_s)


@pytest.mark.parametrize("from_s", [14.0, 16.5])
def test_what_a_gateway_tells_again_and_again_is_not_valid_for_long(from_s: float) -> None:
    """The brake is put on meanwhile, of which nothing tells."""
    recording, frames = drive(DRY), list(drive(DRY).frames)
    for message, signal in SIGNALS:
        frames = told_again(message, signal, from_s, 23.0)(frames)
    seen = Judged.of(recording, play(recording.settings, frames))
    seen.assert_sound()
    seen.assert_honest()
    during = seen.during(from_s + 1.5, 23.0)
    assert during.statuses == {Status.CONVERGING}
    assert all(Doubt.REPEATED in estimate.reasons for estimate in during.told)
    assert Doubt.REPEATED not in seen.during(1.0, from_s).reasons


def still_after_s(*, turns_every: int) -> float | None:
    """After how long standing still is in doubt, of speeds that turn back so often as the wagon coasts; None: never."""
    speeds, learned = StillSpeeds(), TURNS_SEEN * turns_every
    for k in range(learned):
        assert not speeds.see(k * PERIOD_S, k % turns_every > 0, k % turns_every == 0, coasts=True)
    for k in range(10 * learned):
        if speeds.see((learned + k) * PERIOD_S, k > 0, turns=False, coasts=True):
            return k * PERIOD_S
    return None


@pytest.mark.parametrize(("turns_every", "doubted_s"), [(2, STILL_S), (5, STILL_S), (30, 30 * MANY_TIMES * PERIOD_S)])
def test_the_noisier_sensors_are_the_sooner_they_are_doubted(turns_every: int, doubted_s: float) -> None:
    """What hardly ever went to and fro may as well stand still."""
    assert still_after_s(turns_every=turns_every) == pytest.approx(doubted_s, abs=3 * PERIOD_S)


def test_coarse_sensors_without_noise_are_never_doubted() -> None:
    """They stand still until the wagon has lost a step of theirs; then all of them go on the same way."""
    speeds = StillSpeeds()
    for k in range(100_000):
        assert not speeds.see(k * PERIOD_S, k % 1500 > 0, turns=k == 1500, coasts=True)


def test_sensors_that_stand_still_between_two_of_their_steps_are_doubted_once() -> None:
    """Their noise shows only as the speed passes from one step to the next."""
    speeds, doubts = StillSpeeds(), []
    for stretch in range(5):
        for k in range(2000):
            passes = k < 800
            doubted = speeds.see((stretch * 2000 + k) * PERIOD_S, not passes, turns=passes, coasts=True)
            doubts += [stretch] if doubted else []
    assert set(doubts) == {0}


def test_a_brake_teaches_nothing_of_noise() -> None:
    """As a wagon loses speed quickly, readings of it hardly ever turn back."""
    speeds = StillSpeeds()
    for k in range(TURNS_SEEN):
        speeds.see(k * PERIOD_S, repeats=False, turns=True, coasts=True)
    for k in range(TURNS_SEEN, 3000):
        speeds.see(k * PERIOD_S, repeats=False, turns=False, coasts=False)
    assert any(speeds.see((3000 + k) * PERIOD_S, repeats=True, turns=False, coasts=False) for k in range(110))


def test_a_clock_that_is_set_back_begins_anew() -> None:
    """Else what was told before it would count."""
    speeds = StillSpeeds()
    for k in range(TURNS_SEEN):
        speeds.see(100.0 + k * PERIOD_S, repeats=False, turns=True, coasts=True)
    for k in range(60):
        assert not speeds.see(110.0 + k * PERIOD_S, k > 0, turns=False, coasts=True)
    assert not any(speeds.see(10.0 + k * PERIOD_S, repeats=True, turns=False, coasts=True) for k in range(90))
