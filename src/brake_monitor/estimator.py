"""Samples → Estimate: time, observability and presets around the filter."""

from enum import StrEnum

from msgspec import Struct


class Status(StrEnum):
    """How far an estimate may be trusted."""

    VALID = "valid"
    HELD = "held"  # not observable now; the last value is kept and its uncertainty grows
    CONVERGING = "converging"
    INVALID = "invalid"


class WheelsetEstimate(Struct, frozen=True):
    """What is known of one wheelset and its brake unit at one instant."""

    omega_radps: float
    slip: float  # (v - omega r_W) / v, dimensionless; 0 near standstill
    friction: float  # pad-disc friction coefficient mu_b,i
    friction_std: float
    friction_status: Status
    adhesion: float  # the wheelset's own F_x / F_z
    adhesion_std: float
    pressing_force_n: float
    wsp_active: bool


class Estimate(Struct, frozen=True):
    """What is known of the wagon at one instant, after the frame captured then was fused."""

    time_s: float
    speed_mps: float
    adhesion: float  # utilised wheel-rail adhesion mu_w = F_x / F_z of the wagon
    adhesion_std: float
    saturated: bool  # the wheels were asked for as much as the rail gave: adhesion is the available one
    deceleration_mps2: float  # d, the unmodelled longitudinal deceleration
    deceleration_std_mps2: float
    wheelsets: tuple[WheelsetEstimate, ...]
    status: Status
    reasons: tuple[str, ...]  # why the status is not valid, empty otherwise
    nis: float  # normalised innovation squared of the last fused sample
    reset_count: int
