"""Configuration file → Settings, or one sentence that names file, line and key."""

import operator
import re
import tomllib
from itertools import pairwise
from math import isfinite, nan
from pathlib import Path
from statistics import fmean
from typing import Any, NoReturn

import msgspec
from msgspec import inspect

from brake_monitor.errors import InputError
from brake_monitor.nearest import nearest, nearest_file
from brake_monitor.settings.config import CanBus, Settings, SignalMapping, Vehicle
from brake_monitor.settings.key_space import fault_of
from brake_monitor.settings.store_settings import StoreSettings
from brake_monitor.settings.toml_lines import KeyPath, key_lines, line_of
from brake_monitor.settings.units import UNITS
from brake_monitor.settings.zenoh_settings import ZenohSettings

_BUS_NAME = re.compile(r"[!-~]+")
_PER_WHEELSET = ("wheelset_inertia_kgm2", "wheel_radius_m", "brake_radius_m")

# Beyond what any vehicle or rig has, so that one of the two was meant in another unit.
_LEAST_MASS = 0.2  # of J/r^2 of all wheelsets
_LEAST_TURNING_MASS = 1e-4  # J/r^2 of a wheelset, of its share of the mass

# Settings of which none may be greater than the next, by alarm rule; and those of [wear].
_RISING = {
    "slide": ("min_distance_m", "flat_possible_m", "flat_likely_m"),
    "uneven_braking": ("warning", "alarm"),
    "friction_out_of_band": ("warning", "alarm"),
    "friction_drift": ("min_stops", "stops"),
    "hot_disc": ("warning_c", "alarm_c"),
}
_RISING_WEAR = ("least_specific_wear_cm3_per_mj", "specific_wear_cm3_per_mj", "greatest_specific_wear_cm3_per_mj")


def load_settings(path: Path) -> Settings:
    """Read, check and complete a TOML configuration.

    Numbers given once for all wheelsets become tuples of length N, DBC paths become absolute, and each mapped
    signal names its bus. Raises InputError, "FILE:LINE: key: what was expected and what was found".
    """
    text = _read(path)
    checker = _Checker(path, text)
    table = checker.parse(text)
    _spread(table)
    checker.check_table(table, inspect.type_info(Settings), ())
    settings = msgspec.convert({**table, "path": path}, Settings, dec_hook=lambda wanted, value: wanted(value))
    checker.check_vehicle(settings)
    checker.check_buses(settings)
    checker.check_counts(settings)
    checker.check_rest(settings)
    buses = _complete_buses(settings)
    checker.check_mappings(settings, {bus.name for bus in buses})
    return msgspec.structs.replace(
        settings,
        can=buses,
        signals=_complete_signals(settings, buses),
        zenoh=_complete_zenoh(settings),
        store=_complete_store(settings),
    )


def place_of(path: Path, key: KeyPath) -> str:
    """Return "FILE:LINE" of a key in a configuration that was loaded, for what is found wrong with it later."""
    try:
        return f"{path}:{line_of(key_lines(_read(path)), key)}"
    except (InputError, IndexError, ValueError):  # it is another text by now, or never was a file
        return f"{path}"


