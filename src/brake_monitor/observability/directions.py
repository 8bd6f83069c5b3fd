"""Directions of the unknowns in words: what grows together, against what."""

from typing import NamedTuple

import numpy as np

from brake_monitor.arrays import Floats

KINDS = ("mu_b", "mu_w", "d", "v", "omega")  # in the order a direction names them
NAMED_FROM = 0.1  # components below this fraction of the greatest are left out of a direction's name


class Unknown(NamedTuple):
    """One column of a stacked map."""

    kind: str  # omega, v, mu_b, mu_w or d
    wheelset: int  # from 0; 0 too for what the whole wagon shares
    instant: int  # from 0; 0 too for what all instants share


def in_words(directions: Floats, columns: tuple[Unknown, ...]) -> str:
    """Name a space of directions, its orthonormal basis in the rows: shape (dimension, states).

    Several directions without a trace have no basis of their own. They are named by the states that lie in them
    altogether, else by the direction that comes nearest to a single state.
    """
    dimension = len(directions)
    projector = directions.T @ directions
    share = projector.diagonal()
    alone = [j for j in range(len(columns)) if share[j] > 1.0 - 1e-9]
    if dimension > 1 and len(alone) == dimension:
        return _names([columns[j] for j in alone], columns) + ", each by itself"
    nearest = int(np.argmax(np.round(share, 9)))
    name = _contrast(projector[nearest] / np.sqrt(share[nearest]), columns)
    return name if dimension == 1 else f"{name}, and {dimension - 1} more"


def _contrast(direction: Floats, columns: tuple[Unknown, ...]) -> str:
    """`A with B against C`: what grows together, against what shrinks meanwhile."""
    greatest: dict[tuple[str, int], float] = {}
    for column, part in zip(columns, direction, strict=True):  # an adhesion is named once, however many instants
        place = column.kind, column.wheelset
        if abs(part) > abs(greatest.get(place, 0.0)):
            greatest[place] = float(part)
    least = NAMED_FROM * max(abs(part) for part in greatest.values())
    named = {place: part > 0.0 for place, part in greatest.items() if abs(part) >= least}
    sides = [
        [column for column in columns if named.get((column.kind, column.wheelset)) is grows] for grows in (True, False)
    ]
    shown = [side for side in sides if side]
    shown.sort(key=lambda side: min((KINDS.index(column.kind), column.wheelset) for column in side))
    return " against ".join(_names(side, columns) for side in shown)


def _names(chosen: list[Unknown], columns: tuple[Unknown, ...]) -> str:
    """`mu_b,1+3 with mu_w,1+3`, wheelsets counted from 1; `all mu_b` when none is missing."""
    parts = []
    for kind in KINDS:
        wheelsets = sorted({column.wheelset for column in chosen if column.kind == kind})
        total = len({column.wheelset for column in columns if column.kind == kind})
        if wheelsets and total == 1:
            parts.append(kind)
        elif wheelsets:
            numbers = "+".join(str(i + 1) for i in wheelsets)
            parts.append(f"all {kind}" if len(wheelsets) == total else f"{kind},{numbers}")
    return " with ".join(parts)
