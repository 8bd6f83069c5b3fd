"""How a daemon does, for those that show it."""

from brake_monitor.publishing.health import Intake

INTAKE = Intake(
    newest_reading_s=1000.0,
    frames=1000,
    mapped_frames=900,
    decode_errors=3,
    lost_frames=2,
    dropped_frames=0,
    stale_signals=("GNSS.v lost",),
    buses_down=("socketcan:can0",),
    bus_failures=1,
    frames_waiting=7,
    late_samples=9,
    outliers=11,
    filter_resets=4,
    memory_failure="",
)