class _Checker:
    """Knows where each key stands, and refuses what must not be there."""

    def __init__(self, path: Path, text: str) -> None:
        self._path = path
        self._last_line = text.count("\n") + 1
        self._lines: dict[KeyPath, int] = {}

    def parse(self, text: str) -> dict[str, Any]:
        try:
            table = tomllib.loads(text)
            self._lines = key_lines(text)
        except tomllib.TOMLDecodeError as error:
            place = re.search(r"^(.*) \(at (?:line (\d+), column \d+|end of document)\)$", str(error))
            what, line = (place[1], int(place[2] or self._last_line)) if place else (str(error), 1)
            raise InputError(f"{self._path}:{line}: not valid TOML: {what}") from None
        except RecursionError:
            raise InputError(f"{self._path}: not valid TOML: nested too deeply") from None
        return table

    def refuse(self, key: KeyPath, sentence: str) -> NoReturn:
        written: KeyPath = ()
        for part in key:  # a place that is not in the text: what was given once was made a list
            if not isinstance(part, int) or (*written, part) in self._lines:
                written = (*written, part)
        raise InputError(f"{self._path}:{line_of(self._lines, written)}: {_dotted(written)}: {sentence}")

    def check_table(self, value: Any, wanted: inspect.Type, key: KeyPath) -> None:
        """Compare `value` with the type of the setting at `key`: keys, types, bounds, finite numbers."""
        match wanted:
            case inspect.StructType():
                self._check_keys(value, wanted, key)
            case inspect.VarTupleType():
                if not isinstance(value, list):
                    self.refuse(key, f"expected a list, got {_shown(value)}")
                for place, entry in enumerate(value):
                    self.check_table(entry, wanted.item_type, (*key, place))
            case inspect.UnionType():  # "number or absent": TOML has no null
                (present,) = (t for t in wanted.types if not isinstance(t, inspect.NoneType))
                self.check_table(value, present, key)
            case _:
                if _is_number(value) and not _is_finite(value):
                    self.refuse(key, f"expected a finite number, got {_shown(value)}")
                if not _fits(value, wanted):
                    self.refuse(key, f"expected {_expected(wanted, value)}, got {_shown(value)}")
                if isinstance(value, str) and "\0" in value:  # no path and no name of the system's may hold one
                    self.refuse(key, "expected text without the character NUL")

    def _check_keys(self, table: Any, wanted: inspect.StructType, key: KeyPath) -> None:
        if not isinstance(table, dict):
            self.refuse(key, f"expected a table, got {_shown(table)}")
        fields = {field.name: field for field in wanted.fields if (*key, field.name) != ("path",)}
        for name in table:
            if name not in fields:
                self.refuse((*key, name), f"unknown key, {nearest(name, list(fields))}")
        for name, field in fields.items():
            if name in table:
                self.check_table(table[name], field.type, (*key, name))
            elif field.required:
                self.refuse((*key, name), "this key is missing")

    def check_vehicle(self, settings: Settings) -> None:
        vehicle = settings.vehicle
        self._check_chunk(("vehicle", "id"), vehicle.id)
        count = vehicle.wheelset_count
        if count == 0:
            self.refuse(("vehicle", "axle_positions_m"), "expected one number per wheelset, got an empty list")
        if len(set(vehicle.axle_positions_m)) < count:
            self.refuse(("vehicle", "axle_positions_m"), "two wheelsets stand at the same place")
        for name in _PER_WHEELSET:
            given = len(getattr(vehicle, name))
            if given != count:
                self.refuse(
                    ("vehicle", name), f"expected a number or a list of {count} (one per wheelset), got {given}"
                )
        self._check_bogies(vehicle)
        self._check_weight(vehicle)
        self._check_turning_mass(vehicle)

    def _check_bogies(self, vehicle: Vehicle) -> None:
        """Two or more of them, one behind the other, with a known height of their pivots; or none."""
        count, each = vehicle.wheelset_count, vehicle.wheelsets_per_bogie
        if each == 1:
            if vehicle.pivot_height_m:
                self.refuse(("vehicle", "pivot_height_m"), "expected wheelsets_per_bogie = 2 or more beside it")
            return
        if count % each or count == each:
            self.refuse(
                ("vehicle", "wheelsets_per_bogie"), f"expected {count} wheelsets to make two or more such bogies"
            )
        if not 0.0 < vehicle.pivot_height_m <= vehicle.cog_height_m:
            self.refuse(
                ("vehicle", "pivot_height_m"),
                f"bogies need the height of their pivots above the rail, at most cog_height_m, got "
                f"{vehicle.pivot_height_m:g}",
            )
        in_order = sorted(vehicle.axle_positions_m)
        if list(vehicle.axle_positions_m) not in (in_order, in_order[::-1]):
            self.refuse(("vehicle", "axle_positions_m"), "with bogies, expected places in order along the vehicle")

    def _check_weight(self, vehicle: Vehicle) -> None:
        """Equally stiff wheelsets or bogies share the weight linearly along the vehicle; each must carry some of it."""
        each = vehicle.wheelsets_per_bogie
        centres_m = [
            fmean(vehicle.axle_positions_m[first : first + each]) for first in range(0, vehicle.wheelset_count, each)
        ]
        mean_m = fmean(centres_m)
        apart_m = [centre_m - mean_m for centre_m in centres_m]
        spread_m2 = sum(apart**2 for apart in apart_m)
        for place, apart in enumerate(apart_m):
            if spread_m2 > 0.0 and mean_m * apart / spread_m2 > (1.0 - 1e-6) / len(centres_m):
                self.refuse(
                    ("vehicle", "axle_positions_m", place * each),
                    "no weight rests on this wheelset: expected places from the centre of gravity, forward positive",
                )

    def _check_turning_mass(self, vehicle: Vehicle) -> None:
        """J/r^2 of all wheelsets is some hundredths of the mass, with geared motors or flywheels some tenths."""
        turning_kg = [
            inertia / radius**2
            for inertia, radius in zip(vehicle.wheelset_inertia_kgm2, vehicle.wheel_radius_m, strict=True)
        ]
        if vehicle.mass_kg < _LEAST_MASS * sum(turning_kg):
            self.refuse(
                ("vehicle", "mass_kg"),
                f"expected a mass that fits the wheelsets, whose inertia alone stands for {sum(turning_kg):.0f} kg "
                f"(wheelset_inertia_kgm2 / wheel_radius_m^2), got {vehicle.mass_kg:g}",
            )
        for place, (each_kg, inertia) in enumerate(zip(turning_kg, vehicle.wheelset_inertia_kgm2, strict=True)):
            share_kg = vehicle.mass_kg / vehicle.wheelset_count
            if each_kg < _LEAST_TURNING_MASS * share_kg:
                self.refuse(
                    ("vehicle", "wheelset_inertia_kgm2", place),
                    f"expected more: {inertia:g} kg m2 at this wheel radius stand for {each_kg:.2g} kg of {share_kg:g}",
                )

    def check_buses(self, settings: Settings) -> None:
        if not settings.can:
            self.refuse(("can",), "expected at least one bus, got an empty list")
        names = [bus.name for bus in settings.can]
        for place, bus in enumerate(settings.can):
            key = ("can", place)
            for name in ("interface", "channel"):
                if not getattr(bus, name):
                    self.refuse((*key, name), "expected a name, got an empty string")
            if not bus.dbc:
                self.refuse((*key, "dbc"), "expected at least one DBC file, got an empty list")
            if len(names) > 1 and not bus.name:
                self.refuse((*key, "name"), "this key is missing; with several buses each needs a name")
            if bus.name in names[:place]:
                self.refuse((*key, "name"), f'two buses are named "{bus.name}"')
            called = bus.name or bus.channel
            if not _BUS_NAME.fullmatch(called):
                sentence = "expected ASCII characters without blanks, as recordings name the bus"
                self.refuse((*key, "name" if bus.name else "channel"), f"{sentence}, got {_shown(called)}")
            if any(called == other.channel for other in settings.can if other is not bus):
                self.refuse((*key, "name"), f'"{called}" is the channel of another bus')

    def check_counts(self, settings: Settings) -> None:
        count = settings.vehicle.wheelset_count
        signals = settings.signals
        allowed = {
            "axle_speed": {count},
            "pressing_force": {count},
            "wsp_active": {0, 1, count},
            "wheel_torque": {0, count},
        }
        for name, counts in allowed.items():
            given = len(getattr(signals, name))
            if given not in counts:
                wanted = f"{count} (one per wheelset)" + (" or 1 (for all)" if name == "wsp_active" else "")
                self.refuse(("signals", name), f"expected a list of {wanted}, got {given}")

    def check_mappings(self, settings: Settings, buses: set[str]) -> None:
        for key, mapping in _mappings(settings):
            units = list(UNITS[str(key[1])])
            if mapping.unit and mapping.unit not in units:
                wanted = _one_of(units) if any(units) else "none, as a flag has none"
                self.refuse((*key, "unit"), f"expected {wanted}, got {_shown(mapping.unit)}")
            if mapping.scale == 0.0:
                self.refuse((*key, "scale"), "expected a number other than 0, got 0")
            if mapping.min is not None and mapping.max is not None and mapping.min > mapping.max:
                self.refuse((*key, "min"), f"{mapping.min:g} is greater than max = {mapping.max:g}")
            if not mapping.bus and len(buses) > 1:
                self.refuse((*key, "bus"), f"this key is missing; with several buses expected {_one_of(buses)}")
            if mapping.bus and mapping.bus not in buses:
                self.refuse((*key, "bus"), f'no bus is named "{mapping.bus}", {nearest(mapping.bus, sorted(buses))}')

    def check_rest(self, settings: Settings) -> None:
        for chunk in settings.zenoh.prefix.split("/"):
            self._check_chunk(("zenoh", "prefix"), chunk)
        if settings.metrics.port and not settings.zenoh.enabled:
            self.refuse(("metrics", "port"), "expected 0 with [zenoh] enabled = false, whose health it would serve")
        rule = settings.alarms.low_adhesion
        if not rule.low > rule.very_low > rule.extremely_low:
            self.refuse(("alarms", "low_adhesion"), "expected low > very_low > extremely_low")
        for kind, names in _RISING.items():
            self._check_rising(("alarms", kind), getattr(settings.alarms, kind), names)
        wear = settings.wear
        self._check_rising(("wear",), wear, _RISING_WEAR)
        if wear.pad_limit_mm >= wear.new_pad_thickness_mm:
            sentence = f"expected less than new_pad_thickness_mm = {wear.new_pad_thickness_mm:g}"
            self.refuse(("wear", "pad_limit_mm"), f"{sentence}, got {wear.pad_limit_mm:g}")
        self._check_margins(settings)

    def _check_margins(self, settings: Settings) -> None:
        """An alarm is cleared at its limit less its margin: what no vehicle is ever beyond would keep it for good."""
        alarms, wear = settings.alarms, settings.wear
        per_stop = ("uneven_braking", "warning"), ("friction_out_of_band", "warning"), ("friction_drift", "limit")
        for kind, name in per_stop:
            rule = getattr(alarms, kind)
            if rule.clear_margin >= getattr(rule, name):
                sentence = f"expected less than {name} = {getattr(rule, name):g}, got {rule.clear_margin:g}"
                self.refuse(("alarms", kind, "clear_margin"), sentence)
        hot = alarms.hot_disc
        if hot.warning_c - hot.clear_margin_k <= wear.ambient_c:
            sentence = f"expected warning_c - clear_margin_k to be more than [wear] ambient_c = {wear.ambient_c:g}"
            self.refuse(("alarms", "hot_disc", "clear_margin_k"), sentence)
        near = alarms.pad_near_limit
        for kind, margin_mm in (
            ("pad_near_limit", near.margin_mm + near.clear_margin_mm),
            ("pad_at_limit", alarms.pad_at_limit.clear_margin_mm),
        ):
            if wear.pad_limit_mm + margin_mm >= wear.new_pad_thickness_mm:
                sentence = f"expected that new pads of {wear.new_pad_thickness_mm:g} mm, as in [wear], clear it"
                self.refuse(("alarms", kind, "clear_margin_mm"), sentence)

    def _check_rising(self, key: KeyPath, table: object, names: tuple[str, ...]) -> None:
        for lower, upper in pairwise(names):
            value, limit = getattr(table, lower), getattr(table, upper)
            if value > limit:
                self.refuse((*key, lower), f"expected no more than {upper} = {limit:g}, got {value:g}")

    def _check_chunk(self, key: KeyPath, chunk: str) -> None:
        if fault := fault_of(chunk):
            self.refuse(key, fault)


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}{nearest_file(path)}") from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: expected a configuration in TOML, this is not text in UTF-8") from None


