"""The ring of a wagon's last minutes: every row in its place, whatever comes late, twice, out of order or never."""

from math import isnan, nan

import pytest

from brake_monitor.dashboard.recent import CAPACITY, JUMP_S, PATIENCE, Recent
from brake_monitor.estimation.estimate import Status
from brake_monitor.publishing.payloads import AdhesionMessage, FrictionMessage
from brake_monitor.samples import Quantity
from estimates import estimate, wheelset

BEGUN_S = 1700000000.0


def at(turn: int) -> float:
    return BEGUN_S + turn / 10.0


def wagon(turn: int, **changes: object) -> AdhesionMessage:
    return AdhesionMessage.of(estimate(time_s=at(turn), speed_mps=float(turn % 50), **changes), turn, at(turn))


def axle(turn: int, i: int, **changes: object) -> FrictionMessage:
    own = wheelset(friction=0.3 + i / 100, slip=(turn % 50) / 1000, **changes)
    return FrictionMessage.of(estimate(time_s=at(turn), wheelsets=(own,) * i), i, turn, at(turn))


def fill(recent: Recent, turns: range) -> None:
    for turn in turns:
        recent.take(wagon(turn))
        for i in (1, 2):
            recent.take_wheelset(axle(turn, i))


def everything(recent: Recent) -> dict:
    return recent.columns(0, recent.ready())


def test_rows_are_what_was_published() -> None:
    recent = Recent()
    fill(recent, range(30))
    shown = everything(recent)
    assert shown["time_s"] == pytest.approx([at(turn) for turn in range(30)], abs=1e-3)
    assert shown["speed_mps"] == list(range(30))
    assert shown["wheelsets"][2]["slip"] == pytest.approx([turn / 1000 for turn in range(30)])
    assert set(shown["wheelsets"][1]["friction"]) == {0.31}
    assert set(shown["wheelsets"][2]["friction"]) == {0.32}


def test_parts_of_an_estimate_may_come_in_any_order() -> None:
    ordered, mixed = Recent(), Recent()
    fill(ordered, range(20))
    for turn in range(20):
        parts = [wagon(turn), axle(turn, 1), axle(turn, 2)]
        for part in parts[turn % 3 :] + parts[: turn % 3]:
            if isinstance(part, AdhesionMessage):
                mixed.take(part)
            else:
                mixed.take_wheelset(part)
    assert everything(mixed) == everything(ordered)


def test_a_row_is_held_back_until_it_is_complete_but_not_for_long() -> None:
    recent = Recent()
    fill(recent, range(10))
    recent.take(wagon(10))
    assert recent.ready() == 10
    recent.take_wheelset(axle(10, 1))
    recent.take_wheelset(axle(10, 2))
    assert recent.ready() == 11
    for turn in range(11, 11 + PATIENCE):  # wheelset 2 was lost on the way for good
        recent.take(wagon(turn))
        recent.take_wheelset(axle(turn, 1))
    assert recent.ready() == 11
    recent.take(wagon(11 + PATIENCE))
    assert recent.ready() == 12
    assert isnan(everything(recent)["wheelsets"][2]["slip"][11])


def test_it_never_grows_and_tells_who_lags_all_that_is_left() -> None:
    recent = Recent()
    fill(recent, range(CAPACITY + 500))
    shown = recent.columns(0, recent.ready())
    assert len(shown["time_s"]) == CAPACITY
    assert shown["time_s"][0] == pytest.approx(at(500), abs=1e-3)
    assert len(recent.columns(recent.ready() - 3, recent.ready())["wheelsets"][1]["slip"]) == 3


def test_the_past_goes_before_what_is_there_once() -> None:
    whole, late = Recent(), Recent()
    fill(whole, range(100))
    fill(late, range(60, 90))
    epoch = late.epoch
    past = range(100)  # the answer overlaps what was heard live
    late.precede([wagon(turn) for turn in past], [axle(turn, i) for turn in past for i in (1, 2)])
    assert late.epoch != epoch  # pages begin anew
    late.precede([wagon(turn) for turn in past], [axle(turn, i) for turn in past for i in (1, 2)])
    fill(late, range(90, 100))
    assert everything(late) == everything(whole)


def test_of_the_past_only_as_much_is_taken_as_there_is_room() -> None:
    recent = Recent()
    fill(recent, range(1000, CAPACITY))
    past = range(2000 - CAPACITY, 1000)
    recent.precede([wagon(turn) for turn in past], [axle(turn, 1) for turn in past])
    shown = everything(recent)
    assert len(shown["time_s"]) == CAPACITY
    assert shown["time_s"][0] == pytest.approx(at(0), abs=1e-3)
    assert shown["time_s"][-1] == pytest.approx(at(CAPACITY - 1), abs=1e-3)


def test_a_wheelset_that_is_heard_of_late_is_unknown_before() -> None:
    recent = Recent()
    for turn in range(5):
        recent.take(wagon(turn))
    recent.take_wheelset(axle(4, 3))
    assert recent.wheelsets == [3]
    slips = recent.columns(0, recent.count)["wheelsets"][3]["slip"]
    assert all(isnan(slip) for slip in slips[:4])
    assert slips[4] == pytest.approx(0.004)


def test_time_that_jumps_back_begins_anew_and_a_straggler_does_not() -> None:
    recent = Recent()
    fill(recent, range(100, 200))
    epoch = recent.epoch
    recent.take(wagon(185))
    recent.take(wagon(199))
    assert (recent.count, recent.epoch) == (100, epoch)
    back = 199 - int(JUMP_S * 10) - 50
    fill(recent, range(back, back + 3))
    assert everything(recent)["time_s"] == pytest.approx([at(turn) for turn in range(back, back + 3)], abs=1e-3)
    assert recent.epoch != epoch


def test_held_is_told_and_what_is_no_number_is_not_known() -> None:
    recent = Recent()
    recent.take(wagon(0, adhesion=nan))
    recent.take_wheelset(axle(0, 1, friction_status=Status.HELD, pressing_force_n=1e300))
    recent.take(wagon(1, status=Status.INVALID))
    recent.take_wheelset(axle(1, 1, friction_status=Status.INVALID))
    shown = everything(recent)
    assert isnan(shown["adhesion"][0])
    assert shown["wheelsets"][1]["held"] == [1.0, 0.0]
    assert isnan(shown["speed_mps"][1])
    assert isnan(shown["wheelsets"][1]["friction"][1])
    assert shown["wheelsets"][1]["pressing_force_n"][1] == 41000.0
    assert isnan(shown["wheelsets"][1]["pressing_force_n"][0])


def test_what_was_never_told_is_not_known() -> None:
    recent, unknown = Recent(), frozenset({(quantity, 0) for quantity in Quantity})
    recent.take(wagon(0, unknown=unknown))
    told_little = estimate(time_s=at(0), unknown=unknown)
    recent.take_wheelset(FrictionMessage.of(told_little, 1, 0, at(0)))
    shown = everything(recent)
    assert isnan(shown["speed_mps"][0])
    told = ("slip", "omega_radps", "pressing_force_n", "wsp_active")
    assert all(isnan(shown["wheelsets"][1][name][0]) for name in told)
    assert not isnan(shown["wheelsets"][1]["friction"][0])
