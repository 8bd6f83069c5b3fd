"""What a wagon's daemon says of itself: the payload under `…/meta`."""

import platform
from collections.abc import Iterator
from importlib.metadata import version

from brake_monitor import __version__
from brake_monitor.publishing.payload_schemas import KEYS
from brake_monitor.publishing.payloads import MetaMessage
from brake_monitor.settings.config import Settings, Signals
from brake_monitor.settings.key_space import KeySpace
from brake_monitor.value_names import UNITS

VERSIONS = {
    "brake-monitor": __version__,
    "python": platform.python_version(),
    "eclipse-zenoh": version("eclipse-zenoh"),
}


def about(settings: Settings, time_s: float) -> MetaMessage:
    """Describe what is published from `time_s` on. Nothing secret is in it, nor where anything is kept."""
    keys = KeySpace(settings.zenoh.prefix, settings.vehicle.id)
    return MetaMessage(
        time_s=time_s,
        wagon=settings.vehicle.id,
        wheelsets=settings.vehicle.wheelset_count,
        preset=settings.estimator.preset,
        estimate_rate_hz=settings.output.rate_hz,
        mass_kg=settings.vehicle.mass_kg,
        axle_positions_m=settings.vehicle.axle_positions_m,
        wheel_radius_m=settings.vehicle.wheel_radius_m,
        buses=tuple(f"{bus.name}: {bus.interface} {bus.channel}" for bus in settings.can),
        signals=dict(_mapped(settings.signals)),
        encoding=settings.zenoh.encoding,
        accepts_acknowledgements=settings.zenoh.accept_acknowledgements,
        units=UNITS,
        schemas={keys.under(key): keys.schema(name) for key, name in KEYS.items()},
        versions=VERSIONS,
        sequence=1,
        publish_time_s=time_s,
        adhesion_levels=settings.alarms.low_adhesion.levels,
        friction_nominal=settings.estimator.friction_nominal,
        new_pad_thickness_mm=settings.wear.new_pad_thickness_mm,
        pad_limit_mm=settings.wear.pad_limit_mm,
        pad_margin_mm=settings.alarms.pad_near_limit.margin_mm,
    )


def _mapped(signals: Signals) -> Iterator[tuple[str, str]]:
    for quantity, place, mapping in signals.mapped():
        yield quantity if place is None else f"{quantity}/{place + 1}", mapping.source
