"""`brake-monitor wear`: what is left of the pads, and what people measure of them."""

import time
from argparse import ArgumentParser, Namespace, _SubParsersAction
from collections.abc import Callable
from datetime import UTC, datetime
from math import hypot

from brake_monitor.commands import options as shared
from brake_monitor.errors import InputError
from brake_monitor.monitoring.brake_units.brakes import Brakes, BrakeUnit
from brake_monitor.monitoring.brake_units.gauge import Gauge, after_gauge
from brake_monitor.monitoring.brake_units.wear import PadWear, Thickness, energy_loss_mm, pad_life
from brake_monitor.plural import plural
from brake_monitor.settings.config import Settings
from brake_monitor.settings.config_file import load_settings
from brake_monitor.settings.wear_settings import WearSettings
from brake_monitor.storage.memory_directory import FILE_NAME, state_directory
from brake_monitor.storage.store import Store

DESCRIPTION = """\
Shows what the daemon keeps of the brake pads, and tells it what was measured in the workshop. The daemon
may run meanwhile: it takes an entry up within a second; one that does not run takes it up when it starts."""

EPILOG = """\
examples:
  brake-monitor wear show  -c wagon.toml
  brake-monitor wear set   -c wagon.toml --wheelset 2 --thickness-mm 31.4   measured; learns the wear rate too
  brake-monitor wear reset -c wagon.toml --wheelset 2                       new pads
  brake-monitor wear show  -c /etc/brake-monitor/config.toml --state /var/lib/brake-monitor"""

LARGEST_THICKNESS_MM = 100.0
MILLIMETRES = shared.number("a positive number of millimetres", shared.SMALLEST)


def add_options(parser: ArgumentParser) -> None:
    """Its options."""
    actions = parser.add_subparsers(title="actions", required=True, metavar="ACTION")
    _add_action(actions, "show", "use and thickness of every wheelset's pads", _show)
    measured = _add_action(actions, "set", "the pads of a wheelset were measured", _set)
    measured.add_argument("--wheelset", type=shared.count, required=True, metavar="I", help="counted from 1")
    measured.add_argument(
        "--thickness-mm", type=MILLIMETRES, required=True, metavar="MM", help="of the wheelset's pads, on average"
    )
    measured.add_argument(
        "--std-mm", type=MILLIMETRES, metavar="MM", help="one sigma of the reading (default: [wear] gauge_std_mm)"
    )
    renewed = _add_action(actions, "reset", "new pads were fitted", _reset)
    which = renewed.add_mutually_exclusive_group(required=True)
    which.add_argument("--wheelset", type=shared.count, metavar="I", help="counted from 1")
    which.add_argument("--all", action="store_true", help="every wheelset")


def run(options: Namespace) -> int:
    """Do what was asked for."""
    code: int = options.act(options)
    return code


def _add_action(
    actions: "_SubParsersAction[ArgumentParser]", name: str, summary: str, act: Callable[[Namespace], int]
) -> ArgumentParser:
    parser = actions.add_parser(name, help=summary, description=summary)
    shared.add_config(parser)
    parser.add_argument(
        "--state", type=shared.path, metavar="DIR", help="the daemon's state directory (default: as it is configured)"
    )
    parser.set_defaults(act=act)
    return parser


def _show(options: Namespace) -> int:
    settings = load_settings(options.config)
    with _open(options, settings, "ro") as store:
        brakes, waiting = _brakes(store, settings), store.gauges()
    print(_text(settings, brakes))
    for _, gauge in waiting:
        print(f"entered, not yet taken up by the daemon: wheelset {gauge.wheelset}, {gauge.told()}")
    return 0


def _set(options: Namespace) -> int:
    if options.thickness_mm > LARGEST_THICKNESS_MM:
        raise InputError(f"--thickness-mm: no pad is thicker than {LARGEST_THICKNESS_MM:g} mm")
    if options.std_mm is not None and options.std_mm > LARGEST_THICKNESS_MM:
        raise InputError(f"--std-mm: no reading is that uncertain, expected at most {LARGEST_THICKNESS_MM:g} mm")
    return _enter(options, options.thickness_mm, options.std_mm)


def _reset(options: Namespace) -> int:
    return _enter(options, None, None)


def _enter(options: Namespace, thickness_mm: float | None, std_mm: float | None) -> int:
    settings = load_settings(options.config)
    every = range(1, settings.vehicle.wheelset_count + 1)
    wheelsets = [options.wheelset] if options.wheelset else every
    if wheelsets[0] not in every:
        raise InputError(f"--wheelset {wheelsets[0]}: {settings.vehicle.id} has {plural(len(every), 'wheelset')}")
    with _open(options, settings, "rw") as store:
        brakes = _brakes(store, settings)
        for wheelset in wheelsets:
            gauge = Gauge(time.time(), wheelset, thickness_mm, std_mm)
            _check(gauge, brakes.units[wheelset - 1].pads, settings)
            store.enter(gauge)
            print(f"wheelset {wheelset}: {gauge.told()}; noted")
    return 0