def _spread(table: dict[str, Any]) -> None:
    """Give every wheelset its own number where one was given for all, and a single [can] its list."""
    vehicle, bus = table.get("vehicle"), table.get("can")
    if isinstance(vehicle, dict) and isinstance(vehicle.get("axle_positions_m"), list):
        for name in _PER_WHEELSET:
            if _is_number(vehicle.get(name)):
                vehicle[name] = [vehicle[name]] * len(vehicle["axle_positions_m"])
    if isinstance(bus, dict):
        table["can"] = [bus]


def _complete_buses(settings: Settings) -> tuple[CanBus, ...]:
    folder = settings.path.absolute().parent
    return tuple(
        msgspec.structs.replace(
            bus,
            name=bus.name or bus.channel,
            dbc=tuple(dict.fromkeys(folder / dbc for dbc in bus.dbc)),  # one that is listed twice says nothing new
        )
        for bus in settings.can
    )


def _complete_zenoh(settings: Settings) -> ZenohSettings:
    tls, folder = settings.zenoh.tls, settings.path.absolute().parent
    if tls is None:
        return settings.zenoh
    paths = {name: folder / path for name, path in tls.files.items()}
    return msgspec.structs.replace(settings.zenoh, tls=msgspec.structs.replace(tls, **paths))


