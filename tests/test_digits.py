"""Numbers for people to read."""

import pytest

from brake_monitor.digits import significant


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (66_128.0, 3, "66100"),
        (356_160.0, 5, "356160"),
        (33.366, 4, "33.37"),
        (0.000_123_4, 2, "0.00012"),
        (0.0, 3, "0"),
        (-0.0, 3, "0"),
        (-4650.0, 2, "-4600"),
        (1e300, 3, "1e+300"),
    ],
)
def test_so_many_digits_and_no_power_of_ten_where_a_person_reads_without(value: float, digits: int, text: str) -> None:
    assert significant(value, digits) == text