def _check(gauge: Gauge, pads: PadWear, settings: Settings) -> None:
    """Refuse a thickness that can only be that of other pads, or mistyped: the wear rate would be learned from it."""
    if gauge.thickness_mm is None:
        return
    gauge_std_mm, new = gauge.std_mm or settings.wear.gauge_std_mm, PadWear.new(settings.wear)
    if gauge.thickness_mm < _least_mm(pads, gauge_std_mm, settings.wear):
        raise InputError(
            f"--thickness-mm {gauge.thickness_mm:g}: these pads had {pads.gauge_thickness_mm:g} mm, and what they have "
            f"braked since takes no more than {_most_worn_mm(pads, settings.wear):.1f} mm away; if it is right all the "
            f"same, say `wear reset --wheelset {gauge.wheelset}` first: no wear rate is learned from it then"
        )
    if gauge.thickness_mm <= _greatest_mm(pads, gauge_std_mm):
        return
    reason = (
        f"these pads had {pads.gauge_thickness_mm:g} mm; if new ones were fitted, say so with "
        f"`wear reset --wheelset {gauge.wheelset}` first"
    )
    if gauge.thickness_mm > _greatest_mm(new, gauge_std_mm):
        reason = (
            f"new pads have {new.gauge_thickness_mm:g} mm as it is configured; if yours have more, say so in "
            "[wear] new_pad_thickness_mm first"
        )
    raise InputError(f"--thickness-mm {gauge.thickness_mm:g}: {reason}")


def _greatest_mm(pads: PadWear, gauge_std_mm: float) -> float:
    """What these pads may measure at most."""
    return pads.gauge_thickness_mm + 3.0 * hypot(pads.gauge_std_mm, gauge_std_mm)


def _least_mm(pads: PadWear, gauge_std_mm: float, wear: WearSettings) -> float:
    """What they may measure at least; those that nobody has measured yet may be worn as far as it goes."""
    if pads.gauged_time_s is None:
        return 0.0
    std_mm = hypot(pads.gauge_std_mm, gauge_std_mm)
    return pads.gauge_thickness_mm - _most_worn_mm(pads, wear) - 3.0 * std_mm


def _most_worn_mm(pads: PadWear, wear: WearSettings) -> float:
    """Since the last reading, at the greatest wear rate that is believed."""
    return energy_loss_mm(pads.since_gauge.energy_j, wear.greatest_specific_wear_cm3_per_mj, wear)


def _brakes(store: Store, settings: Settings) -> Brakes:
    """The brake units with all that was entered; before any traffic those of a daemon that begins."""
    count = settings.vehicle.wheelset_count
    brakes = (store.brakes() or Brakes.new(count, settings.wear)).as_configured(settings.wear)
    held = len(brakes.units)
    if held != count:
        raise InputError(
            f"{settings.path}: the vehicle has {plural(count, 'wheelset')}, the daemon's memory holds {held}"
        )
    for _, gauge in store.gauges():
        brakes = after_gauge(brakes, gauge, settings.wear)
    return brakes


def _open(options: Namespace, settings: Settings, mode: str) -> Store:
    directory = options.state or state_directory(settings)
    if directory is None:
        raise InputError(
            f"{options.config}: [store] names no directory: say where the daemon keeps its state with --state DIR"
        )
    if directory.is_file():
        raise InputError(f"{directory}: expected the daemon's state directory, this is a file")
    return Store.look(directory / FILE_NAME, settings.vehicle.id, mode)


def _text(settings: Settings, brakes: Brakes) -> str:
    before_any = "before any traffic: taken for new unless measured"
    as_of = before_any if brakes.time_s is None else f"as of {_date(brakes.time_s)}"
    lines = [
        f"{settings.vehicle.id}, {as_of}; pads are due at {settings.wear.pad_limit_mm:g} mm",
        "",
        "wheelset  thickness mm (95 %)   by Archard  left mm  left stops  left km",
    ]
    lines += [_life_line(i, unit, settings) for i, unit in enumerate(brakes.units, 1)]
    lines += ["", "wheelset  energy MJ  stops  slid m       km  wear cm³/MJ   measured"]
    lines += [_use_line(i, unit) for i, unit in enumerate(brakes.units, 1)]
    return "\n".join(lines)


def _life_line(i: int, unit: BrakeUnit, settings: Settings) -> str:
    life = pad_life(unit.pads, settings.wear)
    return (
        f"{i:>8}  {_interval(life.by_energy):<21} {life.by_archard.value_mm:>10.1f} {life.remaining_mm:>8.1f} "
        f"{_large(life.remaining_stops):>11} {_large(life.remaining_km):>8}"
    )


def _use_line(i: int, unit: BrakeUnit) -> str:
    pads, use = unit.pads, unit.pads.since_fitted
    rate = pads.specific_wear_cm3_per_mj
    measured = "never" if pads.gauged_time_s is None else _date(pads.gauged_time_s)[:10]
    return (
        f"{i:>8} {use.energy_j / 1e6:>10.1f} {use.stops:>6.0f} {use.sliding_distance_m:>7.0f} "
        f"{use.distance_m / 1e3:>8.1f}  {rate.value:.3f} ± {rate.std:.3f}  {measured}"
    )


def _interval(thickness: Thickness) -> str:
    return f"{thickness.value_mm:.1f} ({thickness.low_mm:.1f} to {thickness.high_mm:.1f})"


def _large(number: float | None) -> str:
    return "?" if number is None else f"{number:,.0f}" if number < 1e7 else "> 10 M"


def _date(time_s: float) -> str:
    return datetime.fromtimestamp(time_s, UTC).strftime("%Y-%m-%d %H:%M UTC")