def _complete_signals(settings: Settings, buses: tuple[CanBus, ...]) -> Any:
    def complete(entry: Any) -> Any:
        if isinstance(entry, tuple):
            return tuple(complete(mapping) for mapping in entry)
        return entry and msgspec.structs.replace(entry, bus=entry.bus or buses[0].name)

    entries = {name: complete(getattr(settings.signals, name)) for name in UNITS}
    return msgspec.structs.replace(settings.signals, **entries)


def _complete_store(settings: Settings) -> StoreSettings:
    directory = settings.store.directory
    return msgspec.structs.replace(settings.store, directory=directory and settings.path.absolute().parent / directory)


def _mappings(settings: Settings) -> list[tuple[KeyPath, SignalMapping]]:
    found: list[tuple[KeyPath, SignalMapping]] = []
    for name in UNITS:
        entry = getattr(settings.signals, name)
        if isinstance(entry, SignalMapping):
            found.append((("signals", name), entry))
        elif entry is not None:
            found += [(("signals", name, place), mapping) for place, mapping in enumerate(entry)]
    return found


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _fits(value: Any, wanted: inspect.Type) -> bool:
    match wanted:
        case inspect.FloatType() | inspect.IntType():
            if not _is_number(value) or (isinstance(wanted, inspect.IntType) and not isinstance(value, int)):
                return False
            return all(holds for _, _, holds in _bounds(wanted, value))
        case inspect.BoolType():
            return isinstance(value, bool)
        case inspect.LiteralType():
            return value in wanted.values
        case _:  # text, and paths which are written as text
            return isinstance(value, str)


