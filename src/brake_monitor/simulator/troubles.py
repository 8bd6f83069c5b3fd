"""Drives on which something is wrong: one for each condition that an alarm tells of, and for each sensor that fails."""

from dataclasses import dataclass

from msgspec.structs import replace

from brake_monitor.settings.config import Preset, Settings
from brake_monitor.simulator.brake_faults import BrakeFault
from brake_monitor.simulator.journey import Act, Leg, LegJourney
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.scenarios import DRY, Profile, Scenario, steps
from brake_monitor.simulator.sensor_faults import BusFailure, BusFault, SensorFailure, SensorFault

FIRST_S, SECOND_S, STOP_S = 10.0, 60.0, 110.0  # the brakings of most drives
AIR_LOST_S = 20.0
NEARLY_WORN_MM = 0.004  # above the limit; less than what one stop takes


@dataclass(frozen=True, slots=True)
class Trouble:
    """A drive, what goes wrong on it, and how many wheelsets it takes to notice."""

    scenario: Scenario
    modifiers: Modifiers
    least_wheelsets: int = 1
    pad_above_limit_mm: float | None = None  # thickness at the beginning; as configured where not given
    preset: Preset | None = None  # of the estimator; as configured where not given

    @property
    def name(self) -> str:
        """The scenario's."""
        return self.scenario.name

    def settings(self, settings: Settings) -> Settings:
        """The vehicle's settings, with the pads that it begins with and the preset that it is watched with."""
        wear, estimator = settings.wear, settings.estimator
        if self.pad_above_limit_mm is not None:
            wear = replace(wear, new_pad_thickness_mm=wear.pad_limit_mm + self.pad_above_limit_mm)
        if self.preset is not None:
            estimator = replace(estimator, preset=self.preset)
        return replace(settings, wear=wear, estimator=estimator)


def _brakings(name: str, summary: str) -> Scenario:
    """Two brakings and a stop on dry rail."""
    demand = steps((FIRST_S, 0.5), (18.0, 0.0), (SECOND_S, 0.6), (68.0, 0.0), (STOP_S, 0.8))
    return Scenario(name, summary, 33.0, 200.0, demand, DRY)


def _long_braking(name: str, summary: str) -> Scenario:
    """A light braking of half a minute and a stop on dry rail."""
    return Scenario(name, summary, 33.0, 160.0, steps((FIRST_S, 0.4), (AIR_LOST_S + 20.0, 0.0), (80.0, 0.8)), DRY)


def _slippery(name: str, summary: str, level: float, until_s: float) -> Scenario:
    """A long braking on a slippery rail, released before the end."""
    rail = Profile(((FIRST_S - 2.0, 0.3), (FIRST_S, level), (until_s, level), (until_s + 3.0, 0.3)))
    return Scenario(name, summary, 28.0, 110.0, steps((FIRST_S, 0.8), (50.0, 0.0)), rail)


def _descent(name: str, summary: str, demand: float) -> Scenario:
    """A quarter of an hour downhill, the speed held by the brake, and a stop."""
    legs = (Leg(Act.HOLD, 20.0, lasts_s=1000.0, demand=demand), Leg(Act.STAND, lasts_s=20.0, demand=1.0))
    return Scenario(name, summary, 20.0, 1080.0, LegJourney(legs, 30e3), DRY)


def _stops(name: str, summary: str, count: int) -> Scenario:
    """So many stops, a minute apart."""
    legs = (
        Leg(Act.PULL, 15.0, pull_mps2=0.5),
        Leg(Act.COAST, lasts_s=6.0),
        Leg(Act.STAND, lasts_s=6.0, demand=0.8),
    ) * count
    return Scenario(name, summary, 15.0, 75.0 * count, LegJourney(legs, 1000.0 * count), DRY)


def _brake(scenario: Scenario, *faults: BrakeFault) -> Trouble:
    """Faults of single brakes show beside as many sound ones."""
    return Trouble(scenario, Modifiers(brake_faults=faults), least_wheelsets=2 * len(faults))


def _pads(scenario: Scenario, *friction: tuple[float, float]) -> Trouble:
    """All pads have this share of the usual friction, by time."""
    return Trouble(scenario, Modifiers(brake_faults=(BrakeFault(friction=Profile(friction)),)))


def _sensor(
    name: str, summary: str, quantity: str, failure: SensorFailure, from_s: float = 30.0, *, value: float = 0.0
) -> Trouble:
    fault = SensorFault(quantity, 0, failure, from_s, value=value)
    return Trouble(_brakings(name, summary), Modifiers(sensor_faults=(fault,)))


def _bus(name: str, summary: str, failure: BusFailure, lasts_s: float) -> Trouble:
    return Trouble(_brakings(name, summary), Modifiers(bus_faults=(BusFault(failure, 30.0, 30.0 + lasts_s),)))


_LOST, _CODE, _FROZEN, _STUCK, _BIASED = SensorFailure

