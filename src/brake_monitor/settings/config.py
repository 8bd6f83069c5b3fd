"""TOML → validated, frozen settings. Every unit stands in the key's name."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Literal
from zlib import crc32

from msgspec import Meta, Struct

from brake_monitor.settings.alarm_settings import AlarmSettings
from brake_monitor.settings.bounds import Force, Friction, Rate, TimeOut
from brake_monitor.settings.store_settings import StoreSettings
from brake_monitor.settings.units import si_factor
from brake_monitor.settings.wear_settings import WearSettings
from brake_monitor.settings.zenoh_settings import MetricsSettings, ZenohSettings

Preset = Literal["wagon", "train", "rig"]
FrictionModel = Literal["random-walk", "first-order"]
Mass = Annotated[float, Meta(gt=0.0, le=1e7)]
Position = Annotated[float, Meta(ge=-500.0, le=500.0)]
Height = Annotated[float, Meta(ge=0.0, le=10.0)]
Count = Annotated[int, Meta(ge=1, le=100)]
Inertia = Annotated[float, Meta(gt=0.0, le=1e5)]
WheelRadius = Annotated[float, Meta(ge=0.001, le=2.0)]
BrakeRadius = Annotated[float, Meta(ge=0.001, le=5.0)]
FullForce = Annotated[float, Meta(gt=0.0, le=1e7)]
Resistance = Annotated[float, Meta(ge=0.0, le=1e7)]
Drag = Annotated[float, Meta(ge=0.0, le=1e5)]
Delay = Annotated[float, Meta(ge=0.0, le=30.0)]
Conversion = Annotated[float, Meta(ge=-1e12, le=1e12)]
Spread = Annotated[float, Meta(ge=0.0, le=1e12)]  # what is squared must still be a number
Tuned = Annotated[float, Meta(ge=0.0, le=1e3)]  # beyond any use; far beyond, the covariance loses its sign
LARGEST_BRAKE_RATIO = 4.0  # of the brakes of two wheelsets of one vehicle


class Vehicle(Struct, frozen=True, forbid_unknown_fields=True):
    """The wagon's fixed properties; per-wheelset values are tuples of length N after loading.

    The bounds leave room for everything on rails, from models to transporters of 800 t, and none for mm and kN.
    """

    id: str
    mass_kg: Mass
    axle_positions_m: tuple[Position, ...]  # from the centre of gravity, forward positive; N = its length
    cog_height_m: Height
    wheelset_inertia_kgm2: tuple[Inertia, ...]
    wheel_radius_m: tuple[WheelRadius, ...]
    brake_radius_m: tuple[BrakeRadius, ...]  # times the gear ratio of a disc on a geared shaft
    track_resistance_n: Resistance = 0.0
    drag_n_per_mps2: Drag = 0.0
    wheelsets_per_bogie: Count = 1  # neighbours in one frame that pitches by itself; 1: all are in the body's
    pivot_height_m: Height = 0.0  # above the rail, where bogies take hold of the body
    full_pressing_force_n: tuple[FullForce, ...] = ()  # of each brake; (): they are as `scale` of their signals says

    @property
    def wheelset_count(self) -> int:
        """N, the number of wheelsets (1 roller rig, 2 two-axle wagon, 4 bogie wagon)."""
        return len(self.axle_positions_m)

    @property
    def turning_kg(self) -> tuple[float, ...]:
        """What the inertia of each wheelset adds to the mass as the wagon gains or loses speed, J/r^2, kg."""
        radii_m = zip(self.wheelset_inertia_kgm2, self.wheel_radius_m, strict=True)
        return tuple([inertia_kgm2 / radius_m**2 for inertia_kgm2, radius_m in radii_m])

    def resistance_n(self, speed_mps: float) -> float:
        """F_TR + k_d v², which brakes; the gradient is not in it."""
        return self.track_resistance_n + self.drag_n_per_mps2 * (speed_mps * speed_mps)


class CanBus(Struct, frozen=True, forbid_unknown_fields=True):
    """One bus: a python-can interface and the DBC files that describe its traffic."""

    interface: str
    channel: str
    dbc: tuple[Path, ...]  # absolute after loading; relative to the configuration file in it
    name: str = ""  # needed when there are several buses; else the channel
    allow_active: bool = False  # listen even where the controller could send; it is never made to


class SignalMapping(Struct, frozen=True, forbid_unknown_fields=True):
    """Where one quantity is found. Quantity = (DBC physical value * scale + offset), clamped, in `unit`."""

    message: str
    signal: str
    bus: str = ""  # may be left out with one bus
    unit: str = ""  # the quantity's SI unit when left out
    scale: Conversion = 1.0
    offset: Conversion = 0.0
    min: Conversion | None = None  # clamps the converted value, in `unit`
    max: Conversion | None = None
    noise_std: Spread | None = None  # in `unit`
    delay_s: Delay = 0.0
    timeout_s: TimeOut | None = None  # else from the DBC's cycle time
    match: Literal["id", "pgn"] | None = None  # "pgn": any J1939 priority and address; else as the DBC says
    counter: str = ""  # rolling counter signal in the same message, verified when named
    qualifier: str = ""  # signal in the same message that says whether the value is to be believed ...
    qualifier_good: tuple[int, ...] | None = None  # ... by one of these raw numbers; 1 when left out

    @property
    def source(self) -> str:
        """Where the DBC has it: `<message>.<signal>`."""
        return f"{self.message}.{self.signal}"

    @property
    def good_numbers(self) -> tuple[int, ...]:
        """By which its qualifier says that the value is to be believed."""
        return (1,) if self.qualifier_good is None else self.qualifier_good


class Signals(Struct, frozen=True, forbid_unknown_fields=True):
    """The mapping from the vehicle's own DBC to our quantities; lists have one entry per wheelset."""

    speed: SignalMapping
    axle_speed: tuple[SignalMapping, ...]
    pressing_force: tuple[SignalMapping, ...]
    wsp_active: tuple[SignalMapping, ...] = ()  # one per wheelset, or one for all
    sanding: SignalMapping | None = None
    load_force: tuple[SignalMapping, ...] = ()  # weight on the rail, N; the entries add up to the vehicle's
    gradient: SignalMapping | None = None  # rise over run, uphill positive
    wheel_torque: tuple[SignalMapping | Literal["none"], ...] = ()  # M_W,i, N m, accelerating positive; or no motor
    latitude: SignalMapping | None = None  # degrees
    longitude: SignalMapping | None = None

    def mapped(self) -> Iterator[tuple[str, int | None, SignalMapping]]:
        """Yield each mapping with its quantity and its index in the list, None for a quantity that has no list."""
        for quantity in self.__struct_fields__:
            found: SignalMapping | tuple[SignalMapping | str, ...] | None = getattr(self, quantity)
            if isinstance(found, SignalMapping):
                yield quantity, None, found
                continue
            for place, mapping in enumerate(found or ()):
                if isinstance(mapping, SignalMapping):
                    yield quantity, place, mapping


