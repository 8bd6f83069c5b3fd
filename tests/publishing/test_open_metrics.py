"""Health as other tools scrape it: real HTTP, read by the standard client library's own parser."""

import re
import socket
import struct
import threading
import urllib.request
from pathlib import Path

import pytest
from prometheus_client.openmetrics.parser import text_string_to_metric_families

from brake_monitor.errors import WorkError
from brake_monitor.estimation.estimate import Status
from brake_monitor.publishing import open_metrics as open_metrics_module
from brake_monitor.publishing.about import VERSIONS
from brake_monitor.publishing.health import Counters, health_of
from brake_monitor.publishing.open_metrics import open_metrics
from brake_monitor.publishing.payloads import HealthMessage
from health import INTAKE
from network import free_port
from program import PATIENCE_S, until


def health() -> HealthMessage:
    counters = Counters(estimates_sent=5, events_lost=6)
    for latency_s in (0.0005, 0.001, 0.003, 100.0, -0.25, 1.7e9, -3600.0):  # a clock was set in the midst of the last
        counters.add_latency(latency_s)
    return health_at(1000.25, counters)


def health_at(now_s: float, counters: Counters) -> HealthMessage:
    newest = (1000.0, Status.VALID)
    opened = ("hot_disc-1-5", "slide-2-7")
    return health_of(
        INTAKE, counters, newest, events_waiting=8, open_alarms=opened, uptime_s=60.0, sequence=1, now_s=now_s
    )


def scraped(port: int) -> dict[str, float]:
    request = urllib.request.Request(
        f"http://127.0.0.1:{port}/metrics", headers={"Accept": "application/openmetrics-text; version=1.0.0"}
    )
    with urllib.request.urlopen(request, timeout=PATIENCE_S) as response:
        assert response.headers["Content-Type"].startswith("application/openmetrics-text")
        families = text_string_to_metric_families(response.read().decode())
        return {
            sample.name + "".join(f" {value}" for value in sample.labels.values()): sample.value
            for family in families
            for sample in family.samples
        }


def test_what_is_scraped_is_the_health() -> None:
    port = free_port()
    with open_metrics(port, health):
        found = scraped(port)
    assert found["brake_monitor_frames_total"] == 1000
    assert found["brake_monitor_events_lost_total"] == 6
    assert found["brake_monitor_late_samples_total"] == 9
    assert found["brake_monitor_outliers_total"] == 11
    assert found["brake_monitor_events_waiting"] == 8
    assert found["brake_monitor_data_age_seconds"] == 0.25
    assert found["brake_monitor_uptime_seconds"] == 60.0
    assert found["brake_monitor_estimate_status valid"] == 1
    assert found["brake_monitor_estimate_status held"] == 0
    assert found["brake_monitor_open_alarms"] == 2
    assert found["brake_monitor_memory_failing"] == 0
    assert found["brake_monitor_signal_stale GNSS.v lost"] == 1
    assert found["brake_monitor_bus_down socketcan:can0"] == 1
    assert found[f"brake_monitor_build_info {' '.join(VERSIONS[name] for name in sorted(VERSIONS))}"] == 1
    assert found["brake_monitor_memory_bytes"] > 1e6
    assert found["brake_monitor_latency_seconds_sum"] == pytest.approx(100.0045)
    assert found["brake_monitor_latency_seconds_count"] == 5
    below = {name: value for name, value in found.items() if name.startswith("brake_monitor_latency_seconds_bucket")}
    assert below["brake_monitor_latency_seconds_bucket 0.001"] == 3  # cumulative, bounds included
    assert below["brake_monitor_latency_seconds_bucket 0.005"] == 4
    assert below["brake_monitor_latency_seconds_bucket +Inf"] == 5


def test_every_metric_is_told() -> None:
    page = (Path(__file__).parents[2] / "docs" / "interface.md").read_text()
    named = set(re.findall(r"`(brake_monitor_[a-z_]+)", page)) - {"brake_monitor_"}
    port = free_port()
    with open_metrics(port, health):
        found = {re.sub(r"_(bucket|count|sum)$", "", sample.partition(" ")[0]) for sample in scraped(port)}
    numbers = {
        name.removeprefix("brake_monitor_").removesuffix("_total").replace("_seconds", "_s") for name in found - named
    }
    assert numbers <= set(HealthMessage.__struct_fields__)
    assert named <= found


def test_the_status_of_the_newest_estimate_is_told_and_that_there_is_none_yet() -> None:
    told = health()
    assert (told.time_s, told.status, told.quality) == (1000.0, Status.VALID, "good")
    early = health_of(INTAKE, Counters(), None, events_waiting=0, uptime_s=0.0, sequence=1, now_s=1.0)
    assert (early.time_s, early.status, early.quality) == (0.0, Status.INVALID, "bad")


def test_before_there_is_any_health_nothing_is_said_of_it() -> None:
    port = free_port()
    with open_metrics(port, lambda: None):
        assert scraped(port) == {}


def test_only_this_machine_is_answered_and_a_port_in_use_is_one_sentence() -> None:
    port = free_port()
    with open_metrics(port, health):
        addresses = {
            line.split()[1]
            for line in Path("/proc/net/tcp").read_text().splitlines()
            if line.split()[1].endswith(f":{port:04X}")
        }
        assert addresses == {f"{int.from_bytes(socket.inet_aton('127.0.0.1'), 'little'):08X}:{port:04X}"}
        with (
            pytest.raises(WorkError, match=rf"\[metrics\] port {port}: Address already in use"),
            open_metrics(port, health),
        ):
            pass


def test_readings_are_not_younger_than_none() -> None:
    """While a clock is set back."""
    assert health_at(940.0, Counters()).data_age_s == 0.0


def test_who_connects_and_says_nothing_is_not_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each has a thread, of which the unit lets the daemon have so many."""
    monkeypatch.setattr(open_metrics_module, "ASKED_WITHIN_S", 0.1)
    port = free_port()
    with open_metrics(port, health), socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S) as idle:
        assert idle.recv(1) == b""
        assert scraped(port)


def test_who_goes_away_in_the_midst_of_a_question_is_not_told_of_in_the_journal(
    capfd: pytest.CaptureFixture[str],
) -> None:
    port = free_port()
    with open_metrics(port, health):
        before = threading.active_count()
        with socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S) as asks:
            asks.sendall(b"GET /metrics HTTP/1.1\r\n")
            until(lambda: threading.active_count() > before)
            asks.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))  # the end is a reset
        until(lambda: threading.active_count() == before)
    assert capfd.readouterr() == ("", "")
