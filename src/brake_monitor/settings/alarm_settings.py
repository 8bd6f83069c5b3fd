"""The [alarms] table of the configuration: one table per rule, named like the alarm's kind."""

from collections.abc import Iterator
from typing import Annotated, ClassVar

from msgspec import Meta, Struct

from brake_monitor.settings.bounds import (
    Deviation,
    DiscTemperature,
    Distance,
    Energy,
    Force,
    NonNegative,
    Positive,
    Speed,
    TimeOut,
    Wait,
)

APPLICATIONS_JUDGED = 30  # the rules look no further back than so many brake applications

Adhesion = Annotated[float, Meta(gt=0.0, le=1.0)]


class RuleSettings(Struct, frozen=True, forbid_unknown_fields=True):
    """What every rule has: how long its condition must last, and how long be gone."""

    rising: ClassVar[tuple[str, ...]] = ()  # settings of which none may be greater than the next

    enabled: bool = True
    debounce_s: Wait = 0.5  # the condition lasts this long before the alarm is raised
    clear_s: Wait = 2.0  # ... and is gone this long before it is cleared
    latched: bool = False  # once raised it stays until a person has acknowledged it, even if the condition is gone


class LowAdhesionRule(RuleSettings, frozen=True):
    """The rail gives less than it should, and the wheels have asked for more."""

    low: Adhesion = 0.10
    very_low: Adhesion = 0.05
    extremely_low: Adhesion = 0.02
    clear_margin: NonNegative = 0.02
    merge_gap_s: Wait = 3.0
    min_speed_mps: Speed = 1.39  # 5 km/h

    @property
    def levels(self) -> dict[str, float]:
        """Below which adhesion is called so, by the names of the settings; the lowest comes last."""
        return {"low": self.low, "very_low": self.very_low, "extremely_low": self.extremely_low}


def level_of(adhesion: float, levels: dict[str, float]) -> str:
    """The lowest of the levels that an adhesion is below; "normal" when it is below none."""
    return next((name for name, limit in reversed(levels.items()) if adhesion < limit), "normal")


class WheelsetNotRotatingRule(RuleSettings, frozen=True):
    """A wheelset stands while the wagon moves."""

    debounce_s: Wait = 1.0  # a wheel-slide protection may let a wheelset stand for some tenths of a second
    latched: bool = True
    min_speed_mps: Speed = 1.39  # 5 km/h


class SlideRule(RuleSettings, frozen=True):
    """A wheelset slides across the rail."""

    rising = ("min_distance_m", "flat_possible_m", "flat_likely_m")

    debounce_s: Wait = 0.0
    min_distance_m: Distance = 3.0  # way of its treads across the rail
    flat_possible_m: Distance = 10.0  # ... while it nearly stands
    flat_likely_m: Distance = 50.0


class InputLostRule(RuleSettings, frozen=True):
    """Nothing arrives any more of a mapped signal, or it is lost for moments again and again."""

    debounce_s: Wait = 1.0  # after the signal's own time-out
    losses_per_minute: Annotated[int, Meta(ge=1, le=1000)] = 15  # with a fifth of the frames lost there are up to four


class InputImplausibleRule(RuleSettings, frozen=True):
    """What arrives of a mapped signal cannot be used."""

    debounce_s: Wait = 1.0


class BusSilentRule(RuleSettings, frozen=True):
    """No frame comes from a CAN bus."""

    debounce_s: Wait = 0.0
    silent_s: TimeOut = 2.0


class BusFaultRule(RuleSettings, frozen=True):
    """A CAN bus carries error frames, or its controller or interface is off."""

    debounce_s: Wait = 0.0
    error_frames: Annotated[int, Meta(ge=1, le=100_000)] = 10  # within the window; a healthy bus has none in hours
    window_s: TimeOut = 5.0


class MemoryFailingRule(RuleSettings, frozen=True):
    """What is to outlive the daemon cannot be written."""

    debounce_s: Wait = 5.0  # a busy disk hesitates
    clear_s: Wait = 5.0


class DraggingBrakeRule(RuleSettings, frozen=True):
    """A brake presses that nobody asked to."""

    debounce_s: Wait = 10.0  # of one brake pressing while the others are released
    clear_s: Wait = 10.0
    latched: bool = True
    min_speed_mps: Speed = 2.0
    min_force_n: Force = 2000.0  # pressing force of a brake that should be released
    hidden_force_n: Force = 1200.0  # retarding force at the rail of a brake whose pressing force says released
    alone_s: TimeOut = 120.0  # a brake that presses while no other ever did is taken to drag only after as long


