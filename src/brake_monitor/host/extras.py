"""Packages that not every user needs, which are installed as extras."""

from importlib import import_module
from importlib.util import find_spec

from brake_monitor.errors import InputError

PACKAGES = {
    "dashboard": "aiohttp",
    "desk": "rich",
    "metrics": "prometheus_client",
    "mf4": "asammdf",
    "parquet": "pyarrow",
    "report": "matplotlib",
}


def is_installed(extra: str) -> bool:
    """Whether the package that an extra brings is there."""
    return find_spec(PACKAGES[extra]) is not None


def require(extra: str, what: str) -> None:
    """Load an extra that `what` needs; where that fails, InputError tells how to install it."""
    try:
        import_module(PACKAGES[extra])
    except ImportError:
        raise InputError(f"{what} needs the extra '{extra}': {how_to_install(extra)}") from None


def how_to_install(extra: str) -> str:
    """A command for the checkout that this was installed from."""
    return f"pip install '.[{extra}]' in the checkout"
