"""What brakes and wheels have done since the start: energy, rubbing, sliding, distance.

The totals only grow, but for small corrections of a pressing force that was held too high between two samples.
"""

from msgspec import Struct

CRAWLING_MPS = 0.3  # what is slower may be noise; a wagon of 36 t has 1.6 kJ left then, a ten-thousandth of a stop
SLIDING_SLIP = 0.05  # slide protection acts from here on (5-25 %)


class WheelsetWork(Struct):
    """Totals of one wheelset since the start."""

    pad_energy_j: float = 0.0  # ∫ mu_b F r_B |omega| dt, what its pads and discs turned into heat
    force_travel_nm: float = 0.0  # ∫ F r_B |omega| dt, the F s of Archard's law
    sliding_distance_m: float = 0.0  # way its wheels went across the rail while slip was above 5 %
    wsp_actions: int = 0  # how often its wheel-slide protection let its brake go

    def rub(self, force_travel_nm: float, friction: float) -> None:
        """Add what the pads did within a step."""
        self.force_travel_nm += force_travel_nm
        self.pad_energy_j += friction * force_travel_nm

    def slide(self, slip: float, distance_m: float) -> None:
        """Add what the wheels did while they slid and the wagon went `distance_m`."""
        self.sliding_distance_m += slip * distance_m
