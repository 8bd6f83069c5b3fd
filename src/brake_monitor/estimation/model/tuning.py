"""The presets: how fast each state may wander, and how far the sensors are trusted.

Spectral densities are continuous, so that they do not depend on the sampling: a state with density q drifts by
sqrt(q t) in t seconds. `rig` is the paper's (20), whose covariances belong to one step of 10 ms.
"""

from collections.abc import Mapping
from math import inf

from msgspec import Struct
from msgspec.structs import asdict, replace

from brake_monitor.settings.config import EstimatorSettings, Preset


class Tuning(Struct, frozen=True, kw_only=True):
    """Spectral densities per second, initial standard deviations, and the paper's fixed R where it applies.

    0 is for what a preset's model does not have.
    """

    omega: float  # (rad/s)²/s, what the wheel equation leaves out
    speed: float  # (m/s)²/s, what the speed equation leaves out beside d
    friction: float  # 1/s, common to all brake units (weather, speed, heat)
    friction_own: float = 0.0  # 1/s, each brake unit by itself
    adhesion: float  # 1/s, common to all wheelsets
    adhesion_own: float = 0.0  # 1/s, each wheelset by itself while it rolls
    adhesion_sliding: float = 0.0  # 1/s, each wheelset by itself while it slides
    deceleration: float = 0.0  # (m/s²)²/s while no brake is applied
    deceleration_braking: float = 0.0  # (m/s²)²/s while braking ...
    deceleration_sliding: float = 0.0  # ... and a wheelset slides, or did lately
    deceleration_per_metre: float = 0.0  # (m/s²)²/m, whether it brakes or not: the gradient changes as the wagon runs
    deceleration_doubted: float = 0.0  # (m/s²)²/s more while the speed contradicts the forces: as gradients change
    friction_doubted: float = 0.0  # 1/s meanwhile, with d and mu_w: what friction learned may be the gradient's
    deceleration_onset_std: float = 0.0  # m/s², by how much d may jump as a brake application begins
    friction_own_std: float = 0.0  # how far one brake unit's friction lies from the others' at first: 3 %
    adhesion_std: float
    deceleration_std: float = 0.0  # m/s²
    converged_adhesion_std: float  # below it an estimate is `valid`
    converged_friction_std: float
    adhesion_decay: float = 0.0  # (s/m)²/s of adhesion with slip speed, while wheelsets slide
    adhesion_decay_std: float = 0.0  # s/m
    uptake: float = 0.0  # 1/s, of the shares C_k of a changing brake torque that the rail takes up, in slides
    uptake_std: float = 0.0  # ... at first, about:
    first_uptake: tuple[float, float, float]  # before any slide
    force_effect_std: float = 0.0  # of E, see `wagon`
    speed_lag_std: float = 0.0  # s, by how much readings of the vehicle's speed may come late, or the forces
    torque_error_std: float  # of K
    literal: bool = False  # covariance added per step as printed in (20), without the coupled terms
    omega_variance: float = 0.0  # R_11 of (20) in (rad/s)², instead of the sensor's own
    speed_variance: float = 0.0  # R_22 of (20) in (m/s)²


# The spectral densities that `tune` fits; a recording tells little of the others.
FITTED_DENSITIES = (
    "omega",
    "speed",
    "friction",
    "friction_own",
    "adhesion",
    "adhesion_own",
    "adhesion_sliding",
    "deceleration",
    "deceleration_braking",
    "deceleration_sliding",
    "deceleration_per_metre",
)

PAPER_STEP_S = 0.01

WAGON = Tuning(
    omega=2e-4,
    speed=1e-6,
    friction=7e-6,
    friction_own=5e-7,
    adhesion=5e-6,
    adhesion_own=3e-6,
    adhesion_sliding=1e-4,
    deceleration=2.5e-5,
    deceleration_braking=1e-6,
    deceleration_sliding=1e-6,
    deceleration_per_metre=1e-6,
    deceleration_doubted=0.05,
    friction_doubted=1e-2,
    friction_own_std=0.011,
    adhesion_std=0.05,
    deceleration_std=0.1,  # about a 10 per mille gradient
    converged_adhesion_std=0.02,
    converged_friction_std=0.045,
    adhesion_decay=1e-4,
    adhesion_decay_std=0.15,  # Polach (2005): 0.1 to 0.4 at first, less the faster a wheelset slips
    uptake=0.005,
    uptake_std=0.3,
    first_uptake=(0.8, 0.35, 0.0),  # most creep curves peak at 2 to 6 %
    force_effect_std=0.05,  # with q of 0.25, full braking, organic pads rub 5 to 10 % less than with none
    speed_lag_std=0.09,
    torque_error_std=0.05,  # drives estimate their torque, mostly without a sensor, to a few per cent
)

TRAIN = replace(  # what differs there
    WAGON,
    friction=5e-6,
    adhesion_sliding=2e-3,
    deceleration=3e-2,
    deceleration_braking=2e-1,
    deceleration_sliding=2.0,  # the train takes up what slide protection does to the own brakes, at once
    deceleration_per_metre=0.0,
    friction_doubted=0.0,
    deceleration_onset_std=0.5,
    first_uptake=(0.1, 0.0, 0.0),  # as past the peak: in a train slides tell so little of C_k that they stay at that
    force_effect_std=0.0,
    speed_lag_std=0.07,
)

RIG = Tuning(  # (19), which has no d, and no adhesion that decays or is taken up in shares
    omega=1e1 / PAPER_STEP_S,  # Q_11
    speed=1e-5 / PAPER_STEP_S,  # Q_22
    friction=1e-3 / PAPER_STEP_S,  # Q_33
    adhesion=1e-1 / PAPER_STEP_S,  # Q_44
    adhesion_std=0.05,
    converged_adhesion_std=inf,  # the paper's covariances say nothing about the error
    converged_friction_std=inf,
    first_uptake=WAGON.first_uptake,
    torque_error_std=0.05,  # K is no state
    literal=True,
    omega_variance=1e-9,  # R_11
    speed_variance=1e-7,  # R_22
)

PRESETS: Mapping[Preset, Tuning] = {"wagon": WAGON, "train": TRAIN, "rig": RIG}


def resolve(settings: EstimatorSettings) -> Tuning:
    """The preset with what the configuration overrides in it."""
    given = {name: value for name, value in asdict(settings.tuning).items() if value is not None}
    return replace(PRESETS[settings.preset], **given)