class TuningOverrides(Struct, frozen=True, forbid_unknown_fields=True):
    """Takes the place of the preset's values where given; meaning and units are those of `tuning.Tuning`."""

    omega: Tuned | None = None
    speed: Tuned | None = None
    friction: Tuned | None = None
    friction_own: Tuned | None = None
    adhesion: Tuned | None = None
    adhesion_own: Tuned | None = None
    adhesion_sliding: Tuned | None = None
    deceleration: Tuned | None = None
    deceleration_braking: Tuned | None = None
    deceleration_sliding: Tuned | None = None
    deceleration_per_metre: Tuned | None = None
    deceleration_onset_std: Tuned | None = None
    adhesion_decay: Tuned | None = None
    adhesion_decay_std: Tuned | None = None
    uptake: Tuned | None = None
    uptake_std: Tuned | None = None
    force_effect_std: Tuned | None = None
    friction_own_std: Tuned | None = None
    adhesion_std: Tuned | None = None
    deceleration_std: Tuned | None = None
    speed_lag_std: Tuned | None = None
    torque_error_std: Tuned | None = None


class EstimatorSettings(Struct, frozen=True, forbid_unknown_fields=True):
    """The preset, and what may be overridden in it."""

    preset: Preset = "wagon"
    tuning: TuningOverrides = TuningOverrides()
    friction_nominal: Friction = 0.35
    friction_nominal_std: Friction = 0.04
    friction_model: FrictionModel = "random-walk"  # or "first-order", back to nominal while the pad presses
    friction_time_s: Annotated[float, Meta(ge=1.0)] = 60.0  # first-order: a small deviation falls to 37 % in it
    contact_force_n: Force = 2000.0  # below it the pad does not press and friction is held


class OutputSettings(Struct, frozen=True, forbid_unknown_fields=True):
    """How often an estimate is given out; 0 means after every frame that was fused."""

    rate_hz: Rate = 10.0


class Settings(Struct, frozen=True, forbid_unknown_fields=True):
    """Everything a run needs, validated; `path` is the file it came from."""

    path: Path
    vehicle: Vehicle
    can: tuple[CanBus, ...]
    signals: Signals
    estimator: EstimatorSettings = EstimatorSettings()
    alarms: AlarmSettings = AlarmSettings()
    wear: WearSettings = WearSettings()
    zenoh: ZenohSettings = ZenohSettings()
    metrics: MetricsSettings = MetricsSettings()
    output: OutputSettings = OutputSettings()
    store: StoreSettings = StoreSettings()

    @property
    def calibration(self) -> int:
        """A checksum of the settings that scale the estimated friction: only values under the same one compare."""
        mapped = (*self.signals.pressing_force, *self.signals.load_force)
        forces = [(own.message, own.signal, own.unit, own.scale, own.offset, own.min, own.max) for own in mapped]
        mass_kg = None if self.signals.load_force else self.vehicle.mass_kg
        return crc32(repr((mass_kg, self.vehicle.brake_radius_m, forces)).encode())

    @property
    def brake_forces(self) -> tuple[float, ...]:
        """The pressing force of each wheelset over the mean of all, by design, when all brakes are applied alike.

        More discs, larger cylinders and other leverages are in `scale`, newtons per bar. All are 1 where these differ
        by more than brakes do: then one signal is in bar and another in kPa. Signals that tell forces themselves have
        the same `scale` whatever the brakes' sizes: there the vehicle has to tell them.
        """
        forces_n = list(self.vehicle.full_pressing_force_n)
        if not forces_n:
            pressed = self.signals.pressing_force
            forces_n = [abs(own.scale) * si_factor("pressing_force", own.unit, 1.0) for own in pressed]
            if max(forces_n) > LARGEST_BRAKE_RATIO * min(forces_n):
                return (1.0,) * len(forces_n)
        return tuple(force_n * len(forces_n) / sum(forces_n) for force_n in forces_n)
