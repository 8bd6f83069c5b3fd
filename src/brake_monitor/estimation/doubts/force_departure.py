"""How far a pad has gone from the pressing force at which its friction was learned: it may rub differently there."""

CONTACT_S = 1.5  # contact patches grow and decay within as long: friction follows the force with this lag (Ostermeyer)
RELATIVE_STD = 0.05  # of friction between full force and none; organic pads lose up to a tenth as the force rises


class ForceDeparture:
    """Follows the pressing force, and the force at which friction was learned; there a large one counts for more.

    Wheel-slide protection that vents the brake takes the force away faster than friction can be learned, for seconds:
    the friction that is known then is that at the force before.
    """

    def __init__(self) -> None:
        self._lately_n = 0.0
        self._learned_n = 0.0

    def see(self, step_s: float, pressing_force_n: float, observable: float) -> None:
        """Take the mean force over a step; `observable` is 1 where friction was, else 0."""
        share = step_s / CONTACT_S
        self._lately_n += share * (pressing_force_n - self._lately_n)
        if observable > 0.0 and pressing_force_n > 0.0:
            weight = pressing_force_n / max(pressing_force_n, self._learned_n)
            self._learned_n += share * weight * weight * (pressing_force_n - self._learned_n)

    @property
    def relative_std(self) -> float:
        """The standard deviation of friction at the force of now from that learned, relative to friction."""
        largest_n = max(self._lately_n, self._learned_n)
        return RELATIVE_STD * abs(self._lately_n - self._learned_n) / largest_n if largest_n > 0.0 else 0.0
