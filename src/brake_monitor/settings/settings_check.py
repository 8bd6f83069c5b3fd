"""Whether what is configured beside the vehicle makes sense: buses, signals, thresholds."""

import re
from itertools import pairwise, permutations

from brake_monitor.nearest import nearest
from brake_monitor.samples import ESSENTIAL, TRAITS, Quantity
from brake_monitor.settings.alarm_settings import RuleSettings
from brake_monitor.settings.config import Settings, SignalMapping
from brake_monitor.settings.config_text import ConfigText, one_of, shown
from brake_monitor.settings.key_space import fault_of
from brake_monitor.settings.store_settings import MOST_EVIDENCE_S
from brake_monitor.settings.toml_lines import KeyPath
from brake_monitor.settings.wear_settings import WearSettings

_BUS_NAME = re.compile(r"[!-~]+")

_BY_PRESSURE = ("pressing_force", "load_force")
_SPEEDS = ("speed", "axle_speed")  # a force or torque held at 0 is that of a wheelset without brake or motor


def check_buses(text: ConfigText, settings: Settings) -> None:
    """InputError when a bus has no name or file, or two cannot be told apart."""
    if not settings.can:
        text.refuse(("can",), "expected at least one bus, got an empty list")
    names = [bus.name for bus in settings.can]
    for place, bus in enumerate(settings.can):
        key = ("can", place)
        for name in ("interface", "channel"):
            if not getattr(bus, name):
                text.refuse((*key, name), "expected a name, got an empty string")
        if not bus.dbc:
            text.refuse((*key, "dbc"), "expected at least one DBC file, got an empty list")
        if len(names) > 1 and not bus.name:
            text.refuse((*key, "name"), "this key is missing; with several buses each needs a name")
        if bus.name in names[:place]:
            text.refuse((*key, "name"), f'two buses are named "{bus.name}"')
        if any((other.interface, other.channel) == (bus.interface, bus.channel) for other in settings.can[:place]):
            sentence = f"another bus is {bus.interface} {bus.channel}, too: one table takes the DBC files of both"
            text.refuse((*key, "channel"), sentence)
        called = bus.name or bus.channel
        if not _BUS_NAME.fullmatch(called):
            sentence = "expected ASCII characters without blanks, as recordings name the bus"
            text.refuse((*key, "name" if bus.name else "channel"), f"{sentence}, got {shown(called)}")
        if any(called == other.channel for other in settings.can if other is not bus):
            text.refuse((*key, "name"), f'"{called}" is the channel of another bus')


def check_counts(text: ConfigText, settings: Settings) -> None:
    """InputError when a wheelset has no signal of its own where it needs one."""
    count = settings.vehicle.wheelset_count
    for name in (name for name, traits in TRAITS.items() if traits.per_wheelset):
        allowed, wanted = {count}, f"{count} (one per wheelset)"
        if name not in ESSENTIAL:
            allowed.add(0)
        if name == Quantity.WSP_ACTIVE:
            allowed.add(1)
            wanted += " or 1 (for all)"
        given = len(getattr(settings.signals, name))
        if given not in allowed:
            text.refuse(("signals", name), f"expected a list of {wanted}, got {given}")


def check_mappings(text: ConfigText, settings: Settings, buses: set[str]) -> None:
    """InputError when a signal's unit, scale, bounds or bus make no sense; `buses` are those there are."""
    for quantity, place, mapping in settings.signals.mapped():
        key = ("signals", quantity) if place is None else ("signals", quantity, place)
        units = list(TRAITS[quantity].units)
        if mapping.unit and mapping.unit not in units:
            wanted = one_of(units) if any(units) else "none, as a flag has none"
            wanted += " (scale and offset make a force of a pressure)" if quantity in _BY_PRESSURE else ""
            text.refuse((*key, "unit"), f"expected {wanted}, got {shown(mapping.unit)}")
        if mapping.scale == 0.0:
            text.refuse((*key, "scale"), "expected a number other than 0, got 0")
        if mapping.min is not None and mapping.max is not None and mapping.min > mapping.max:
            text.refuse((*key, "min"), f"{mapping.min:g} is greater than max = {mapping.max:g}")
        if mapping.min is not None and mapping.min == mapping.max and quantity in _SPEEDS:
            text.refuse((*key, "min"), f"{mapping.min:g} is max, too: a speed that is always the same tells nothing")
        _check_qualifier(text, key, mapping)
        if not mapping.bus and len(buses) > 1:
            text.refuse((*key, "bus"), f"this key is missing; with several buses expected {one_of(buses)}")
        if mapping.bus and mapping.bus not in buses:
            text.refuse((*key, "bus"), f'no bus is named "{mapping.bus}", {nearest(mapping.bus, sorted(buses))}')
    both = {"latitude": settings.signals.latitude, "longitude": settings.signals.longitude}
    for name, other in permutations(both, 2):
        if both[name] is not None and both[other] is None:
            text.refuse(("signals", name), f"expected {other} beside it, as a place has both")


