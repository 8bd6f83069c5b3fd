"""What machine code knows of a tuple that it holds: the same places, whatever is in them by now."""

from typing import Any, NamedTuple

import numpy as np
import pytest

pytest.importorskip("numba")

from numba import njit, types

from brake_monitor.compiled import held_tuple
from brake_monitor.compiled.held_tuple import HeldTuple


class Thing(NamedTuple):
    record: Any
    table: Any
    number: float


def add_all(thing: Any, more: float) -> float:
    thing.table[0, 1] += more
    return float(thing.record.a + thing.table[0, 1] + thing.number)


def uncounted(function: Any) -> Any:
    """As the product compiles, but that it keeps nothing on disk, where others would find our type."""
    return njit(error_model="numpy", _nrt=False)(function)


def test_machine_code_finds_what_was_changed_since_and_changes_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(held_tuple, "compiled", uncounted)
    records = np.zeros(1, np.dtype([("a", np.float64), ("b", np.int64)], align=True))
    table = np.zeros((2, 3))
    held = HeldTuple(Thing(records[0], table, 100.0))
    function = uncounted(add_all)
    function.compile((held.kind, types.float64))
    call = function.overloads[held.kind, types.float64].entry_point

    records["a"], table[0, 1] = 1.0, 10.0

    assert call(held, 1000.0) == 1111.0
    assert call(held, 1000.0) == 2111.0
    assert table[0, 1] == 2010.0


def test_code_that_counts_references_may_not_have_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """It would give back what it has not taken, and spoil the memory of whoever has it by then."""
    monkeypatch.setattr(held_tuple, "compiled", uncounted)
    records = np.zeros(1, np.dtype([("a", np.float64), ("b", np.int64)], align=True))
    held = HeldTuple(Thing(records[0], np.zeros((2, 3)), 100.0))
    with pytest.raises(AssertionError):
        njit(add_all).compile((held.kind, types.float64))
