"""What the state vector x consists of: (13) with some more."""

from dataclasses import dataclass, field


@dataclass(frozen=True)
class StateLayout:
    """Where each state lives in x = [omega_1..N, v, mu_b,1..N, mu_w,1..N, d, E, B, C_1..3, L]: (13) with some more."""

    wheelset_count: int
    size: int = field(init=False, compare=False)
    omega: slice = field(init=False, compare=False)  # wheelset angular speeds, rad/s
    speed: int = field(init=False, compare=False)  # vehicle speed v, m/s
    friction: slice = field(init=False, compare=False)  # pad-disc friction mu_b,i
    adhesion: slice = field(init=False, compare=False)  # utilised wheel-rail adhesion mu_w,i = F_x,i / F_z,i
    deceleration: int = field(init=False, compare=False)  # unmodelled longitudinal deceleration d, m/s²
    force_effect: int = field(init=False, compare=False)  # E, by which mu_b changes with the braking ratio q
    decay: int = field(init=False, compare=False)  # B, by which mu_w of a sliding wheelset falls with slip speed, s/m
    uptake: slice = field(init=False, compare=False)  # C_k, of a changing brake torque what the rail takes up at a slip
    creep: slice = field(init=False, compare=False)  # E, B and C_k: what slides teach
    lag: int = field(init=False, compare=False)  # L, by which readings of v come late, s; below 0, pressing forces
    kinematic: slice = field(init=False, compare=False)  # omega and v together: what is measured (15)

    def __post_init__(self) -> None:
        n = self.wheelset_count
        for name, place in {
            "omega": slice(0, n),
            "speed": n,
            "friction": slice(n + 1, 2 * n + 1),
            "adhesion": slice(2 * n + 1, 3 * n + 1),
            "deceleration": 3 * n + 1,
            "force_effect": 3 * n + 2,
            "decay": 3 * n + 3,
            "uptake": slice(3 * n + 4, 3 * n + 7),
            "creep": slice(3 * n + 2, 3 * n + 7),
            "lag": 3 * n + 7,
            "kinematic": slice(0, n + 1),
            "size": 3 * n + 8,
        }.items():
            object.__setattr__(self, name, place)
