"""`brake-monitor demo`: the whole chain in one process, nothing needed."""

import os
import shutil
import subprocess
import sys
import threading
import time
from argparse import ArgumentParser, Namespace
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from math import isinf

import can
from msgspec.structs import replace

from brake_monitor.commands import dashboard, watch
from brake_monitor.commands import options as shared
from brake_monitor.commands.summary import Summary
from brake_monitor.daemon.service import Service
from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.desk.fleet_listener import watcher_config
from brake_monitor.errors import WorkError
from brake_monitor.frame import Frame
from brake_monitor.host import extras
from brake_monitor.host.stop_signals import stopped_by_signals
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.publishing.about import about
from brake_monitor.publishing.publisher import Publisher
from brake_monitor.settings.config import Settings
from brake_monitor.settings.example_vehicles import EXAMPLES, example_settings
from brake_monitor.settings.zenoh_settings import ZenohSettings
from brake_monitor.simulator.live import play
from brake_monitor.simulator.scenarios import SCENARIOS, Profile, Scenario
from brake_monitor.simulator.simulate import run as simulate

DESCRIPTION = """\
Plays a simulated braking through real CAN frames on an embedded bus, the very service that runs as a daemon,
and Zenoh; shows what comes out as 'watch' does, and on a web page too where the extra 'dashboard' is installed.
No CAN hardware, no router, no configuration needed."""

EPILOG = ""

CHANNEL = "brake-monitor-demo"
PORT = 7447  # Zenoh's own; another one is taken when it is in use
TICK_S = 0.1  # how soon the end is noticed
COASTING_S = 6.0  # before the first braking, for the estimates to settle; the rest of it is skipped

SUBSCRIBE = """\
published at {endpoint} - from another terminal:
  {command} watch --connect {endpoint}
or, with nothing of ours:
  {python} -c "import time, zenoh
c = zenoh.Config(); c.insert_json5('mode', '\\"client\\"'); c.insert_json5('connect/endpoints', '[\\"{endpoint}\\"]')
with zenoh.open(c) as s:
    s.declare_subscriber('{prefix}/**', lambda m: print(m.key_expr, m.payload.to_string()))
    time.sleep(600)"
"""


def add_options(parser: ArgumentParser) -> None:
    """Its options."""
    parser.add_argument("scenario", nargs="?", choices=tuple(SCENARIOS), default="wsp", help="default: wsp")
    parser.add_argument("--vehicle", choices=EXAMPLES, default="wagon", help="default: wagon (two axles)")
    parser.add_argument("--speed", type=shared.speed, default=1.0, metavar="FACTOR", help="of real time, or 'max'")
    parser.add_argument("--seed", type=shared.seed, default=0, metavar="N", help="of the simulation")
    parser.add_argument("--no-dashboard", dest="dashboard", action="store_false", help="no web page")


def run(options: Namespace) -> int:
    """Simulate, then play it to the service until it is over; Ctrl-C before that interrupts it."""
    vehicle = example_settings(options.vehicle)
    scenario = SCENARIOS[options.scenario]
    print(f"simulating '{options.scenario}' ({scenario.summary}) …", flush=True)
    print("that takes some ten seconds, in which there is nobody to subscribe to yet", flush=True)
    frames = _from_first_braking(simulate(options.scenario, vehicle, options.seed).frames, scenario)
    print(_how_long(frames, options.speed, has_page=options.dashboard), flush=True)
    settings = replace(vehicle, can=tuple(replace(bus, interface="virtual", channel=CHANNEL) for bus in vehicle.can))
    pipeline = Pipeline.from_settings(settings)
    summary = Summary(settings)
    with ExitStack() as stack:
        publisher = stack.enter_context(_publisher(settings))
        print(_how_to_subscribe(settings, publisher), flush=True)
        page = stack.enter_context(_dashboard(publisher.endpoints[0])) if options.dashboard else None
        if page is not None:
            print(f"in a browser: {page}", flush=True)
        service = Service(pipeline, publisher, on_outputs=summary.see)
        is_over = _play_to_the_end(frames, options.speed, service, pipeline, publisher.endpoints[0])
    print(summary.text(pipeline), flush=True)
    if not is_over:
        raise KeyboardInterrupt  # which was taken for the end
    return 0


