"""Our own classes as numba sees them: what consists of numbers is a record, and its methods are compiled as they stand.

An object whose attributes are numbers becomes a record of the same names, a sequence of such an array of records, a
dataclass that holds them a NamedTuple, and a NamedTuple stays one. Their methods, properties and constants are then
known to compiled functions as well.
"""

from collections import namedtuple
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import fields
from functools import cache
from inspect import isfunction
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numba import types
from numba.core.typing.arraydecl import RecordAttribute
from numba.extending import overload_attribute, overload_method, register_jitable
from numpy.typing import NDArray

from brake_monitor.compiled.inlining import Inlined

# Nobody counts who uses the arrays: that takes half of the time otherwise. And methods are put in where they are
# called: to hand a core, some 150 numbers, from one to the next takes a third.
QUICKLY = {"_nrt": False, "forceinline": True, "no_cfunc_wrapper": True, "pipeline_class": Inlined}
KINDS = {float: np.float64, int: np.int64, bool: np.bool_}

class_of: dict[tuple[str, ...], type] = {}  # what records were made of, by the names of its fields


def record_type(thing: object) -> np.dtype[Any]:
    """The record that an object becomes; from now on such records have the methods of its class."""
    names = _names(thing)
    known = class_of.setdefault(names, type(thing))
    if known is not type(thing):
        raise TypeError(f"{known.__name__} and {type(thing).__name__} have the same fields")
    _teach_members(types.Record, known)
    return np.dtype([(name, _kind(getattr(thing, name))) for name in names], align=True)


def _kind(value: Any) -> Any:
    if isinstance(value, list):  # it has always as many, each a float
        return np.float64, (len(value),)
    return KINDS.get(type(value)) or record_type(value)


class Mirror:
    """Objects whose numbers, and those of the objects in them, records have."""

    def __init__(self, things: Sequence[object], records: NDArray[Any]) -> None:
        found = [list(_numbers_in(thing, records.dtype, 0)) for thing in things]
        self._owners = [[(number.owner, number.name) for number in of_one] for of_one in found]
        kinds, offsets = zip(*[(number.kind, number.offset) for number in found[0]], strict=True)
        names = [str(place) for place in range(len(kinds))]
        layout: Any = {"names": names, "formats": kinds, "offsets": offsets, "itemsize": records.dtype.itemsize}
        self._numbers = records.view(np.dtype(layout))
        self._lists = [place for place, kind in enumerate(kinds) if np.dtype(kind).shape]

    def load(self) -> None:
        """Put what the objects say into the records."""
        self._numbers[:] = [tuple([getattr(*number) for number in of_one]) for of_one in self._owners]

    def store(self) -> None:
        """Put what the records say into the objects."""
        for owners, numbers in zip(self._owners, self._numbers.tolist(), strict=True):
            for (owner, name), number in zip(owners, numbers, strict=True):
                setattr(owner, name, number)
            for place in self._lists:
                owner, name = owners[place]
                setattr(owner, name, numbers[place].tolist())


class _Number(NamedTuple):
    """An attribute of an object, and where its record has it."""

    owner: object
    name: str
    kind: np.dtype[Any]
    offset: int


def _numbers_in(thing: object, record: np.dtype[Any], begin: int) -> Iterator[_Number]:
    """The numbers of an object whose record begins there, and of the objects in it."""
    assert record.fields is not None
    for name, (kind, offset, *_) in record.fields.items():
        if kind.fields is not None:
            yield from _numbers_in(getattr(thing, name), kind, begin + offset)
        else:
            yield _Number(thing, name, kind, begin + offset)


def as_tuple(holder: type, name: str, module: str) -> Any:
    """The NamedTuple of the same names and methods as a dataclass, to be known by this name in this module."""
    names = [field.name for field in fields(holder)]
    members = {key: member for kind in reversed(holder.__mro__) for key, member in vars(kind).items()}
    own = {key: member for key, member in members.items() if not key.startswith("__") and key not in names}
    return type(name, (namedtuple(name, names),), {**own, "__slots__": (), "__module__": module})


def _names(thing: object) -> tuple[str, ...]:
    names = getattr(thing, "__struct_fields__", None) or vars(thing)
    return tuple([name for name in names if type(getattr(thing, name)) is not tuple])  # which nothing compiled reads


def teach(tuples: Iterable[type], modules: Iterable[ModuleType]) -> None:
    """Make known what NamedTuples can do, and the functions of modules beside them."""
    for module in modules:
        for function in filter(isfunction, vars(module).values()):
            _compilable(function)
    for one in tuples:
        _teach_members(types.NamedTuple, one)
        _teach_members(types.NamedUniTuple, one)


def _teach_members(kind: type, one: type) -> None:
    for name, member in vars(one).items():
        if name.startswith("__"):
            continue
        if isfunction(member):
            _teach_method(kind, name)
        elif isinstance(member, (property, int, float)):
            _teach_value(kind, name)


def _member(kind: Any, name: str) -> Any:
    """What objects of a numba type have under a name; None when it is none of our classes', or they have no such."""
    own = class_of.get(tuple(kind.fields)) if isinstance(kind, types.Record) else kind.instance_class
    return vars(own).get(name) if own is not None else None


def _find_fields(_: Any, record: Any, name: str) -> Any:
    """The type of a record's field, None for what is none.

    Numba's own raises KeyError then, and whether it is asked before those that know our methods depends on what was
    compiled before.
    """
    return record.typeof(name) if name in record.fields else None


RecordAttribute.generic_resolve = _find_fields


@cache  # once for all classes that have such a method
def _teach_method(kind: type, name: str) -> None:
    def method(thing: Any, *arguments: Any) -> Callable[..., Any] | None:
        found = _member(thing, name)
        if not isfunction(found):
            return None
        compiled = _compilable(found)

        def call(thing: Any, *arguments: Any) -> Any:
            return compiled(thing, *arguments)

        return call

    overload_method(kind, name, jit_options=QUICKLY)(method)


@cache
def _teach_value(kind: type, name: str) -> None:
    def value(thing: Any) -> Callable[..., Any] | None:
        found = _member(thing, name)
        if isinstance(found, property):
            return found.fget
        return (lambda _: found) if isinstance(found, (int, float)) else None

    overload_attribute(kind, name, jit_options=QUICKLY, strict=False)(value)


@cache
def _compilable(function: Any) -> Any:
    return register_jitable(**QUICKLY)(function)
