"""`brake-monitor observability`: what the sensors can tell about friction and adhesion, and what they cannot."""

from argparse import ArgumentParser, ArgumentTypeError, Namespace, RawDescriptionHelpFormatter, _SubParsersAction
from dataclasses import dataclass, replace
from itertools import product
from math import ceil, isfinite
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from brake_monitor.commands import options as shared
from brake_monitor.commands.places import check_places
from brake_monitor.decoding.dbc import cycle_time_s, load_bus
from brake_monitor.decoding.signals import Quantity, SignalDecoder
from brake_monitor.errors import InputError
from brake_monitor.estimation.observability import (
    Observability,
    OperatingPoint,
    Prior,
    Sensors,
    Variant,
    analyse,
    variants,
    worst,
)
from brake_monitor.estimation.wagon import GRAVITY_MPS2, Wagon
from brake_monitor.settings.config import Settings
from brake_monitor.settings.config_file import load_settings
from brake_monitor.whole_file import whole_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes

DESCRIPTION = """\
Shows what the vehicle's sensors can tell about pad friction mu_b, adhesion mu_w and the unmodelled
deceleration d: rank and smallest singular value of the map from the states to [y, dy/dt],
y = wheel speeds and vehicle speed, over pressing force, speed and adhesion."""

EXAMPLES = """\
examples:
  brake-monitor observability -c wagon.toml                the tables
  brake-monitor observability -c wagon.toml -o map.svg     and a figure (.svg or .png; extra 'report')
  brake-monitor observability -c wagon.toml --window 2     a look of two seconds instead of half a one"""

READING = """\
Each cell: rank/states, then the smallest singular value s. A rank below the number of states means
directions that leave no trace in the sensors. A change of one prior sigma in the direction seen
worst shows as s sigmas of the sensors within the window; at 0 it is never seen, at 1 the window
says as much as was known before. Prior sigmas: {prior}."""

WINDOW_S = 0.5  # about as long as WSP leaves a pressure alone
CYCLE_S = 0.05  # of a message whose DBC does not say
FULL_ADHESION = 0.10  # what a full application asks of the rail
FORCE_STEP_N = 10_000.0
SPEEDS_KMH = (5.0, 80.0, 160.0)
ADHESIONS = (0.02, 0.10, 0.30)
MIDDLE = (80.0, 0.10)  # km/h and adhesion of the curves that compare unknowns
CURVE_STEPS = 50
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000", "#8c564b", "#7f7f00")
FORMATS = (".svg", ".png")


