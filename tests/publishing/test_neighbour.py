"""A router that is not there, as under a wrong address, is told of; so is its coming, and its going."""

import logging
import time

import pytest

from brake_monitor.publishing.publisher import Publisher
from brake_monitor.settings.zenoh_settings import ZenohSettings
from health import INTAKE
from network import free_port, running
from program import Router, until


def test_a_router_that_is_away_is_told_of_once_and_so_is_its_return(caplog: pytest.LogCaptureFixture) -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    gone, back = f"no Zenoh router answers at {endpoint}; still trying", "connected to a Zenoh router"

    def told() -> list[str]:
        return [record.message for record in caplog.records if record.message in {gone, back}]

    def looks_until(publisher: Publisher, lines: list[str]) -> None:
        def are_told() -> bool:
            publisher.publish_health(INTAKE)
            time.sleep(0.05)
            return told() == lines

        until(are_told)

    with caplog.at_level(logging.INFO), running(ZenohSettings(connect=(endpoint,))) as publisher:
        looks_until(publisher, [gone])
        with Router(endpoint):
            looks_until(publisher, [gone, back])
        looks_until(publisher, [gone, back, gone])


def test_who_connects_to_nobody_misses_nobody(caplog: pytest.LogCaptureFixture) -> None:
    with running() as publisher:
        sent = publisher.counters
        for _ in range(8):
            publisher.publish_health(INTAKE)
            time.sleep(0.05)
        assert sent.publish_failures == 0
    assert not [record for record in caplog.records if "no Zenoh router" in record.message]
