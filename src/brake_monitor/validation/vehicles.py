"""The vehicles of the campaign: the example wagons with their CAN sensors, and the rig with the paper's own."""

from pathlib import Path

from msgspec.structs import replace

from brake_monitor.settings.config import OutputSettings, Settings
from brake_monitor.settings.example_vehicles import example_settings

WHEELSETS = {"single": 1, "wagon": 2, "bogie": 4, "laboratory": 1}
PAPER_OMEGA_STD_RADPS = 3.2e-5  # square root of R_11 in (20)
PAPER_SPEED_STD_MPS = 3.2e-4  # square root of R_22


def campaign_settings(vehicle: str) -> Settings:
    """Settings of one of WHEELSETS, giving an estimate for every fused frame.

    The load-weighing signal is left out throughout: a mass that is configured wrongly then really is wrong.
    """
    match vehicle:
        case "single":
            settings = _single()
        case "laboratory":
            settings = _laboratory()
        case _:
            settings = example_settings(vehicle)
    signals = replace(settings.signals, load_force=())
    return replace(settings, signals=signals, output=OutputSettings(rate_hz=0.0))


def _single() -> Settings:
    """The rig's wheelset on the two-axle wagon's bus: one wheelset with a wagon's sensors."""
    wagon, rig = (example_settings(name) for name in ("wagon", "rig"))
    signals = wagon.signals
    first = {name: getattr(signals, name)[:1] for name in ("axle_speed", "pressing_force", "wsp_active")}
    return replace(wagon, vehicle=rig.vehicle, signals=replace(signals, **first))


def _laboratory() -> Settings:
    """The rig with the noise that its R in (20) states and no other: every 10 ms, in steps too fine to matter."""
    rig = example_settings("rig")
    bus = replace(rig.can[0], dbc=(Path(__file__).with_name("laboratory.dbc"),))
    axle_speed = tuple(replace(mapping, noise_std=PAPER_OMEGA_STD_RADPS) for mapping in rig.signals.axle_speed)
    speed = replace(rig.signals.speed, noise_std=PAPER_SPEED_STD_MPS)
    return replace(rig, can=(bus,), signals=replace(rig.signals, axle_speed=axle_speed, speed=speed))
