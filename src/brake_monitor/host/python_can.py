"""Loads no more of python-can and cantools than a program needs.

python-can loads asammdf where that is installed, and pandas and sympy with it, which only .mf4 needs: a program without
begins a second sooner. cantools loads python-can, which nothing needs that reads a DBC: a daemon on SocketCAN without
it has 5 MB less and begins a tenth of a second sooner. Ask for either before anything else loads the one or the other.
"""

import importlib
import sys
from contextlib import suppress
from importlib.util import find_spec, module_from_spec
from types import ModuleType


def load_cantools_alone() -> None:
    """Load what of cantools reads a DBC, without python-can, unless one of them is loaded already."""
    if not {"can", "cantools"}.isdisjoint(sys.modules):
        return
    spec = find_spec("cantools")
    assert spec is not None
    sys.modules["cantools"] = module_from_spec(spec)  # where its modules are, without what it does when it is loaded
    try:
        with suppress(ImportError, AttributeError):  # one that cannot be taken apart is loaded whole later
            importlib.import_module("cantools.database")
    finally:
        del sys.modules["cantools"]  # who wants all of it gets it


def load_without_asammdf() -> None:
    """Load python-can as if asammdf were not installed, unless one of them is loaded already."""
    if not {"can", "asammdf"}.isdisjoint(sys.modules):
        return
    sys.modules["asammdf"] = None  # type: ignore[assignment]  # which is how Python notes that there is no such module
    try:
        import can  # noqa: F401, PLC0415 - not before what stands above
    finally:
        del sys.modules["asammdf"]


def mf4() -> ModuleType:
    """Its readers and writers of .mf4, now with asammdf."""
    module = importlib.import_module("can.io.mf4")
    return module if module.asammdf else importlib.reload(module)
