"""What the state vector x consists of: (13) with some more."""


class StateLayout:
    """Where each state lives in x = [omega_1..N, v, mu_b,1..N, mu_w,1..N, d, E, B, C_1..3, L, K]: (13) with some more.

    K is there where motors' torques are. Two of as many wheelsets, both with or without K, are equal.
    """

    def __init__(self, wheelset_count: int, *, has_motors: bool = False) -> None:
        n = self.wheelset_count = wheelset_count
        self.omega = slice(0, n)  # wheelset angular speeds, rad/s
        self.speed = n  # vehicle speed v, m/s
        self.kinematic = slice(0, n + 1)  # omega and v together: what is measured (15)
        self.friction = slice(n + 1, 2 * n + 1)  # pad-disc friction mu_b,i
        self.adhesion = slice(2 * n + 1, 3 * n + 1)  # utilised wheel-rail adhesion mu_w,i = F_x,i / F_z,i
        self.deceleration = 3 * n + 1  # unmodelled longitudinal deceleration d, m/s²
        self.force_effect = 3 * n + 2  # E, by which mu_b changes with the braking ratio q
        self.decay = 3 * n + 3  # B, by which mu_w of a sliding wheelset falls with slip speed, s/m
        self.uptake = slice(3 * n + 4, 3 * n + 7)  # C_k, of a changing brake torque what the rail takes up at a slip
        self.creep = slice(3 * n + 2, 3 * n + 7)  # E, B and C_k: what slides teach
        self.lag = 3 * n + 7  # L, by which readings of v come late, s; below 0, pressing forces
        self.torque_error = slice(3 * n + 8, 3 * n + 8 + has_motors)  # K: motors give 1 + K times what is told
        self.size = self.torque_error.stop

    def __eq__(self, other: object) -> bool:
        return isinstance(other, StateLayout) and hash(other) == hash(self)

    def __hash__(self) -> int:
        return hash((self.wheelset_count, self.size))