TROUBLES = {
    trouble.name: trouble
    for trouble in (
        Trouble(
            _slippery(
                "locked", "goods wagon without WSP: the wheels lock on slippery rail and are dragged", 0.04, 45.0
            ),
            Modifiers(slide_protection=False),
        ),
        Trouble(
            _slippery("dragged", "likewise, and pads that stick: after the release one is still dragged", 0.03, 80.0),
            Modifiers(slide_protection=False, brake_faults=(BrakeFault(0, stuck_force_n=25e3),)),
            least_wheelsets=2,
        ),
        Trouble(_slippery("long-slide", "WSP on slippery rail for forty seconds: flats", 0.05, 60.0), Modifiers()),
        _brake(_brakings("residual", "one cylinder keeps 0.6 bar after each release"), BrakeFault(0, residual_bar=0.6)),
        _brake(
            _brakings("stuck", "one wheelset's pads stick with 9 kN after each release; its pressure says released"),
            BrakeFault(0, stuck_force_n=9e3),
        ),
        _brake(_brakings("unapplied", "one cylinder is isolated: it never fills"), BrakeFault(0, isolated=True)),
        _brake(
            _brakings("residual-bogie", "two of four cylinders keep 1.2 bar after each release"),
            BrakeFault(0, residual_bar=1.2),
            BrakeFault(1, residual_bar=1.2),
        ),
        _brake(
            _brakings("unapplied-bogie", "two of four cylinders are isolated: they never fill"),
            BrakeFault(0, isolated=True),
            BrakeFault(1, isolated=True),
        ),
        _brake(
            _long_braking("air-lost", "one cylinder loses its air in mid-application and never fills again"),
            BrakeFault(0, from_s=AIR_LOST_S, isolated=True),
        ),
        _brake(_brakings("uneven", "one wheelset's rigging passes on 55 % of the force"), BrakeFault(0, rigging=0.55)),
        _pads(_brakings("weak-pads", "pads with two thirds of the usual friction"), (0.0, 0.66)),
        _pads(
            _stops("weak-pads-stops", "pads 38 % below the usual friction over six stops to standstill", 6), (0.0, 0.62)
        ),
        _pads(_brakings("grabbing-pads", "pads with one and a third times the usual friction"), (0.0, 1.33)),
        _pads(_stops("drift", "friction falls by 30 % over 24 stops", 24), (0.0, 1.1), (1700.0, 0.8)),
        Trouble(
            _descent("hot", "a quarter of an hour of 34 per mille downhill: hot discs", 0.7), Modifiers(gradient=-0.034)
        ),
        Trouble(
            _descent("fading", "a quarter of an hour of 40 per mille downhill: the pads fade", 0.9),
            Modifiers(gradient=-0.040),
        ),
        Trouble(
            _descent("hot-in-train", "the same 34 per mille downhill, watched with preset `train`", 0.7),
            Modifiers(gradient=-0.034),
            least_wheelsets=2,  # one wheelset is no wagon in a train
            preset="train",
        ),
        Trouble(
            _brakings("worn", "pads 3 mm above their limit: they come near it"),
            Modifiers(),
            pad_above_limit_mm=3.0 + NEARLY_WORN_MM,
        ),
        Trouble(
            _brakings("worn-out", "pads that reach their limit at the stop"),
            Modifiers(),
            pad_above_limit_mm=NEARLY_WORN_MM,
        ),
        _sensor("lost-speed", "the vehicle speed's message is lost", "speed", _LOST),
        _sensor("lost-wheel-speeds", "the wheel speeds' message is lost", "axle_speed", _LOST),
        _sensor("lost-pressures", "the pressures' message is lost", "pressing_force", _LOST),
        _sensor(
            "lost-pressures-braking", "the pressures' message is lost while braking", "pressing_force", _LOST, 48.0
        ),
        _sensor("speed-error", "the vehicle speed says that it has no value", "speed", _CODE),
        _sensor("wheel-speed-error", "a wheel speed says that it has no value", "axle_speed", _CODE),
        _sensor("pressure-error", "a pressure says that it has no value", "pressing_force", _CODE),
        _sensor("frozen-speed", "the vehicle speed freezes", "speed", _FROZEN),
        _sensor("frozen-wheel-speed", "a wheel speed freezes", "axle_speed", _FROZEN),
        _sensor("frozen-pressure", "a pressure freezes while braking", "pressing_force", _FROZEN, 64.0),
        _sensor("impossible-speed", "the vehicle speed says 500 km/h", "speed", _STUCK, value=138.9),
        _sensor("impossible-wheel-speed", "a wheel speed says 390 km/h", "axle_speed", _STUCK, value=240.0),
        _sensor("dead-wheel-speed", "a wheel speed sensor says 0 at full speed", "axle_speed", _STUCK),
        _sensor("dead-wheel-speed-braking", "a wheel speed sensor says 0 while braking", "axle_speed", _STUCK, 63.0),
        _sensor("pressure-0", "a pressure says 0 throughout", "pressing_force", _STUCK, 0.0),
        _sensor("pressure-stuck", "a pressure says 30 kN throughout", "pressing_force", _STUCK, value=30e3),
        _sensor("wsp-stuck", "a WSP flag stays set", "wsp_active", _STUCK, value=1.0),
        _sensor("biased-wheel-speed", "a wheel speed says 1 rad/s too much", "axle_speed", _BIASED, 0.0, value=1.0),
        _bus("silent", "nothing comes for 8 s", BusFailure.SILENT, 8.0),
        _bus(
            "error-frames",
            "a bad contact for 20 s: error frames, half of the frames lost",
            BusFailure.ERROR_FRAMES,
            20.0,
        ),
        _bus("bus-off", "the controller is off the bus for 10 s", BusFailure.OFF, 10.0),
    )
}
