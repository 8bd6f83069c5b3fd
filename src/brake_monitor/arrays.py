"""Arrays by what is in them."""

import numpy as np
from numpy.typing import NDArray

Bools = NDArray[np.bool_]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bytes = NDArray[np.uint8]
Words = NDArray[np.uint64]


def indices(values: Ints) -> NDArray[np.intp]:
    """The same as numpy counts and repeats by: a processor of 32 bits takes no larger integers there."""
    return values.astype(np.intp, copy=False)
