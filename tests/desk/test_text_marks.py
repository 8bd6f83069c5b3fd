"""How values look as text, in a terminal."""

import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from brake_monitor.desk.text_marks import Moment, band, bar, number, plus_minus, scale_top, sparkline

NAN = math.nan
ANY = st.floats(allow_nan=True, allow_infinity=True)


def test_what_is_no_number_is_a_dash() -> None:
    assert (number(1.25, 1), number(NAN, 1, 5), number(math.inf, 3)) == ("1.2", "    –", "–")
    assert plus_minus(0.0834, 0.0061) == " 0.083 ±0.006"
    assert plus_minus(NAN, NAN) == "     – ±    –"


def test_so_is_what_no_measurement_can_be() -> None:
    """In full it would have 309 digits."""
    assert (number(1e308, 1, 5), number(-1e308, 3), number(1e8, 0)) == ("    –", "–", "100000000")


def test_what_rounds_to_nothing_has_no_sign() -> None:
    assert (number(-0.0004, 3), number(-0.0006, 3), plus_minus(-0.0001, 0.0012)) == ("0.000", "-0.001", " 0.000 ±0.001")


def test_a_bar_grows_with_its_value() -> None:
    assert (bar(0.0, 10.0, 4), bar(5.0, 10.0, 4), bar(10.0, 10.0, 4)) == ("    ", "██  ", "████")
    assert bar(5.0 + 10.0 / 32, 10.0, 4) == "██▏ "
    assert (bar(99.0, 10.0, 4), bar(-1.0, 10.0, 4), bar(NAN, 10.0, 4)) == ("████", "    ", "    ")


def test_a_band_stands_where_its_value_is_on_the_scale() -> None:
    assert band(0.055, 0.02, 0.10, 10) == "───▒▒█▒▒──"
    assert band(0.0, 0.0, 0.10, 10) == "█─────────"
    assert band(0.5, 0.0, 0.10, 10) == "─────────█"
    assert band(NAN, 0.01, 0.10, 10) == "──────────"


@given(value=ANY, std=st.just(NAN) | st.floats(min_value=0.0), width=st.integers(1, 60))
def test_a_bar_and_a_band_keep_their_width_whatever_comes(value: float, std: float, width: int) -> None:
    assert len(bar(value, 1.0, width)) == width
    assert len(band(value, std, 0.1, width)) == width
    assert len(sparkline([Moment(value, False)] * width, 0.1)) == width


def test_a_sparkline_rises_with_adhesion_and_is_empty_where_nothing_is_known() -> None:
    values = [Moment(0.1 * i / 8, False) for i in range(1, 9)]
    assert sparkline([*values, None, Moment(NAN, False), Moment(-0.01, False)], 0.1) == "▁▂▃▄▅▆▇█  ▁"


def test_of_a_moment_the_lowest_adhesion_while_saturated_is_shown_else_the_last() -> None:
    """What is used of a rail that gives more says nothing of it."""
    low, lower, used = Moment(0.05, True), Moment(0.03, True), Moment(0.02, False)
    assert (low.beside(None), used.beside(None)) == (low, used)
    assert (lower.beside(low), low.beside(lower)) == (lower, lower)
    assert (used.beside(low), low.beside(used)) == (low, low)
    assert Moment(0.08, False).beside(used) == Moment(0.08, False)


def test_the_scale_holds_every_value() -> None:
    assert scale_top([]) == pytest.approx(0.10)
    assert scale_top([0.15, NAN]) == pytest.approx(0.15)
    assert scale_top([0.151]) == pytest.approx(0.20)


@given(st.lists(ANY))
@example([1e308])
@example([-1e307])
def test_there_is_a_scale_for_anything(values: list[float]) -> None:
    assert 0.10 <= scale_top(values) < math.inf