def _play_to_the_end(
    frames: Sequence[Frame], speed: float, service: Service, pipeline: Pipeline, endpoint: str
) -> bool:
    """Play the frames as if captured from now on, and watch what is published at the endpoint.

    Until the service has taken them all; False when it was told to end before.
    """
    mapped = _mapped(frames, pipeline.settings)
    is_over, stopping = threading.Event(), threading.Event()

    def play_and_stop() -> None:
        with can.Bus(interface="virtual", channel=CHANNEL, preserve_timestamps=True) as bus:
            shift_s = time.time() - frames[0].time_s
            play((frame._replace(time_s=frame.time_s + shift_s) for frame in frames), bus, speed)
        while pipeline.decoder.counts.mapped < mapped:
            time.sleep(TICK_S)
        is_over.set()
        stopping.set()

    with stopped_by_signals(stopping.set), ThreadPoolExecutor() as beside:
        service.buses.open()  # what is sent before is not heard
        serving = beside.submit(service.run)
        serving.add_done_callback(lambda _: stopping.set())
        threading.Thread(target=play_and_stop, name="player", daemon=True).start()
        try:
            watch.show(watcher_config(endpoint, None), stopping, pipeline.settings.zenoh.prefix)
        finally:
            service.stop()
    serving.result()  # or what it failed of
    return is_over.is_set()


@contextmanager
def _publisher(settings: Settings) -> Iterator[Publisher]:
    """A publisher that listens on Zenoh's usual port, or on any free one."""
    usual, free = (
        Publisher(
            ZenohSettings(listen=(f"tcp/127.0.0.1:{port}",)), settings.vehicle.id, about=about(settings, time.time())
        )
        for port in (PORT, 0)
    )
    with ExitStack() as stack:
        try:
            publisher = stack.enter_context(usual)
        except WorkError:
            publisher = stack.enter_context(free)
        yield publisher


@contextmanager
def _dashboard(endpoint: str) -> Iterator[str | None]:
    """The dashboard as a process of its own, and its address; None where the extra is not installed."""
    if not extras.is_installed("dashboard"):
        print(f"for a web page too: {extras.how_to_install('dashboard')}", flush=True)
        yield None
        return
    command = [sys.executable, "-m", "brake_monitor", "dashboard", "--connect", endpoint, "--parent", str(os.getpid())]
    for port in (dashboard.PORT, 0):  # any other one when the usual one is in use
        with subprocess.Popen(
            [*command, "--listen", f"127.0.0.1:{port}"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
        ) as child:
            assert child.stdout is not None
            said = child.stdout.readline().split()
            if said:
                try:
                    yield said[-1]
                finally:
                    child.terminate()
                return
    yield None


def _how_to_subscribe(settings: Settings, publisher: Publisher) -> str:
    prefix = f"{settings.zenoh.prefix}/{settings.vehicle.id}"
    # A demo that was started by its path does not put the command on that of another terminal.
    command = "brake-monitor" if shutil.which("brake-monitor") else f"{sys.executable} -m brake_monitor"
    return SUBSCRIBE.format(endpoint=publisher.endpoints[0], prefix=prefix, command=command, python=sys.executable)


def _how_long(frames: Sequence[Frame], speed: float, *, has_page: bool) -> str:
    seconds = (frames[-1].time_s - frames[0].time_s) / speed
    plays = "as fast as it can" if isinf(speed) else f"for {seconds:.0f} s"
    return f"now it plays {plays}; {'page and address end' if has_page else 'the address ends'} with it"


def _from_first_braking(frames: Sequence[Frame], scenario: Scenario) -> list[Frame]:
    """The frames from shortly before the first braking on."""
    assert isinstance(scenario.demand, Profile)
    first_braking_s = next(time_s for time_s, demand in scenario.demand.points if demand > 0.0)
    start_s = frames[0].time_s + max(first_braking_s - COASTING_S, 0.0)
    return [frame for frame in frames if frame.time_s >= start_s]


def _mapped(frames: Sequence[Frame], settings: Settings) -> int:
    """How many frames the service will take, which tells when it has heard all: it may lag far behind the sender."""
    decoder = SignalDecoder.from_settings(settings)
    for frame in frames:
        decoder.decode(frame)
    return decoder.counts.mapped
