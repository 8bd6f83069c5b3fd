"""What a wheelset may be doing."""

from enum import StrEnum


class WheelState(StrEnum):
    """What a wheelset does."""

    ROLLING = "rolling"
    SLIDING = "sliding"  # the brake asks for more than the rail gives
    PROTECTED = "protected"  # slides time and again, and a wheel-slide protection keeps it from sliding far
    STOPPED = "stopped"  # does not rotate, and is believed
    BLOCKED = "blocked"  # likewise, though its brake says released: the pads stick, or a hand brake is on
    DOUBTFUL = "doubtful"  # does not seem to rotate; what it is cannot be told yet
    CONTRADICTED = "contradicted"  # its sensor says what cannot be, and is not believed
    UNKNOWN = "unknown"  # not measured


UNTOLD = frozenset({WheelState.UNKNOWN, WheelState.CONTRADICTED})  # nothing is known of such a wheelset
