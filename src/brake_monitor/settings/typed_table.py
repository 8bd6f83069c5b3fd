"""A table of TOML against the type of what it configures: keys, types, bounds, finite numbers."""

import operator
from math import isfinite, nan
from typing import Any

from msgspec import inspect

from brake_monitor.nearest import nearest
from brake_monitor.settings.config_text import ConfigText, one_of, shown
from brake_monitor.settings.toml_lines import KeyPath


def check_table(text: ConfigText, value: Any, wanted: inspect.Type, key: KeyPath) -> None:
    """Compare `value` with the type of the setting at `key`: keys, types, bounds, finite numbers."""
    match wanted:
        case inspect.StructType():
            _check_keys(text, value, wanted, key)
        case inspect.VarTupleType():
            if not isinstance(value, list):
                text.refuse(key, f"expected a list, got {shown(value)}")
            for place, entry in enumerate(value):
                check_table(text, entry, wanted.item_type, (*key, place))
        case inspect.UnionType():
            _check_union(text, value, wanted, key)
        case _:
            if is_number(value) and not _is_finite(value):
                text.refuse(key, f"expected a finite number, got {shown(value)}")
            if not _fits(value, wanted):
                text.refuse(key, f"expected {_expected(wanted, value)}, got {shown(value)}")
            if isinstance(value, str) and "\0" in value:  # the system takes none in a path or name
                text.refuse(key, "expected text without the character NUL")
            if isinstance(wanted, inspect.CustomType) and not value:  # it would be the folder itself
                text.refuse(key, "expected a name, got an empty string")


def _check_union(text: ConfigText, value: Any, wanted: inspect.UnionType, key: KeyPath) -> None:
    """Where a value may be absent, which TOML has no word for, or where a word may take the place of a table."""
    present, *others = (t for t in wanted.types if not isinstance(t, inspect.NoneType))
    words = [word for other in others if isinstance(other, inspect.LiteralType) for word in other.values]
    if words and not isinstance(value, dict):
        if value not in words:
            text.refuse(key, f"expected a table or {' or '.join(map(shown, words))}, got {shown(value)}")
        return
    check_table(text, value, present, key)


def _check_keys(text: ConfigText, table: Any, wanted: inspect.StructType, key: KeyPath) -> None:
    if not isinstance(table, dict):
        text.refuse(key, f"expected a table, got {shown(table)}")
    fields = {field.name: field for field in wanted.fields if (*key, field.name) != ("path",)}
    for name in table:
        if name not in fields:
            text.refuse((*key, name), f"unknown key, {nearest(name, list(fields))}")
    for name, field in fields.items():
        if name in table:
            check_table(text, table[name], field.type, (*key, name))
        elif field.required:
            text.refuse((*key, name), "this key is missing")


def is_number(value: Any) -> bool:
    """Whether it was written as a number."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def _fits(value: Any, wanted: inspect.Type) -> bool:
    match wanted:
        case inspect.FloatType() | inspect.IntType():
            if not is_number(value) or (isinstance(wanted, inspect.IntType) and not isinstance(value, int)):
                return False
            return all(holds for _, _, holds in _bounds(wanted, value))
        case inspect.BoolType():
            return isinstance(value, bool)
        case inspect.LiteralType():
            return value in wanted.values
        case _:  # text, and paths which are written as text
            return isinstance(value, str)


def _is_finite(value: float) -> bool:
    try:
        return isfinite(value)
    except OverflowError:  # an integer beyond the largest float
        return False


def _bounds(wanted: inspect.FloatType | inspect.IntType, value: float) -> list[tuple[str, float, bool]]:
    """Each bound in words, and whether the value keeps it."""
    bounds = (
        ("greater than", wanted.gt, operator.gt),
        ("not less than", wanted.ge, operator.ge),
        ("less than", wanted.lt, operator.lt),
        ("not greater than", wanted.le, operator.le),
    )
    return [(words, bound, holds(value, bound)) for words, bound, holds in bounds if bound is not None]


def _expected(wanted: inspect.Type, value: Any) -> str:
    match wanted:
        case inspect.FloatType() | inspect.IntType():
            noun = "a whole number" if isinstance(wanted, inspect.IntType) else "a number"
            bounds = _bounds(wanted, value if is_number(value) else nan)
            broken = next((f" {words} {bound:g}" for words, bound, holds in bounds if not holds), "")
            return noun + broken
        case inspect.BoolType():
            return "true or false"
        case inspect.LiteralType():
            return one_of(wanted.values)
        case _:
            return "a string"