def add_parser(subparsers: "_SubParsersAction[ArgumentParser]") -> None:
    """Describe the command."""
    parser = subparsers.add_parser(
        "observability",
        help="what the sensors can tell about friction and adhesion",
        description=DESCRIPTION,
        epilog=EXAMPLES,
        formatter_class=RawDescriptionHelpFormatter,
    )
    shared.add_config(parser)
    parser.add_argument("-o", "--output", type=_figure_path, metavar="FIGURE", help="draw a figure, .svg or .png")
    parser.add_argument(
        "--window",
        type=_window_s,
        default=WINDOW_S,
        metavar="SECONDS",
        help=f"how long the sensors are looked at (default {WINDOW_S:g})",
    )
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Print the tables; draw the figure where one is asked for."""
    settings = load_settings(options.config)
    check_places({"-o": options.output}, options.config, settings)
    survey = Survey.of(settings, options.window)
    if options.output is not None:
        _draw(survey, options.output)
    print(_text(survey))
    return 0


def _figure_path(text: str) -> Path:
    path = Path(text)
    if path.suffix.lower() not in FORMATS:
        raise ArgumentTypeError(f"expected a file name that ends in {' or '.join(FORMATS)}, got {text!r}")
    return path


def _window_s(text: str) -> float:
    try:
        window_s = float(text)
    except ValueError:
        window_s = -1.0
    if not isfinite(window_s) or window_s <= 0.0:
        raise ArgumentTypeError(f"expected a positive number of seconds, got {text!r}")
    return window_s


@dataclass(frozen=True)
class Survey:
    """The vehicle, its sensors and the grid of operating points."""

    vehicle_id: str
    wagon: Wagon
    variants: tuple[Variant, ...]
    sensors: Sensors
    prior: Prior
    window_s: float
    contact_force_n: float
    full_force_n: float

    @classmethod
    def of(cls, settings: Settings, window_s: float) -> "Survey":
        """Take what the configuration and its DBC files say; InputError when the window is shorter than a cycle."""
        sensors = _sensors(settings)
        if window_s < sensors.period_s.max():
            raise InputError(
                f"--window {window_s:g}: expected at least {sensors.period_s.max():g}, the time between two samples "
                "of the slowest speed signal"
            )
        wagon = Wagon.from_vehicle(settings.vehicle)
        return cls(
            vehicle_id=settings.vehicle.id,
            wagon=wagon,
            variants=variants(settings.vehicle.wheelset_count),
            sensors=sensors,
            prior=Prior(friction_std=settings.estimator.friction_nominal_std),
            window_s=window_s,
            contact_force_n=settings.estimator.contact_force_n,
            full_force_n=_full_force_n(wagon, settings.estimator.friction_nominal),
        )

    def at(self, variant: Variant, force_n: float, speed_kmh: float, adhesion: float) -> Observability:
        """What one variant tells at one operating point."""
        point = OperatingPoint(force_n, speed_kmh / 3.6, adhesion)
        return analyse(self.wagon, variant, point, self.sensors.map_std(self.window_s), self.prior)

    def over_grid(self, variant: Variant, force_n: float) -> Observability:
        """The worst over all speeds and adhesions."""
        return worst(self.at(variant, force_n, *place) for place in product(SPEEDS_KMH, ADHESIONS))

    @property
    def table_forces_n(self) -> list[float]:
        """No force, where friction stops being held, a light and a full application."""
        return sorted({0.0, self.contact_force_n, self.full_force_n / 4.0, self.full_force_n})


def _sensors(settings: Settings) -> Sensors:
    """Noise and cycle time of the wheel speeds and the vehicle speed."""
    databases = {bus.name: load_bus(bus.name, bus.dbc) for bus in settings.can}
    decoder = SignalDecoder(settings, databases)
    channels = [
        next(c for c in decoder.channels if (c.quantity, c.wheelset) == place)
        for place in (
            *((Quantity.AXLE_SPEED, i) for i in range(settings.vehicle.wheelset_count)),
            (Quantity.SPEED, 0),
        )
    ]
    periods_s = [cycle_time_s(databases[c.bus].message(c.message)) or CYCLE_S for c in channels]
    return Sensors(np.array([c.noise_std for c in channels]), np.array(periods_s))


def _full_force_n(wagon: Wagon, friction: float) -> float:
    """The pressing force that asks FULL_ADHESION of the most loaded wheelset, rounded up."""
    creep_torque = FULL_ADHESION * wagon.mass_kg * GRAVITY_MPS2 * wagon.static_load_share * wagon.wheel_radius_m
    force_n = float((creep_torque / (friction * wagon.brake_radius_m)).max())
    return ceil(force_n / FORCE_STEP_N) * FORCE_STEP_N


# -- tables ---------------------------------------------------------------------------------------------------------

Table = dict[Variant, list[Observability]]  # the worst over the grid, at each force of the table


def _text(survey: Survey) -> str:
    noise, period_ms, prior = survey.sensors.noise_std, survey.sensors.period_s * 1e3, survey.prior
    table = {variant: [survey.over_grid(variant, f) for f in survey.table_forces_n] for variant in survey.variants}
    lines = [
        f"{survey.vehicle_id}: what a window of {survey.window_s:g} s tells about friction and adhesion",
        f"sensors (1 sigma): wheel speed {noise[0]:.3g} rad/s every {period_ms[0]:g} ms, "
        f"vehicle speed {noise[-1]:.3g} m/s every {period_ms[-1]:g} ms",
        "",
        READING.format(
            prior=f"mu_b {prior.friction_std:g}, mu_w {prior.adhesion_std:g}, d {prior.deceleration_std:g} m/s²"
        ),
        "",
        *_variant_lines(survey, table),
        "",
        *_remarks(survey, table),
        "",
        *_grid_lines(survey),
    ]
    return "\n".join(lines)


def _header(title: str, survey: Survey) -> str:
    return f"{title:<52}" + "".join(f"{f'{force / 1e3:g} kN':>12}" for force in survey.table_forces_n)


def _row(title: str, seen: list[Observability]) -> str:
    cells = (f"{f'{one.rank}/{one.states}':>6}{_number(one.smallest_singular_value):>6}" for one in seen)
    return f"{title:<52}" + "".join(cells)


def _number(value: float) -> str:
    """About three digits in five characters; an exact zero shows as such."""
    if value == 0.0:
        return "0"
    if value < 0.001:
        return "<.001"
    decimals = next((d for d, below in ((3, 1.0), (2, 10.0), (1, 100.0)) if value < below), 0)
    return f"{value:.{decimals}f}"


def _variant_lines(survey: Survey, table: Table) -> list[str]:
    full_kn = survey.full_force_n / 1e3
    lines = [_header("unknown; instants looked at (worst over the grid)", survey)]
    for variant, seen in table.items():
        full = seen[-1]
        how = "no trace" if full.rank < full.states else "seen worst"
        lines += [_row(variant.name, seen), f"    {how} at {full_kn:g} kN: {full.weakest}"]
    return lines


def _remarks(survey: Survey, table: Table) -> list[str]:
    """What the table means for the vehicle, in its own numbers."""
    paper = survey.variants[0]
    held = survey.over_grid(paper, survey.contact_force_n)
    lines = [
        f"at 0 kN, whatever else is known, no trace is left of {table[paper][0].weakest}",
        f"below {survey.contact_force_n / 1e3:g} kN friction is held: there the paper's map has "
        f"s = {_number(held.smallest_singular_value)}",
    ]
    if len(paper.patterns[0]) > 1:
        lines += [
            "one mu_w: all wheelsets use the same adhesion, which ends as soon as one of them slides",
            "mu_w per wheelset: no pressure common to all tells their frictions apart, released ones do (WSP)",
        ]
    for variant, seen in table.items():
        known = replace(variant, has_deceleration=False)
        without = next((table[v][-1] for v in table if _unknowns(v) == _unknowns(known)), None)
        if variant.has_deceleration and without is not None and without.rank == without.states:
            instants = variant.name.partition("; ")[2] or "one instant"
            fall = [_number(one.smallest_singular_value) for one in (without, seen[-1])]
            lines.append(
                f"price of d at {survey.full_force_n / 1e3:g} kN, {instants}: s falls from {' to '.join(fall)}"
            )
    return lines


def _unknowns(variant: Variant) -> tuple[object, ...]:
    return variant.one_adhesion, variant.has_deceleration, variant.patterns


def _grid_lines(survey: Survey) -> list[str]:
    """The paper's own map at each speed and adhesion."""
    paper = survey.variants[0]
    lines = [_header(paper.name, survey)]
    for speed_kmh, adhesion in product(SPEEDS_KMH, ADHESIONS):
        seen = [survey.at(paper, force, speed_kmh, adhesion) for force in survey.table_forces_n]
        lines.append(_row(f"    at {speed_kmh:g} km/h, adhesion {adhesion:.2f}", seen))
    return [*lines, "speed acts only through the drag, adhesion only through the wheel loads: both hardly matter here"]


