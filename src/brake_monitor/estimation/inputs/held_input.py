"""A known input (pressing force, torque) between its samples."""

from math import exp, sqrt

PROMPT_S = 0.03  # a valve and its cylinder take this long: samples no further apart miss no change
VENTING_S = 0.1  # time constant of a cylinder whose valve opens
LATELY_S = 2.0  # a force that was there within it may be there again at once
LEAST_GAP_S = 0.001  # samples in frames that a gateway bunches are not as close as their times
SPACING_SHARE = 0.1  # of the newest sample in the mean spacing


class HeldInput:
    """Holds the last sample, and makes up for what holding got wrong as soon as the next sample tells.

    A force that falls by 40 kN in 50 ms is held too high until its next sample. What the filter integrates is
    the impulse ∫F dt, so the trapezoid between two samples is added and what was already used taken off: the
    difference goes into the next step, without latency and without a lasting error in the wheel's speed.
    """

    def __init__(self) -> None:
        self.value = 0.0
        self.most_lately = 0.0  # the largest sample of the last two seconds, fading
        self._sampled_s = 0.0  # time of the last sample
        self._used_s = 0.0  # time up to which the impulse has been used
        self._impulse = 0.0  # ∫ value dt up to the last sample, less what has been used
        self._spacing_s = 0.0  # mean time between samples
        self._slope = 0.0  # between the last two samples, per second
        self._made_up = 0.0  # impulse by which holding was wrong, made up for in the next step

    def sample(self, time_s: float, value: float, longest_gap_s: float) -> None:
        """Take a sample; across a gap nothing is known of the time between, so nothing is made up for."""
        before, gap_s = self.value, time_s - self._sampled_s
        if 0.0 < gap_s <= longest_gap_s:
            self._impulse += 0.5 * (before + value) * gap_s
            self._made_up += 0.5 * (value - before) * gap_s
            self._slope = (value - before) / max(gap_s, LEAST_GAP_S)
            self._spacing_s += SPACING_SHARE * (gap_s - self._spacing_s)
        elif gap_s != 0.0:
            self._impulse = value * (time_s - self._used_s)
            self._made_up = self._slope = 0.0
        passed_s = gap_s if gap_s > 0.0 else 0.0  # the clock may have been set back
        lately = self.most_lately * (1.0 - passed_s / LATELY_S) if passed_s < LATELY_S else 0.0
        self.most_lately = lately if lately > value else value
        self._sampled_s = time_s
        self.value = value

    @property
    def is_prompt(self) -> bool:
        """Whether samples come so often that no change passes between two of them."""
        return self._spacing_s <= PROMPT_S

    def use_until(self, time_s: float, dt_s: float) -> float:
        """Use the input up to time_s, for a step of dt_s; its mean over the step."""
        total = self._impulse + self.value * (time_s - self._sampled_s)
        self._impulse -= total
        self._used_s = time_s
        self._made_up = 0.0
        return total / dt_s

    def impulse_std_until(self, time_s: float) -> float:
        """How far the impulse of the step that ends at time_s may be off; to be asked before `use_until`.

        What holding got wrong before comes into this step, and if the input goes on as it last went, holding it
        since the last sample is wrong by half the slope times the square of its age.
        """
        if self._made_up == 0.0 == self._slope:  # as it is in a brake that is released
            return 0.0
        age_s = time_s - self._sampled_s
        held = 0.5 * self._slope * age_s * age_s
        return sqrt(self._made_up * self._made_up + held * held)

    def unseen_std_until(self, time_s: float) -> float:
        """How far the impulse may be off at time_s by what a valve may have done since the last sample.

        At worst it has vented the brake, or filled it again, right after the last sample.
        """
        unseen_s = time_s - self._sampled_s - PROMPT_S
        if unseen_s <= 0.0:
            return 0.0
        return self.most_lately * (unseen_s - VENTING_S * (1.0 - exp(-unseen_s / VENTING_S)))

    def restart(self, time_s: float) -> None:
        """Forget what is to be made up for; the next step begins at time_s with the last value."""
        self._sampled_s = self._used_s = time_s
        self._impulse = self._made_up = self._slope = 0.0
