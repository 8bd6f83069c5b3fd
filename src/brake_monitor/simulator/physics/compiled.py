"""The plant's inner functions as machine code where numba is installed (extra `fast`), else as they stand.

One source, one set of numbers: a compiled function takes and returns plain numbers, and vectors that are lists
without numba and arrays with it; both are indexed alike.
"""

from collections.abc import Callable, Iterable, MutableSequence
from typing import Any, TypeVar, cast

import numpy as np

Function = TypeVar("Function", bound=Callable[..., Any])
Vector = MutableSequence[float]

HOW_TO_BE_FASTER = "the simulator is ten times faster with the extra 'fast' (numba)"

try:
    from numba import njit
except (ImportError, OSError):  # not installed, or the service may have no executable memory
    IS_COMPILED = False
else:
    IS_COMPILED = True


def compiled(function: Function) -> Function:
    """The function as machine code, kept on disk from its first call on where there is room for it."""
    if not IS_COMPILED:
        return function
    try:
        return cast(Function, njit(cache=True, error_model="numpy")(function))
    except RuntimeError:  # no folder for it can be written to
        return cast(Function, njit(error_model="numpy")(function))


def vector(values: Iterable[float]) -> Vector:
    """Numbers that a compiled function reads and changes."""
    return cast(Vector, np.array(list(values), dtype=np.float64)) if IS_COMPILED else list(values)