# -- figure ---------------------------------------------------------------------------------------------------------


def _draw(survey: Survey, path: Path) -> None:
    """Two panels over pressing force: what each set of unknowns costs, and what speed and adhesion change."""
    try:
        from matplotlib import rc_context  # noqa: PLC0415 - an extra, and slow to import
        from matplotlib.figure import Figure  # noqa: PLC0415
    except ImportError:
        raise InputError(f"{path}: a figure needs an extra: pip install 'brake-monitor[report]'") from None
    kind = path.suffix.lower().removeprefix(".")
    with rc_context({"svg.hashsalt": survey.vehicle_id, "font.size": 9.0}):  # the same input gives the same file
        figure = Figure(figsize=(13.0, 6.6), layout="constrained")
        left, right = figure.subplots(1, 2)
        _draw_variants(left, survey)
        _draw_grid(right, survey)
        figure.suptitle(
            f"{survey.vehicle_id}: what a window of {survey.window_s:g} s tells about friction and adhesion"
        )
        with whole_file(path) as part:
            figure.savefig(part, format=kind, dpi=150, metadata={"Date": None} if kind == "svg" else {})


def _forces_n(survey: Survey) -> list[float]:
    return [survey.full_force_n * i / CURVE_STEPS for i in range(CURVE_STEPS + 1)]


def _draw_variants(axes: "Axes", survey: Survey) -> None:
    forces_n = _forces_n(survey)
    never = []
    for variant, colour in zip(survey.variants, COLOURS, strict=False):
        curve = [survey.at(variant, force, *MIDDLE).smallest_singular_value for force in forces_n]
        if max(curve) == 0.0:
            never.append(variant.name)
            continue
        style = "--" if variant.has_deceleration else "-"
        width = 5.0 if len(variant.patterns) == 1 else 1.5  # without d coasting adds nothing: one curve on the other
        axes.plot(np.array(forces_n) / 1e3, curve, style, lw=width, color=colour, label=variant.name)
    for name in never:
        axes.plot([0.0, forces_n[-1] / 1e3], [0.0, 0.0], color="0.6", lw=4.0, clip_on=False, label=f"{name}: never")
    _label(axes, survey, f"unknowns; instants looked at ({MIDDLE[0]:g} km/h, adhesion {MIDDLE[1]:.2f})")


def _draw_grid(axes: "Axes", survey: Survey) -> None:
    forces_n, paper = _forces_n(survey), survey.variants[0]
    for speed_kmh, width in zip(SPEEDS_KMH, (6.0, 3.5, 1.0), strict=True):  # one curve on the other, all to be seen
        for adhesion, colour in zip(ADHESIONS, COLOURS, strict=False):
            curve = [survey.at(paper, force, speed_kmh, adhesion).smallest_singular_value for force in forces_n]
            label = f"{speed_kmh:g} km/h, adhesion {adhesion:.2f}"
            axes.plot(np.array(forces_n) / 1e3, curve, lw=width, alpha=1.0 / width, color=colour, label=label)
    _label(axes, survey, paper.name)


def _label(axes: "Axes", survey: Survey, title: str) -> None:
    axes.axhline(1.0, color="0.4", lw=0.8)
    axes.annotate("as much as was known before", (survey.full_force_n * 1e-5, 1.0), ha="left", va="bottom", color="0.4")
    axes.plot(0.0, 0.0, "o", color="k", clip_on=False, label="0 kN: friction leaves no trace")
    axes.set(title=title, xlabel="pressing force per wheelset [kN]", ylabel="smallest singular value s [sigmas]")
    axes.set_xlim(0.0, survey.full_force_n / 1e3)
    axes.set_ylim(bottom=0.0)
    axes.grid(alpha=0.3)
    axes.legend(fontsize=7.0, loc="upper center", bbox_to_anchor=(0.5, -0.1), ncols=2)
