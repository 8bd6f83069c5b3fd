"""How the daemon is doing: what its parts count, put together once a second."""

from bisect import bisect_left
from collections.abc import Iterable
from pathlib import Path
from resource import RUSAGE_SELF, getpagesize, getrusage

from msgspec import Struct, field
from msgspec.structs import asdict

from brake_monitor.estimation.estimate import Status
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.publishing.about import VERSIONS
from brake_monitor.publishing.payloads import HealthMessage, quality_of
from brake_monitor.samples import InputCondition

LATENCY_BOUNDS_S = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
LONGEST_LATENCY_S = 600.0  # more than this means that the clock was set meanwhile, or is another one


class Counters(Struct):
    """What became of the outputs since the start, by the names in `HealthMessage`."""

    estimates_sent: int = 0
    estimates_replaced: int = 0
    events_sent: int = 0
    events_lost: int = 0
    queries_answered: int = 0
    queries_refused: int = 0
    publish_failures: int = 0
    latency_counts: list[int] = field(default_factory=lambda: [0] * (len(LATENCY_BOUNDS_S) + 1))
    latency_sum_s: float = 0.0

    def add_latency(self, latency_s: float) -> None:
        """Count an estimate by the time from its capture to its publication, if the clock can tell it."""
        if abs(latency_s) > LONGEST_LATENCY_S:
            return
        latency_s = max(latency_s, 0.0)
        self.latency_counts[bisect_left(LATENCY_BOUNDS_S, latency_s)] += 1
        self.latency_sum_s += latency_s


class Intake(Struct, frozen=True):
    """What the service and the pipeline count, by the names in `HealthMessage`."""

    newest_reading_s: float | None  # when the newest one was captured that the estimates contain
    frames: int
    mapped_frames: int
    decode_errors: int
    lost_frames: int
    dropped_frames: int
    stale_signals: tuple[str, ...]
    buses_down: tuple[str, ...]
    bus_failures: int
    frames_waiting: int
    late_samples: int
    outliers: int
    filter_resets: int
    memory_failure: str


def intake_of(
    pipeline: Pipeline,
    buses_down: tuple[str, ...] = (),
    bus_failures: int = 0,
    frames_waiting: int = 0,
    dropped_frames: int = 0,
) -> Intake:
    """What came in so far."""
    counts = pipeline.decoder.counts
    estimator = pipeline.estimator
    conditions = [(channel, estimator.input_condition(channel.measurand)) for channel in pipeline.decoder.channels]
    return Intake(
        newest_reading_s=pipeline.newest_reading_s,
        frames=counts.frames,
        mapped_frames=counts.mapped,
        decode_errors=counts.errors,
        lost_frames=counts.lost_frames,
        dropped_frames=dropped_frames,
        stale_signals=tuple(
            f"{channel.source} {condition}" for channel, condition in conditions if condition is not InputCondition.GOOD
        ),
        buses_down=buses_down,
        bus_failures=bus_failures,
        frames_waiting=frames_waiting,
        late_samples=estimator.late_count,
        outliers=estimator.outlier_count,
        filter_resets=estimator.reset_count,
        memory_failure=pipeline.memory_failure,
    )


def health_of(
    intake: Intake,
    counters: Counters,
    newest: tuple[float, Status] | None,
    *,
    events_waiting: int,
    open_alarms: Iterable[str] = (),
    uptime_s: float,
    sequence: int,
    now_s: float,
) -> HealthMessage:
    """The message; `newest` is the capture time and status of the newest estimate."""
    time_s, status = newest or (0.0, Status.INVALID)
    told = asdict(intake) | asdict(counters)
    newest_reading_s, latency_counts = told.pop("newest_reading_s"), told.pop("latency_counts")
    usage = getrusage(RUSAGE_SELF)
    return HealthMessage(
        time_s=time_s,
        data_age_s=None if newest_reading_s is None else max(now_s - newest_reading_s, 0.0),
        status=status,
        quality=quality_of(status),
        uptime_s=uptime_s,
        open_alarms=tuple(open_alarms),
        events_waiting=events_waiting,
        latency_bounds_s=LATENCY_BOUNDS_S,
        latency_counts=tuple(latency_counts),
        cpu_s=usage.ru_utime + usage.ru_stime,
        memory_bytes=_resident_bytes(),
        versions=VERSIONS,
        sequence=sequence,
        publish_time_s=now_s,
        **told,
    )


def _resident_bytes() -> int:
    """Physical memory of this process; 0 where /proc does not tell."""
    try:
        return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * getpagesize()
    except OSError:
        return 0