def _is_finite(value: float) -> bool:
    try:
        return isfinite(value)
    except OverflowError:  # an integer beyond the largest float
        return False


def _bounds(wanted: inspect.FloatType | inspect.IntType, value: float) -> list[tuple[str, float, bool]]:
    """Each bound in words, and whether the value keeps it."""
    bounds = (
        ("greater than", wanted.gt, operator.gt),
        ("not less than", wanted.ge, operator.ge),
        ("less than", wanted.lt, operator.lt),
        ("not greater than", wanted.le, operator.le),
    )
    return [(words, bound, holds(value, bound)) for words, bound, holds in bounds if bound is not None]


def _expected(wanted: inspect.Type, value: Any) -> str:
    match wanted:
        case inspect.FloatType() | inspect.IntType():
            noun = "a whole number" if isinstance(wanted, inspect.IntType) else "a number"
            bounds = _bounds(wanted, value if _is_number(value) else nan)
            broken = next((f" {words} {bound:g}" for words, bound, holds in bounds if not holds), "")
            return noun + broken
        case inspect.BoolType():
            return "true or false"
        case inspect.LiteralType():
            return _one_of(wanted.values)
        case _:
            return "a string"


def _one_of(names: Any) -> str:
    return "one of " + ", ".join(f'"{name}"' for name in sorted(names))


def _shown(value: Any) -> str:
    """Render a found value as its author wrote it, or say what it is where that would be long."""
    match value:
        case dict():
            return "a table"
        case list():
            return "a list"
        case bool():
            return str(value).lower()
        case str():
            return '"' + value.encode("unicode_escape").decode() + '"'
        case _:
            return f"{value!s:.40}"


def _dotted(key: KeyPath) -> str:
    """vehicle.mass_kg, signals.axle_speed[2].unit: places are counted from 1 like wheelsets."""
    return "".join(f"[{part + 1}]" if isinstance(part, int) else f".{part}" for part in key).lstrip(".")
