"""Two vehicles with one id, as where a configuration was copied, are told of by both daemons; nobody else is."""

import json
import logging
import time

import pytest

from brake_monitor.publishing.publisher import Publisher
from brake_monitor.settings.zenoh_settings import ZenohSettings
from health import INTAKE
from network import free_port, running, session
from program import until

TOLD = "somebody else publishes as brake/v1/wagon-1, too"


def told(caplog: pytest.LogCaptureFixture) -> int:
    return sum(TOLD in record.message for record in caplog.records if record.levelno == logging.WARNING)


def publish(*publishers: Publisher) -> None:
    for publisher in publishers:
        publisher.publish_health(INTAKE)
    time.sleep(0.05)


def test_both_of_two_daemons_with_one_id_say_so_once(caplog: pytest.LogCaptureFixture) -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    with (
        running(ZenohSettings(listen=(endpoint,))) as one,
        running(ZenohSettings(connect=(endpoint,))) as other,
    ):

        def are_told() -> bool:
            publish(one, other)
            return told(caplog) == 2

        until(are_told)
        for _ in range(20):
            publish(one, other)
        assert told(caplog) == 2


def test_who_listens_and_who_came_before_are_nobody_else(caplog: pytest.LogCaptureFixture) -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    with session(endpoint, "peer") as listener, listener.declare_subscriber("brake/v1/**") as subscriber:
        for _ in range(3):  # a daemon that is started again and again
            with running(ZenohSettings(listen=(endpoint,))) as publisher:

                def hears(publisher: Publisher = publisher) -> bool:
                    publish(publisher)
                    sample = subscriber.try_recv()
                    return sample is not None and "uptime_s" in json.loads(sample.payload.to_bytes())

                until(hears)
                for _ in range(10):
                    publish(publisher)
    assert told(caplog) == 0
