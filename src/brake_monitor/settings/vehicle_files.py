"""Where the example vehicles are that come with the package."""

from importlib.resources import files
from pathlib import Path

EXAMPLES = ("rig", "wagon", "bogie")


def example_config(name: str) -> Path:
    """The configuration of an example vehicle: rig (1 wheelset), wagon (2) or bogie (4)."""
    return Path(str(files("brake_monitor"))) / "vehicles" / f"{name}.toml"
