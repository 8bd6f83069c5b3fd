"""The process that makes machine code: `python -m brake_monitor.compiled.code_maker ORDER…`; `kept_code` starts it."""

import fcntl
import sys
from pathlib import Path

import msgspec

from brake_monitor.compiled.compiled_estimator import CompiledEstimator
from brake_monitor.compiled.kept_code import LOCK, READY, EstimatorOrder


def make(path: Path) -> None:
    """Make the machine code of the estimator that is ordered in a file, which is then the sign that it is there.

    One maker at a time: numba keeps one index of all that is there, which two would damage for good.
    """
    with path.parent.with_suffix(LOCK).open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not path.exists():  # another one was told to make it, too, and has
            return
        order = msgspec.msgpack.decode(path.read_bytes(), type=EstimatorOrder)
        CompiledEstimator(order.estimator())
        path.rename(path.with_suffix(READY))


if __name__ == "__main__":
    for order in sys.argv[1:]:
        make(Path(order))
