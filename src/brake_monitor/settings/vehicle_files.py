"""Where the example vehicles are that come with the package."""

from importlib.resources import files
from pathlib import Path

EXAMPLES = ("rig", "wagon", "bogie", "railcar")


def example_config(name: str) -> Path:
    """The configuration of an example vehicle: rig (1 wheelset), wagon (2), bogie (4), railcar (4, for motors)."""
    return Path(str(files("brake_monitor"))) / "vehicles" / f"{name}.toml"
