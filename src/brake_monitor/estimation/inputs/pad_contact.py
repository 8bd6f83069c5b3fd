"""Whether a brake pad presses on its disc, judged from the pressing force alone."""

RECOVERY_S = 0.1  # after re-contact the pad's force needs about this long to be what the cylinder says
RELEASE_FRACTION = 0.8  # hysteresis, so that a force at the threshold does not flicker


class PadContact:
    """Contact with hysteresis and a recovery delay; without contact mu_b,i is not observable (17)."""

    def __init__(self, contact_force_n: float) -> None:
        self._contact_force_n = contact_force_n
        self._release_force_n = contact_force_n * RELEASE_FRACTION
        self.pressed = False
        self.has_pressed = False  # since the brake application began
        self.is_idle = False  # the brake does nothing, as its force says: see `Estimator.know_idle`
        self._since_s = 0.0

    def see(self, time_s: float, pressing_force_n: float) -> bool:
        """Take a pressing force sample; whether the pad made or lost contact."""
        pressed = pressing_force_n >= (self._release_force_n if self.pressed else self._contact_force_n)
        if pressed == self.pressed:
            return False
        self.pressed = pressed
        self.has_pressed = True
        self._since_s = time_s
        return True

    def begin_application(self) -> None:
        """Begin another brake application."""
        self.has_pressed = self.pressed

    def restart(self, time_s: float) -> None:
        """Go on from this time, perhaps of a clock that was set back."""
        self._since_s = min(self._since_s, time_s)

    def is_settled(self, time_s: float) -> bool:
        """Whether the pad has pressed long enough for its friction to be estimated."""
        return self.pressed and time_s - self._since_s >= RECOVERY_S
