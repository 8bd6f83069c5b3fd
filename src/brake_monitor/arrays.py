"""Arrays by what is in them."""

import numpy as np
from numpy.typing import NDArray

Bools = NDArray[np.bool_]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bytes = NDArray[np.uint8]
Words = NDArray[np.uint64]


def indices(values: Ints) -> NDArray[np.intp]:
    """The same as np.bincount and np.repeat take them: where a processor has 32 bits they refuse those of 64."""
    return values.astype(np.intp, copy=False)
