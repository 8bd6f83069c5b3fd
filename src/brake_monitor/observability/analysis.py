"""What one look at the sensors can tell: the observability map (16) of the wagon, its rank and its weakest direction.

A look at one instant gives z = [y, ẏ] with y = [omega_1..N, v]: 2 (N+1) numbers. The paper has as many states,
one mu_w for the whole wagon and no d, and inverts the map wherever every F_perp,i > 0 (17), as a test does. Our
model has one mu_w,i per wheelset and d, 3N+2 states, and N directions of them leave z unchanged. What is
constant (mu_b,i; d) and what is not (mu_w,i) decides what further instants restore. Eliminating mu_w,i between
(6) and (1) leaves one equation per instant,

    Σ_i mu_b,i F_perp,i r_B,i / r_W,i + m d = known,

so the N frictions and d follow from N+1 instants whose patterns [F_perp,1..N, 1] are linearly independent. Coasting
is one such pattern and gives d. A pressure common to all wheelsets adds only one more, the sum of the frictions:
what tells one brake unit from another is a release of single wheelsets, as WSP does, or that they share one mu_w.

**Scaling.** Rank says whether, not how well. `scaled_map` divides each row by the standard deviation with which a
window of samples gives it (a straight line fitted to them), and multiplies each column by how far that state is
unknown beforehand. Its smallest singular value s is then the number of sigmas by which a change of one prior sigma in
the weakest direction is seen: 0 not at all; at 1 the window says as much as was known before; together they leave
1 / sqrt(1 + s²) of the prior sigma. A window n times longer multiplies what ẏ contributes by n^1.5.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from brake_monitor.arrays import Floats
from brake_monitor.estimation.model.wagon import Wagon
from brake_monitor.observability.directions import Unknown, in_words


@dataclass(frozen=True)
class Variant:
    """A set of unknowns and the instants they are looked at.

    mu_b,i and d are common to all instants; speeds and adhesions are unknown at each anew.
    """

    name: str
    one_adhesion: bool  # the paper's single mu_w, else one per wheelset
    has_deceleration: bool  # d unknown, else known to be 0
    patterns: tuple[tuple[float, ...], ...]  # per instant and wheelset: which part of the pressing force acts


class OperatingPoint(NamedTuple):
    """Where the map is linearised; a wheelset whose brake is released (pattern 0) uses no adhesion."""

    pressing_force_n: float  # of each braked wheelset
    speed_mps: float
    adhesion: float  # mu_w of each braked wheelset


@dataclass(frozen=True)
class Sensors:
    """The samples of y = [omega_1..N, v]; arrays of shape (N+1,)."""

    noise_std: Floats  # of one sample, rad/s and m/s
    period_s: Floats

    def map_std(self, window_s: float) -> Floats:
        """Standard deviations of [y, ẏ] at the middle of a window, shape (2N+2,), from a straight-line fit.

        Raises ValueError when a window has less than the two samples that a slope needs.
        """
        if window_s < self.period_s.max():
            raise ValueError(f"a window of {window_s:g} s is shorter than the slowest period")
        n = window_s / self.period_s + 1.0
        mean = self.noise_std / np.sqrt(n)
        slope = self.noise_std / self.period_s * np.sqrt(12.0 / (n * (n * n - 1.0)))
        return np.concatenate([mean, slope])


@dataclass(frozen=True)
class Prior:
    """How far each kind of state is unknown before the sensors are looked at (1 sigma)."""

    friction_std: float = 0.05
    adhesion_std: float = 0.05
    deceleration_std: float = 0.1  # m/s², about a 10 per mille gradient
    speed_std: float = 1.0  # m/s, at the wheel's circumference too; without weight, because speeds are measured


class Observability(NamedTuple):
    """What a variant's map tells at one operating point."""

    states: int
    rank: int
    smallest_singular_value: float  # of the scaled map; exactly 0 when the rank is less than the states
    weakest: str  # the direction seen worst, in words


def variants(wheelset_count: int) -> tuple[Variant, ...]:
    """What to compare: the paper's states and ours, at one instant and at the instants that restore what is lost."""
    n = wheelset_count
    braking, coasting = (1.0,) * n, (0.0,) * n
    once = (braking,)
    both = (coasting, braking)
    one = [
        Variant("one mu_w, no d (the paper's)", True, False, once),
        Variant("one mu_w, with d", True, True, once),
        Variant("one mu_w, no d; coasting, then braking", True, False, both),
        Variant("one mu_w, with d; coasting, then braking", True, True, both),
    ]
    if n == 1:  # its own adhesion is the wagon's
        return tuple(one)
    in_turn = (braking, *(tuple(float(i != released) for i in range(n)) for released in range(n)))
    return (
        *one,
        Variant("mu_w per wheelset, no d", False, False, once),
        Variant("mu_w per wheelset, with d", False, True, once),
        Variant("mu_w per wheelset, with d; coasting, then braking", False, True, both),
        Variant("mu_w per wheelset, no d; each released in turn", False, False, in_turn),
        Variant("mu_w per wheelset, with d; each released in turn", False, True, in_turn),
    )


