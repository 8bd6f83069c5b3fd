"""The plant's inner functions as machine code where numba is installed (extra `fast`), else as they stand.

One source, one set of numbers: a compiled function takes and returns plain numbers, reads vectors (lists without numba
and arrays with it, both indexed alike), and changes records, whose memory Python looks at as well.
"""

from collections.abc import Callable, Iterable, Sequence
from ctypes import Structure, c_double
from inspect import get_annotations
from typing import Any, TypeVar, cast

import numpy as np

Function = TypeVar("Function", bound=Callable[..., Any])
Record = TypeVar("Record", bound=Structure)
Vector = Sequence[float]

HOW_TO_BE_FASTER = "the simulator is ten times faster with the extra 'fast' (numba)"

try:
    from numba import config, njit
except (ImportError, OSError):  # not installed, or the service may have no executable memory
    IS_COMPILED = False
else:
    IS_COMPILED = not config.DISABLE_JIT


def compiled(function: Function) -> Function:
    """The function as machine code, kept on disk from its first call on where there is room for it."""
    if not IS_COMPILED:
        return function
    try:
        return cast(Function, njit(cache=True, error_model="numpy")(function))
    except RuntimeError:  # no folder for it can be written to
        return cast(Function, njit(error_model="numpy")(function))


def vector(values: Iterable[float]) -> Vector:
    """Numbers that a compiled function reads."""
    return cast(Vector, np.array(list(values), dtype=np.float64)) if IS_COMPILED else list(values)


def record(kind: type[Record]) -> type[Record]:
    """Make a kind of record of a ctypes structure that names its numbers by annotations."""
    kind._fields_ = [(name, c_double) for name in get_annotations(kind)]
    return kind


def side_by_side(records: Sequence[Record]) -> tuple[list[Record], Sequence[Record]]:
    """The records in one piece of memory: each for Python, and all as a compiled function takes them."""
    row = (type(records[0]) * len(records))(*records)
    each = list(row)
    return each, cast(Sequence[Record], np.ctypeslib.as_array(row)) if IS_COMPILED else each
