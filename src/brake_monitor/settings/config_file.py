"""Configuration file → Settings, or one sentence that names file, line and key."""

import os
from pathlib import Path
from typing import Any

import msgspec
from msgspec import inspect

from brake_monitor.settings.config import CanBus, Settings, SignalMapping
from brake_monitor.settings.config_text import ConfigText, shown
from brake_monitor.settings.settings_check import check_buses, check_counts, check_mappings, check_rest
from brake_monitor.settings.store_settings import StoreSettings
from brake_monitor.settings.typed_table import check_table, is_number
from brake_monitor.settings.vehicle_check import PER_WHEELSET, a_number_or_list, check_vehicle
from brake_monitor.settings.zenoh_settings import ZenohSettings


def load_settings(path: Path) -> Settings:
    """Read, check and complete a TOML configuration.

    Numbers given once for all wheelsets become tuples of length N, DBC paths become absolute, and each mapped
    signal names its bus. Raises InputError, "FILE:LINE: key: what was expected and what was found".
    """
    text = ConfigText.read(path)
    table = text.table()
    _spread(text, table)
    check_table(text, table, inspect.type_info(Settings), ())
    settings = msgspec.convert({**table, "path": path}, Settings, dec_hook=lambda wanted, value: wanted(value))
    check_vehicle(text, settings.vehicle)
    check_buses(text, settings)
    check_counts(text, settings)
    check_rest(text, settings)
    folder = path.absolute().parent
    buses = _complete_buses(settings.can, folder)
    check_mappings(text, settings, {bus.name for bus in buses})
    return msgspec.structs.replace(
        settings,
        can=buses,
        signals=_complete_signals(settings, buses),
        zenoh=_complete_zenoh(settings.zenoh, folder),
        store=_complete_store(text, settings.store, folder),
    )


def _spread(text: ConfigText, table: dict[str, Any]) -> None:
    """Give every wheelset its own number where one was given for all, and a single [can] its list."""
    vehicle, bus = table.get("vehicle"), table.get("can")
    if isinstance(vehicle, dict) and isinstance(vehicle.get("axle_positions_m"), list):
        count = len(vehicle["axle_positions_m"])
        for name in PER_WHEELSET:
            given = vehicle.get(name)
            if is_number(given):
                vehicle[name] = [given] * count
            elif name in vehicle and not isinstance(given, list):
                text.refuse(("vehicle", name), f"expected {a_number_or_list(count)}, got {shown(given)}")
    if isinstance(bus, dict):
        table["can"] = [bus]


def _complete_buses(buses: tuple[CanBus, ...], folder: Path) -> tuple[CanBus, ...]:
    return tuple(
        msgspec.structs.replace(
            bus,
            name=bus.name or bus.channel,
            dbc=tuple(dict.fromkeys(folder / dbc for dbc in bus.dbc)),  # a file listed twice says nothing new
        )
        for bus in buses
    )


def _complete_zenoh(zenoh: ZenohSettings, folder: Path) -> ZenohSettings:
    if zenoh.tls is None:
        return zenoh
    paths = {name: folder / path for name, path in zenoh.tls.files.items()}
    return msgspec.structs.replace(zenoh, tls=msgspec.structs.replace(zenoh.tls, **paths))


def _complete_signals(settings: Settings, buses: tuple[CanBus, ...]) -> Any:
    def complete(entry: Any) -> Any:
        if isinstance(entry, tuple):
            return tuple(complete(mapping) for mapping in entry)
        if not isinstance(entry, SignalMapping):
            return entry
        return msgspec.structs.replace(entry, bus=entry.bus or buses[0].name)

    entries = {name: complete(getattr(settings.signals, name)) for name in settings.signals.__struct_fields__}
    return msgspec.structs.replace(settings.signals, **entries)


def _complete_store(text: ConfigText, store: StoreSettings, folder: Path) -> StoreSettings:
    directory = store.directory and folder / store.directory
    if directory and os.path.isfile(directory):  # noqa: PTH113 - False where nobody may look, which is no fault of the file
        text.refuse(("store", "directory"), f"expected a directory, {directory} is a file")
    return msgspec.structs.replace(store, directory=directory)