def _check_qualifier(text: ConfigText, key: KeyPath, mapping: SignalMapping) -> None:
    if mapping.qualifier_good is None:
        return
    if not mapping.qualifier:
        text.refuse((*key, "qualifier_good"), "expected the key qualifier beside it, the signal that has these numbers")
    if not mapping.qualifier_good:
        text.refuse((*key, "qualifier_good"), "expected at least one number, got an empty list")


def check_rest(text: ConfigText, settings: Settings) -> None:
    """InputError when thresholds, limits or keys contradict each other."""
    for chunk in settings.zenoh.prefix.split("/"):
        if fault := fault_of(chunk):
            text.refuse(("zenoh", "prefix"), fault)
    if settings.metrics.port and not settings.zenoh.enabled:
        text.refuse(("metrics", "port"), "expected 0 with [zenoh] enabled = false, whose health it would serve")
    adhesion = settings.alarms.low_adhesion
    if not adhesion.low > adhesion.very_low > adhesion.extremely_low:
        text.refuse(("alarms", "low_adhesion"), "expected low > very_low > extremely_low")
    for kind, rule in settings.alarms.rules():
        _check_rising(text, ("alarms", kind), rule)
    wear = settings.wear
    _check_rising(text, ("wear",), wear)
    if wear.pad_limit_mm >= wear.new_pad_thickness_mm:
        sentence = f"expected less than new_pad_thickness_mm = {wear.new_pad_thickness_mm:g}"
        text.refuse(("wear", "pad_limit_mm"), f"{sentence}, got {wear.pad_limit_mm:g}")
    store = settings.store
    if store.evidence_before_s + store.evidence_after_s > MOST_EVIDENCE_S:
        sentence = (
            f"expected no more than {MOST_EVIDENCE_S:g} s together with evidence_after_s = {store.evidence_after_s:g}"
        )
        text.refuse(("store", "evidence_before_s"), f"{sentence}, got {store.evidence_before_s:g}")
    _check_margins(text, settings)


def _check_margins(text: ConfigText, settings: Settings) -> None:
    """An alarm is cleared at its limit less its margin; where no vehicle gets there, it would stay open for good."""
    alarms, wear = settings.alarms, settings.wear
    per_application = ("uneven_braking", "warning"), ("friction_out_of_band", "warning"), ("friction_drift", "limit")
    for kind, name in per_application:
        rule = getattr(alarms, kind)
        if rule.clear_margin >= getattr(rule, name):
            sentence = f"expected less than {name} = {getattr(rule, name):g}, got {rule.clear_margin:g}"
            text.refuse(("alarms", kind, "clear_margin"), sentence)
    hot = alarms.hot_disc
    if hot.warning_c - hot.clear_margin_k <= wear.ambient_c:
        sentence = f"expected warning_c - clear_margin_k to be more than [wear] ambient_c = {wear.ambient_c:g}"
        text.refuse(("alarms", "hot_disc", "clear_margin_k"), sentence)
    near = alarms.pad_near_limit
    for kind, margin_mm in (
        ("pad_near_limit", near.margin_mm + near.clear_margin_mm),
        ("pad_at_limit", alarms.pad_at_limit.clear_margin_mm),
    ):
        cleared_mm = wear.pad_limit_mm + margin_mm
        if cleared_mm >= wear.new_pad_thickness_mm:
            sentence = (
                f"expected that new pads of {wear.new_pad_thickness_mm:g} mm, as in [wear], clear it, "
                f"which takes more than {cleared_mm:g} mm: pad_limit_mm and the margins"
            )
            text.refuse(("alarms", kind, "clear_margin_mm"), sentence)


def _check_rising(text: ConfigText, key: KeyPath, table: RuleSettings | WearSettings) -> None:
    for lower, upper in pairwise(table.rising):
        value, limit = getattr(table, lower), getattr(table, upper)
        if value > limit:
            text.refuse((*key, lower), f"expected no more than {upper} = {limit:g}, got {value:g}")
