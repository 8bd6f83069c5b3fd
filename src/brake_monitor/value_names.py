"""Values bear their units at the end of their names: `speed_mps`, in payloads, tables and code alike."""

UNITS = {  # by that ending; what has none of these is a number without unit
    "s": "s",
    "m": "m",
    "mm": "mm",
    "km": "km",
    "mps": "m/s",
    "mps2": "m/s²",
    "radps": "rad/s",
    "n": "N",
    "nm": "N m",
    "j": "J",
    "kg": "kg",
    "deg": "°",
    "c": "°C",
    "hz": "Hz",
    "bytes": "byte",
}


def unit_of(name: str) -> str:
    """The unit of a value; empty for what has none."""
    return UNITS.get(name.rpartition("_")[2], "")
