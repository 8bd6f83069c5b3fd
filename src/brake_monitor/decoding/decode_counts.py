"""What became of the frames and of the mapped signals in them."""

from dataclasses import dataclass

import numpy as np

from brake_monitor.arrays import Ints, indices
from brake_monitor.samples import Quality


@dataclass(slots=True)
class DecodeCounts:
    """For `check`, health and the summary of a replay."""

    frames: int = 0
    mapped: int = 0  # frames of a message that is mapped
    unmapped: int = 0
    error_frames: int = 0
    remote_frames: int = 0
    short_frames: int = 0  # mapped, but too short for a mapped signal
    other_width: int = 0  # unmapped, but a mapped message has this number with the other identifier width (11, 29 bits)
    unknown_multiplexer: int = 0  # on a page that the DBC does not describe
    good: int = 0  # samples, from here on
    out_of_range: int = 0
    not_available: int = 0
    bad_counter: int = 0
    stale: int = 0
    lost_frames: int = 0  # by the rolling counters

    @property
    def errors(self) -> int:
        """Frames and samples that could not be used."""
        broken_frames = self.short_frames + self.unknown_multiplexer + self.error_frames
        return broken_frames + self.out_of_range + self.bad_counter

    def take(self, quality: Quality, times: int = 1) -> None:
        """Count samples of one quality; each quality has a count of its name."""
        name = quality.name.lower()
        setattr(self, name, getattr(self, name) + times)

    def take_all(self, qualities: Ints) -> None:
        """Count samples by their qualities, in an array of any shape."""
        for quality, times in enumerate(np.bincount(indices(qualities.ravel())).tolist()):
            self.take(Quality(quality), times)