class BrakeNotAppliedRule(RuleSettings, frozen=True):
    """One brake does not press while the others do."""

    debounce_s: Wait = 3.0
    min_speed_mps: Speed = 2.0
    others_force_n: Force = 8000.0  # the others press at least this much
    wsp_wait_s: Wait = 5.0  # after its wheel-slide protection acted a brake needs time to fill


class UnevenBrakingRule(RuleSettings, frozen=True):
    """The brake torque of one wheelset stands apart from the others', per brake application."""

    rising = ("warning", "alarm")

    warning: Deviation = 0.20  # relative to the median of the others
    alarm: Deviation = 0.40
    clear_margin: NonNegative = 0.05
    min_energy_j: Energy = 100e3  # of the wheelset that brakes most, else the application says too little


class FrictionOutOfBandRule(RuleSettings, frozen=True):
    """Pad friction of a brake application, weighted by energy, too far from nominal."""

    rising = ("warning", "alarm")

    warning: Deviation = 0.15  # relative to [estimator] friction_nominal
    alarm: Deviation = 0.30
    clear_margin: NonNegative = 0.03
    min_energy_j: Energy = 100e3
    stops: Annotated[int, Meta(ge=1, le=APPLICATIONS_JUDGED)] = 20  # so many are weighed at most, while in doubt


class FrictionDriftRule(RuleSettings, frozen=True):
    """Pad friction rises or falls from brake application to brake application."""

    rising = ("min_stops", "stops")

    limit: Deviation = 0.15  # change over the stops looked at, relative to [estimator] friction_nominal
    clear_margin: NonNegative = 0.05
    stops: Annotated[int, Meta(ge=5, le=APPLICATIONS_JUDGED)] = 20  # how many are looked at ...
    min_stops: Annotated[int, Meta(ge=5, le=APPLICATIONS_JUDGED)] = 10  # ... and how few are enough
    min_energy_j: Energy = 100e3


class HotDiscRule(RuleSettings, frozen=True):
    """The discs of a wheelset are hotter than their pads bear."""

    rising = ("warning_c", "alarm_c")

    debounce_s: Wait = 2.0
    clear_s: Wait = 10.0
    warning_c: DiscTemperature = 400.0  # organic pads begin to fade
    alarm_c: DiscTemperature = 500.0
    clear_margin_k: NonNegative = 50.0


class PadNearLimitRule(RuleSettings, frozen=True):
    """The pads should be replaced at the next occasion."""

    margin_mm: Positive = 3.0  # above [wear] pad_limit_mm
    clear_margin_mm: NonNegative = 0.5


class PadAtLimitRule(RuleSettings, frozen=True):
    """The pads are worn down to their limit, [wear] pad_limit_mm."""

    latched: bool = True
    clear_margin_mm: NonNegative = 0.5


class AlarmSettings(Struct, frozen=True, forbid_unknown_fields=True):
    """One table per alarm rule."""

    low_adhesion: LowAdhesionRule = LowAdhesionRule()
    wheelset_not_rotating: WheelsetNotRotatingRule = WheelsetNotRotatingRule()
    slide: SlideRule = SlideRule()
    input_lost: InputLostRule = InputLostRule()
    input_implausible: InputImplausibleRule = InputImplausibleRule()
    bus_silent: BusSilentRule = BusSilentRule()
    bus_fault: BusFaultRule = BusFaultRule()
    memory_failing: MemoryFailingRule = MemoryFailingRule()
    dragging_brake: DraggingBrakeRule = DraggingBrakeRule()
    brake_not_applied: BrakeNotAppliedRule = BrakeNotAppliedRule()
    uneven_braking: UnevenBrakingRule = UnevenBrakingRule()
    friction_out_of_band: FrictionOutOfBandRule = FrictionOutOfBandRule()
    friction_drift: FrictionDriftRule = FrictionDriftRule()
    hot_disc: HotDiscRule = HotDiscRule()
    pad_near_limit: PadNearLimitRule = PadNearLimitRule()
    pad_at_limit: PadAtLimitRule = PadAtLimitRule()

    def rules(self) -> Iterator[tuple[str, RuleSettings]]:
        """Each table, by the kind of its alarm."""
        for kind in self.__struct_fields__:
            yield kind, getattr(self, kind)
