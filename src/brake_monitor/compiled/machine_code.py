"""Functions as machine code, which is made as they are called first and kept on disk.

OSError, RuntimeError or WorkError where nothing can be kept.
"""

import sys
from collections.abc import Callable
from hashlib import sha256
from importlib.util import module_from_spec, spec_from_file_location
from typing import Any

from numba import config, njit, types

from brake_monitor.compiled.code_folder import folder
from brake_monitor.host.whole_file import whole_file

FLAT = types.void(types.float64[::1], types.float64[::1])


def compiled(function: Callable[..., Any]) -> Any:
    """A function that numba compiles as it is called, or finds on disk."""
    config.CACHE_DIR = str(folder())
    return njit(cache=True, error_model="numpy", _nrt=False)(function)


class FlatFunction(types.WrapperAddressProtocol):  # type: ignore[misc] # numba is not typed
    """A compiled function of numbers given in one array to numbers in another, as other compiled functions call it."""

    def __init__(self, source: str) -> None:
        """`source`: of a function `straight(given, result)`."""
        name = f"straight_{sha256(source.encode()).hexdigest()[:16]}"
        self._dispatcher = compiled(_function(name, source))  # keeps the code alive
        self._dispatcher.compile(FLAT.args)
        code = self._dispatcher.overloads[FLAT.args]
        self._address: int = code.library.get_pointer_to_function(code.fndesc.llvm_cfunc_wrapper_name)

    def __call__(self, given: Any, result: Any) -> None:
        """Calculate."""
        self._dispatcher(given, result)

    def __wrapper_address__(self) -> int:
        return self._address

    def signature(self) -> Any:
        """The signature: one array in, one array out."""
        return FLAT


def _function(name: str, source: str) -> Callable[..., Any]:
    """The function in a file and a module of its own, where numba looks both up."""
    path = folder() / f"{name}.py"
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(path) as part:  # other processes may want it as well
            part.write_text(source, encoding="utf-8")
    spec = spec_from_file_location(name, path)
    assert spec is not None  # of a file that ends in .py
    assert spec.loader is not None
    module = sys.modules[name] = module_from_spec(spec)
    spec.loader.exec_module(module)
    function: Callable[..., Any] = module.straight
    return function
