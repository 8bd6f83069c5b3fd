"""Numbers for people to read."""

IN_FULL = 1e9  # below this nobody wants a power of ten


def significant(value: float, digits: int) -> str:
    """`value` with so many significant digits, large ones in full: `66100`, where `:.3g` writes `6.61e+04`."""
    text = f"{value:z.{digits}g}"
    return f"{float(text):.0f}" if "e+" in text and abs(value) < IN_FULL else text
