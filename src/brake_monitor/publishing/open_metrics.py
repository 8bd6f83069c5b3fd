"""Health as OpenMetrics over HTTP, for whatever scrapes this machine; on the loopback interface only."""

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from itertools import accumulate
from typing import TYPE_CHECKING, Any, TypeVar, get_type_hints

from brake_monitor.errors import WorkError
from brake_monitor.estimation.estimate import Status
from brake_monitor.host import extras
from brake_monitor.publishing.payloads import Counter, Gauge, HealthMessage

if TYPE_CHECKING:
    from socketserver import BaseRequestHandler

    from prometheus_client.metrics_core import Metric

HOST = "127.0.0.1"
ASKED_WITHIN_S = 5.0  # who has said less by then is not waited for
PREFIX = "brake_monitor_"

log = logging.getLogger(__name__)

T = TypeVar("T", Counter, Gauge)


@contextmanager
def open_metrics(port: int, latest: Callable[[], HealthMessage | None]) -> Iterator[None]:
    """Serve what `latest` gives until the end of the context.

    InputError without the extra `metrics`, WorkError when the port cannot be listened on.
    """
    extras.require("metrics", "[metrics] port")
    from prometheus_client import CollectorRegistry, start_http_server  # noqa: PLC0415 - an extra

    registry = CollectorRegistry()
    registry.register(_Collector(latest))
    try:
        server, thread = start_http_server(port, HOST, registry)
    except OSError as error:
        raise WorkError(f"[metrics] port {port}: {error.strerror or error}") from None
    answer = server.RequestHandlerClass

    def answer_in_time(asking: Any, *who: Any) -> "BaseRequestHandler":
        asking.settimeout(ASKED_WITHIN_S)
        return answer(asking, *who)

    # By itself it waits for ever for who says nothing, and prints a traceback where somebody goes away.
    server.RequestHandlerClass = answer_in_time
    server.handle_error = _note_failure  # type: ignore[assignment, method-assign]
    try:
        yield
    finally:
        server.shutdown()
        server.server_close()
        thread.join()


def _note_failure(*_: object) -> None:
    log.debug("a question for metrics was not answered", exc_info=True)


class _Collector:
    def __init__(self, latest: Callable[[], HealthMessage | None]) -> None:
        self._latest = latest

    def collect(self) -> "Iterator[Metric]":
        health = self._latest()
        if health is not None:
            yield from _families(health)


def _families(health: HealthMessage) -> "Iterator[Metric]":
    from prometheus_client.core import (  # noqa: PLC0415 - an extra
        CounterMetricFamily,
        GaugeMetricFamily,
        HistogramMetricFamily,
        InfoMetricFamily,
    )

    for name, counter in _told(Counter):
        yield CounterMetricFamily(PREFIX + _named(name), counter.told, getattr(health, name))
    for name, gauge in _told(Gauge):
        yield GaugeMetricFamily(PREFIX + _named(name), gauge.told, getattr(health, name))
    if health.data_age_s is not None:
        yield GaugeMetricFamily(
            f"{PREFIX}data_age_seconds", "age of the newest reading that the estimates contain", health.data_age_s
        )
    status = GaugeMetricFamily(f"{PREFIX}estimate_status", "1 for that of the newest estimate", labels=["status"])
    for one in Status:
        status.add_metric([one], float(one is health.status))
    yield status
    yield GaugeMetricFamily(f"{PREFIX}open_alarms", "alarms that are open", len(health.open_alarms))
    is_failing = float(bool(health.memory_failure))
    yield GaugeMetricFamily(f"{PREFIX}memory_failing", "1 while the memory cannot be written", is_failing)
    stale = GaugeMetricFamily(f"{PREFIX}signal_stale", "mapped signals that are not good", labels=["signal"])
    for signal in health.stale_signals:
        stale.add_metric([signal], 1.0)
    yield stale
    down = GaugeMetricFamily(f"{PREFIX}bus_down", "CAN buses that do not work", labels=["bus"])
    for bus in health.buses_down:
        down.add_metric([bus], 1.0)
    yield down
    bounds = [*map(str, health.latency_bounds_s), "+Inf"]
    counts = accumulate(health.latency_counts)
    yield HistogramMetricFamily(
        f"{PREFIX}latency_seconds",
        "estimates by the time from capture to publication",
        [(bound, float(count)) for bound, count in zip(bounds, counts, strict=True)],
        sum_value=health.latency_sum_s,
    )
    yield InfoMetricFamily(
        f"{PREFIX}build", "versions", {name.replace("-", "_"): text for name, text in health.versions.items()}
    )


def _told(kind: type[T]) -> Iterator[tuple[str, T]]:
    """Name of each number of a `HealthMessage` that is of this kind, and what it tells."""
    for name, hint in _hints().items():
        for told in getattr(hint, "__metadata__", ()):
            if isinstance(told, kind):
                yield name, told


@cache
def _hints() -> dict[str, Any]:
    """They are the same at each scrape."""
    return get_type_hints(HealthMessage, include_extras=True)


def _named(name: str) -> str:
    """Prometheus wants base units in full."""
    return f"{name.removesuffix('_s')}_seconds" if name.endswith("_s") else name
