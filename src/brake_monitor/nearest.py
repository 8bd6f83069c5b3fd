"""The hint at the end of a refusal: which name was probably meant."""

from collections.abc import Sequence
from difflib import get_close_matches
from pathlib import Path

_LISTED = 8


def nearest(name: str, names: Sequence[str]) -> str:
    """Return "did you mean ..." for the name most like `name`, else what there is to choose from."""
    close = [n for n in names if n.lower() == name.lower()] or get_close_matches(name, names, n=1, cutoff=0.6)
    if close:
        return f'did you mean "{close[0]}"?'
    listed = ", ".join(f'"{n}"' for n in names[:_LISTED])
    more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    return f"there is {listed}{more}" if names else "there is none"


def nearest_file(path: Path) -> str:
    """Return ", did you mean ..." for the file most like one that is not there, in its folder; nothing if it exists.

    First by what stands before the suffixes: suffixes are alike in files that have nothing to do with each other.
    """
    names = sorted(other.name for other in path.parent.glob("*"))
    if path.name in names:
        return ""
    stems = get_close_matches(_stem(path.name), map(_stem, names), n=1)
    alike = [name for name in names if _stem(name) in stems]
    return f", {nearest(path.name, alike)}" if alike else ""


def _stem(name: str) -> str:
    return name.partition(".")[0].lower()
