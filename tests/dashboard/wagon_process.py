"""A wagon as a process of its own: a real publisher that publishes what it is told, ten times a second.

python wagon_process.py ENDPOINT NAME ENCODING      begins with the first line that it is told; each is a JSON object:
{"pad_margin_mm": …}                         in the first line: as the wagon is configured
{"estimate": {…}, "wheelsets": [{…}, …]}     what is published from now on
{"alarm": {…}}                               an alarm as it stands now
{"wear": true}                               the state of the pads, or with {…} what of their use is different
"""

# ruff: noqa: E402 - what must not be imported is said before the imports

import json
import sys
import threading
import time
from typing import Any

from brake_monitor.host.python_can import load_cantools_alone

load_cantools_alone()  # as `brake-monitor` does

from msgspec.structs import replace

from brake_monitor.monitoring.alarm import Severity
from brake_monitor.monitoring.brake_units.brakes import Brakes, BrakeUnit
from brake_monitor.monitoring.brake_units.wear import PadUse, PadWear
from brake_monitor.processing.pipeline import Outputs, Pipeline
from brake_monitor.publishing.about import about
from brake_monitor.publishing.health import intake_of
from brake_monitor.publishing.publisher import Publisher
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.settings.zenoh_settings import ZenohSettings
from estimates import alarm, estimate, wheelset

PERIOD_S = 0.1


def main(endpoint: str, name: str, encoding: Any) -> None:
    settings = example_settings("wagon")
    now: dict[str, Any] = {"estimate": {}, "wheelsets": [{}, {}]} | json.loads(sys.stdin.readline())
    if "pad_margin_mm" in now:
        near = replace(settings.alarms.pad_near_limit, margin_mm=now["pad_margin_mm"])
        settings = replace(settings, alarms=replace(settings.alarms, pad_near_limit=near))
    publisher = Publisher(
        ZenohSettings(connect=(endpoint,), listen=(), encoding=encoding), name, about=about(settings, time.time())
    )
    publisher.start()

    def publish() -> None:
        intake = intake_of(Pipeline.from_settings(settings))
        while True:
            wheelsets = tuple(wheelset(**changes) for changes in now["wheelsets"])
            values = {"time_s": time.time()} | now["estimate"]
            publisher.publish(Outputs(estimate(**values, wheelsets=wheelsets)))
            publisher.publish_health(intake)
            time.sleep(PERIOD_S)

    threading.Thread(target=publish, daemon=True).start()
    print("ready", flush=True)
    for line in sys.stdin:
        told = json.loads(line)
        if "alarm" in told:
            told["alarm"]["severity"] = Severity(told["alarm"].get("severity", "alarm"))
            publisher.publish(Outputs(None, (alarm(**told["alarm"]),)))
        elif "wear" in told:
            use = PadUse(2e9, 6e9, 900.0, 3e6, 4e5)
            pads = PadWear.new(settings.wear).used(use if told["wear"] is True else replace(use, **told["wear"]))
            publisher.publish_wear(Brakes(time.time(), (BrakeUnit(pads, 80.0),) * 2, ()), settings.wear)
        else:
            now |= told
    publisher.close()


if __name__ == "__main__":
    main(*sys.argv[1:])
