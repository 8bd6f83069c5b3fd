"""Takes the pictures of the README anew: python tests/dashboard/take_pictures.py [DIRECTORY]

The demo's wagon, and a fleet of simulated drives, each in light and dark; all through real publishers, a router, the
dashboard and Chromium.
"""

import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from msgspec.structs import replace
from PIL import Image
from playwright.sync_api import sync_playwright

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / "tests")]

from brake_monitor.processing.pipeline import Outputs, Pipeline  # noqa: E402
from brake_monitor.publishing.about import about  # noqa: E402
from brake_monitor.publishing.publisher import Publisher  # noqa: E402
from brake_monitor.settings.example_vehicles import example_settings  # noqa: E402
from brake_monitor.settings.zenoh_settings import ZenohSettings  # noqa: E402
from brake_monitor.simulator.simulate import run as simulate  # noqa: E402
from browser import CHROMIUM, QUIET  # noqa: E402 - beside this file
from depot import Depot  # noqa: E402

DEMO_S = 66.0  # into the demo: in the middle of the long slide
FLEET_S = 45.0
DRIVES = (("wagon", "wsp"), ("bogie", "sanding"), ("wagon", "dry"))
WAGONS = 12
PERIOD_S = 0.1
COLOURS = 256


def main(folder: Path) -> None:
    """Write the pictures."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(QUIET))
        with demo() as address:
            pages = {
                scheme: opened(browser, f"{address}#/wagon/wagon-8127", scheme, 1180) for scheme in ("light", "dark")
            }
            time.sleep(DEMO_S)
            for scheme, page in pages.items():
                take(page, folder / f"dashboard-{scheme}.png")
        with fleet() as address:
            time.sleep(FLEET_S)
            for scheme in ("light", "dark"):
                page = opened(browser, address, scheme, 720)
                time.sleep(4.0)
                take(page, folder / f"fleet-{scheme}.png")
        browser.close()


def opened(browser: Any, address: str, scheme: str, height: int) -> Any:
    page = browser.new_context(color_scheme=scheme, viewport={"width": 1440, "height": height}).new_page()
    page.goto(address)
    return page


def take(page: Any, path: Path) -> None:
    """A palette is enough, and a third of the bytes."""
    page.bring_to_front()
    time.sleep(0.5)
    page.screenshot(path=path)
    Image.open(path).convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE).save(path, optimize=True)
    print(path, path.stat().st_size)


@contextmanager
def demo() -> Iterator[str]:
    command = [sys.executable, "-u", "-m", "brake_monitor", "demo"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        yield next(line for line in child.stdout if line.startswith("in a browser")).split()[-1]
        threading.Thread(target=child.stdout.read, daemon=True).start()
        child.terminate()


@contextmanager
def fleet() -> Iterator[str]:
    """Wagons at different moments of their drives."""
    with ExitStack() as stack:
        depot = Depot(stack)
        depot.router()
        depot.dashboard()
        players = []
        drives = [(example_settings(vehicle), scenario) for vehicle, scenario in DRIVES]
        outputs = [played(settings, scenario) for settings, scenario in drives]
        for k in range(WAGONS):
            settings, _ = drives[k % len(drives)]
            name = f"{settings.vehicle.id.split('-')[0]}-{8127 + 37 * k}"
            zenoh = ZenohSettings(connect=(depot.endpoint,), listen=())
            publisher = stack.enter_context(Publisher(zenoh, name, about=about(settings, time.time())))
            mine, brakes = outputs[k % len(drives)]
            publisher.publish_wear(brakes, settings.wear)
            players.append((publisher, mine, k * 131 % len(mine)))
        stopping = threading.Event()
        stack.callback(stopping.set)
        threading.Thread(target=play, args=(players, stopping), daemon=True).start()
        yield depot.address


def played(settings: Any, scenario: str) -> tuple[list[Outputs], Any]:
    pipeline = Pipeline.from_settings(settings)
    outputs = [pipeline.step(frame) for frame in simulate(scenario, settings, 0).frames]
    return [one for one in outputs if one.estimate is not None], pipeline.brake_book.brakes


def play(players: list[tuple[Publisher, list[Outputs], int]], stopping: threading.Event) -> None:
    turn = 0
    while not stopping.wait(PERIOD_S):
        turn += 1
        now_s = time.time()
        for publisher, outputs, first in players:
            one = outputs[(first + turn) % len(outputs)]
            assert one.estimate is not None
            shift_s = now_s - one.estimate.time_s
            alarms = [replace(a, raised_time_s=a.raised_time_s + shift_s, updated_time_s=now_s) for a in one.alarms]
            publisher.publish(Outputs(replace(one.estimate, time_s=now_s), tuple(alarms)))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs" / "img")
