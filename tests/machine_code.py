"""Machine code for tests: who needs it makes it, and then all that play recordings have it."""

from brake_monitor.compiled.code_maker import make
from brake_monitor.compiled.compiled_estimator import CompiledEstimator
from brake_monitor.compiled.kept_code import EstimatorOrder, KeptCode
from brake_monitor.estimation.estimator import Estimator


def by_machine_code(estimator: Estimator) -> CompiledEstimator:
    """The estimator by its machine code, which is made here and now where it is not kept yet."""
    code = KeptCode(EstimatorOrder.of(estimator))
    if not code.is_ready:
        make(code.ordered())
    return CompiledEstimator(estimator)
