"""python-can without asammdf, which it loads where it is installed, and pandas and sympy with it, for .mf4 alone.

A program that asks for this before anything loads python-can, as cantools does, begins a second sooner.
"""

import importlib
import sys
from types import ModuleType


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
