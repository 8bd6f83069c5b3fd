"""`brake-monitor wear`: what is left of the pads, and what people measure of them."""

import time
from argparse import ArgumentParser, Namespace, _SubParsersAction
from collections.abc import Callable, Iterator, Sequence
from datetime import UTC, datetime
from pathlib import Path

from msgspec.structs import replace

from brake_monitor.commands import options as shared
from brake_monitor.commands.gauge_check import check_entered, check_expected, check_possible, interval_text
from brake_monitor.errors import InputError
from brake_monitor.monitoring.brake_units.brakes import Brakes, BrakeUnit
from brake_monitor.monitoring.brake_units.gauge import LARGEST_THICKNESS_MM, Gauge, after_gauge
from brake_monitor.monitoring.brake_units.wear import PadWear, pad_life
from brake_monitor.plural import plural
from brake_monitor.settings.config import Settings
from brake_monitor.settings.config_file import load_settings
from brake_monitor.storage.memory_directory import FILE_NAME, set_aside_in, state_directory
from brake_monitor.storage.store import Store

DESCRIPTION = """\
Shows what the daemon keeps of the brake pads, and tells it what was measured in the workshop. The daemon
may run meanwhile: it takes an entry up within a second; one that does not run takes it up when it starts."""

EPILOG = """\
examples:
  brake-monitor wear show  -c wagon.toml
  brake-monitor wear set   -c wagon.toml --wheelset 2 --thickness-mm 31.4   measured; learns the wear rate too
  brake-monitor wear reset -c wagon.toml --wheelset 2                       new pads
  brake-monitor wear undo  -c wagon.toml --wheelset 2                       the last of these entries was wrong
  brake-monitor wear show  -c /etc/brake-monitor/config.toml --state /var/lib/brake-monitor"""

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
    measured.add_argument("--sure", action="store_true", help="it is right although something else was expected")
    _add_which(_add_action(actions, "reset", "new pads were fitted", _reset))
    _add_which(_add_action(actions, "undo", "the last entry was wrong: as if it had not been made", _undo))


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


def _add_which(parser: ArgumentParser) -> None:
    which = parser.add_mutually_exclusive_group(required=True)
    which.add_argument("--wheelset", type=shared.count, metavar="I", help="counted from 1")
    which.add_argument("--all", action="store_true", help="every wheelset")


def _show(options: Namespace) -> int:
    settings = load_settings(options.config)
    with _open(options, settings, "ro") as store:
        brakes, waiting = _brakes(store, settings), store.gauges()
    print(_text(settings, brakes))
    for remark in _remarks(brakes, set_aside_in(_directory(options, settings))):
        print(remark)
    for _, gauge in waiting:
        print(f"entered, not yet taken up by the daemon: wheelset {gauge.wheelset}, {gauge.told()}")
    return 0


def _set(options: Namespace) -> int:
    if options.thickness_mm > LARGEST_THICKNESS_MM:
        raise InputError(f"--thickness-mm: no pad is thicker than {LARGEST_THICKNESS_MM:g} mm")
    if options.std_mm is not None and options.std_mm > LARGEST_THICKNESS_MM:
        raise InputError(f"--std-mm: no reading is that uncertain, expected at most {LARGEST_THICKNESS_MM:g} mm")

    def check(gauge: Gauge, pads: PadWear, settings: Settings) -> None:
        check_possible(gauge, pads, settings)
        if not options.sure:
            check_expected(gauge, pads, settings)

    return _enter(options, Gauge(time.time(), 0, options.thickness_mm, options.std_mm), check)


def _reset(options: Namespace) -> int:
    return _enter(options, Gauge(time.time(), 0, None), lambda *_: None)


def _undo(options: Namespace) -> int:
    return _enter(options, Gauge(time.time(), 0, None, takes_back=True), check_entered)


def _enter(options: Namespace, entry: Gauge, check: Callable[[Gauge, PadWear, Settings], None]) -> int:
    """Note the entry of the wheelset that was asked for, or of all, unless `check` refuses any."""
    settings = load_settings(options.config)
    every = range(1, settings.vehicle.wheelset_count + 1)
    wheelsets = [options.wheelset] if options.wheelset else every
    if wheelsets[0] not in every:
        raise InputError(f"--wheelset {wheelsets[0]}: {settings.vehicle.id} has {plural(len(every), 'wheelset')}")
    with _open(options, settings, "rw") as store:
        brakes = _brakes(store, settings)
        gauges = [replace(entry, wheelset=wheelset) for wheelset in wheelsets]
        for gauge in gauges:
            check(gauge, brakes.units[gauge.wheelset - 1].pads, settings)
        for gauge in gauges:
            store.enter(gauge)
            print(f"wheelset {gauge.wheelset}: {gauge.told()}; noted")
    return 0


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
    return Store.look(_directory(options, settings) / FILE_NAME, settings.vehicle.id, mode)


def _directory(options: Namespace, settings: Settings) -> Path:
    directory: Path | None = options.state or state_directory(settings)
    if directory is None:
        raise InputError(
            f"{options.config}: [store] names no directory: say where the daemon keeps its state with --state DIR"
        )
    if directory.is_file():
        raise InputError(f"{directory}: expected the daemon's state directory, this is a file")
    return directory


def _remarks(brakes: Brakes, set_aside: Sequence[Path]) -> Iterator[str]:
    """What makes the thicknesses doubtful."""
    unknown = [str(i) for i, unit in enumerate(brakes.units, 1) if not unit.pads.is_noted]
    if unknown:
        yield f"pads of wheelset {', '.join(unknown)}: taken for new, as nobody noted anything of them;"
        yield "gauge them (`wear set`), or note that they are new (`wear reset`)"
    if set_aside:
        yield f"an earlier memory was set aside: {set_aside[-1].name} (docs/memory.md)"


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
        f"{i:>8}  {interval_text(life.by_energy):<21} {life.by_archard.value_mm:>10.1f} {life.remaining_mm:>8.1f} "
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


def _large(number: float | None) -> str:
    return "?" if number is None else f"{number:,.0f}" if number < 1e7 else "> 10 M"


def _date(time_s: float) -> str:
    return datetime.fromtimestamp(time_s, UTC).strftime("%Y-%m-%d %H:%M UTC")