def unknowns(variant: Variant) -> tuple[Unknown, ...]:
    """Columns of the variant's map: speeds and adhesions instant by instant, then what all instants share."""
    n = len(variant.patterns[0])
    columns = []
    for k in range(len(variant.patterns)):
        columns += [*(Unknown("omega", i, k) for i in range(n)), Unknown("v", 0, k)]
        columns += [Unknown("mu_w", i, k) for i in range(1 if variant.one_adhesion else n)]
    columns += [Unknown("mu_b", i, 0) for i in range(n)]
    return (*columns, Unknown("d", 0, 0)) if variant.has_deceleration else tuple(columns)


def stacked_map(wagon: Wagon, variant: Variant, point: OperatingPoint) -> Floats:
    """∂[y, ẏ]/∂x at every instant of the variant, one below the other: shape (K (2N+2), states), SI units."""
    columns = unknowns(variant)
    return np.vstack(
        [
            _map_at(wagon, np.array(pattern), point) @ _placed(wagon, variant, columns, instant)
            for instant, pattern in enumerate(variant.patterns)
        ]
    )


def scaled_map(wagon: Wagon, variant: Variant, point: OperatingPoint, map_std: Floats, prior: Prior) -> Floats:
    """`stacked_map` in sigmas of the sensors per sigma of the prior (see the module), dimensionless, same shape.

    `map_std` says how well [y, ẏ] is known at each instant, shape (2N+2,); see `Sensors.map_std`.
    """
    row_std = np.tile(map_std, len(variant.patterns))
    std = {"v": prior.speed_std, "mu_b": prior.friction_std, "mu_w": prior.adhesion_std, "d": prior.deceleration_std}
    column_std = [
        prior.speed_std / wagon.wheelsets[column.wheelset].wheel_radius_m
        if column.kind == "omega"
        else std[column.kind]
        for column in unknowns(variant)
    ]
    scaled: Floats = stacked_map(wagon, variant, point) * np.array(column_std) / row_std[:, None]
    return scaled


def analyse(wagon: Wagon, variant: Variant, point: OperatingPoint, map_std: Floats, prior: Prior) -> Observability:
    """Rank, smallest singular value and weakest direction of the variant's scaled map at one operating point."""
    scaled = scaled_map(wagon, variant, point, map_std, prior)
    states = scaled.shape[1]
    _, values, directions = np.linalg.svd(scaled)
    rank = int((values > values[0] * max(scaled.shape) * np.finfo(float).eps).sum())
    smallest = float(values[-1]) if rank == states else 0.0
    weakest = directions[min(rank, states - 1) :]  # all that is not seen, else the one seen worst
    return Observability(states, rank, smallest, in_words(weakest, unknowns(variant)))


def worst(observed: Iterable[Observability]) -> Observability:
    """The one with the lowest rank, and among these with the smallest singular value."""
    return min(observed, key=lambda one: (one.rank, one.smallest_singular_value))


def _map_at(wagon: Wagon, pattern: Floats, point: OperatingPoint) -> Floats:
    """∂[y, ẏ]/∂x at one instant, shape (2N+2, 3N+2)."""
    s = wagon.layout
    x = np.zeros(s.size)
    x[s.omega] = [point.speed_mps / own.wheel_radius_m for own in wagon.wheelsets]
    x[s.speed] = point.speed_mps
    x[s.adhesion] = point.adhesion * pattern
    u = wagon.inputs()
    forces_n = (point.pressing_force_n * pattern).tolist()
    u = u._replace(wheels=[own._replace(pressing_force_n=n) for own, n in zip(u.wheels, forces_n, strict=True)])
    measured = s.speed + 1
    state = x.tolist()
    _, jacobian = wagon.linearise(state, wagon.settled(state, u))
    return np.vstack([np.eye(s.size)[:measured], jacobian[:measured]])


def _placed(wagon: Wagon, variant: Variant, columns: tuple[Unknown, ...], instant: int) -> Floats:
    """∂x/∂unknowns at one instant, a row for each state: where each unknown enters the model's state."""
    s = wagon.layout
    first = {"omega": s.omega.start, "v": s.speed, "mu_b": s.friction.start, "d": s.deceleration}
    placed = np.zeros((s.size, len(columns)))
    for j, column in enumerate(columns):
        if column.kind in ("omega", "v", "mu_w") and column.instant != instant:
            continue
        if column.kind == "mu_w":
            placed[s.adhesion if variant.one_adhesion else s.adhesion.start + column.wheelset, j] = 1.0
        else:
            placed[first[column.kind] + column.wheelset, j] = 1.0
    return placed
