"""The dashboard, looked at for long. Run: python tests/benchmarks/dashboard.py [WAGONS] [MINUTES] (20 60).

A process full of wagons plays a simulated drive again and again, every wagon at another moment of it: ten estimates a
second each, with health, alarms that come and go, and wear. The router, the dashboard and a headless Chromium are
processes of their own. The first half of the time the browser shows the fleet, the second half one wagon, and at the
end it goes to and fro. Every minute is a line, the settled part of each half a table.

How late the page is can be read off it: the wagons' speed in km/h is the time of capture in s, modulo LAP_S.
"""

import os
import subprocess
import sys
import time
from contextlib import ExitStack
from pathlib import Path
from statistics import fmean
from typing import Any, NamedTuple

from msgspec.structs import replace

TESTS = Path(__file__).parents[1]
sys.path[:0] = [str(TESTS), str(TESTS / "dashboard")]  # when it is run as a script

from browser import CHROMIUM, QUIET  # noqa: E402
from depot import Depot  # noqa: E402

PERIOD_S = 0.1
HEALTH_EVERY = 10  # estimates
LAP_S = 200.0
LAPS_BEFORE = 12  # whose alarms are remembered: as many as are shown of a wagon
LEAST_MIN = 2
SETTLED_MIN = 7  # the five minutes of curves are full then, and what a browser compiles is compiled
TO_AND_FRO = 200
SETTLE_MS = 5_000  # after a view was opened
CLOCK_TICKS = os.sysconf("SC_CLK_TCK")
SPEEDS = "td.speed-now, .speed .figure span:first-child"  # of the fleet, of a wagon

# Notes every frame, and twenty times a second how late the oldest of the speeds that are shown is.
WATCH = f"""
  const fresh = () => ({{ since: performance.now(), frames: 0, longest_ms: 0, late_s: [] }});
  let noted = fresh(), before = null;
  window.takeNoted = () => {{ const was = noted; noted = fresh(); before = null;
    return {{ ...was, frames: was.frames / (performance.now() - was.since) * 1000 }}; }};
  const frame = () => {{
    const now = performance.now();
    if (before !== null) noted.longest_ms = Math.max(noted.longest_ms, now - before);
    before = now;
    noted.frames++;
    requestAnimationFrame(frame);
  }};
  requestAnimationFrame(frame);
  setInterval(() => {{
    const shown = [...document.querySelectorAll({SPEEDS!r})].map((one) => Number(one.textContent));
    const now_s = Date.now() / 1000 + {LAP_S / 2};
    const late_s = shown.filter(Number.isFinite).map((s) => (now_s + {LAP_S} - s) % {LAP_S} - {LAP_S / 2});
    if (late_s.length) noted.late_s.push(Math.max(...late_s));
  }}, 50);
"""


class Minute(NamedTuple):
    """What was seen of a minute, and what is held at its end."""

    server_mb: float  # resident
    server_cpu: float  # share of a core
    renderer_mb: float  # resident
    renderer_cpu: float
    heap_mb: float  # of scripts, after a collection
    nodes: int  # of the document and what scripts hold of it, after a collection
    listeners: int
    frames_per_s: float
    longest_gap_ms: float  # between two frames
    late_ms: float  # what is shown, on average
    latest_ms: float


def wagons(endpoint: str, count: int) -> None:
    """The process full of wagons."""
    from brake_monitor.processing.pipeline import Outputs, Pipeline  # noqa: PLC0415
    from brake_monitor.publishing.about import about  # noqa: PLC0415 - only this process needs it
    from brake_monitor.publishing.health import intake_of  # noqa: PLC0415
    from brake_monitor.publishing.publisher import Publisher  # noqa: PLC0415
    from brake_monitor.settings.example_vehicles import example_settings  # noqa: PLC0415
    from brake_monitor.settings.zenoh_settings import ZenohSettings  # noqa: PLC0415
    from brake_monitor.simulator.simulate import run as simulate  # noqa: PLC0415

    settings = example_settings("wagon")
    pipeline = Pipeline.from_settings(settings)
    drive = [outputs for frame in simulate("wsp", settings, 0).frames if (outputs := pipeline.step(frame)).estimate]
    network, told = ZenohSettings(connect=(endpoint,), listen=()), about(settings, time.time())
    publishers = [Publisher(network, f"wagon-{i:03}", about=told) for i in range(count)]
    for publisher in publishers:
        publisher.start()
    print("ready", flush=True)
    for lap in range(-LAPS_BEFORE, 0):
        for publisher in publishers:
            for played in drive:
                publisher.publish(Outputs(None, tuple(_now(alarm, time.time(), lap) for alarm in played.alarms)))
    begun_s = time.time()
    for turn in range(sys.maxsize):
        for i, publisher in enumerate(publishers):
            time.sleep(max(0.0, begun_s + (turn + i / count) * PERIOD_S - time.time()))
            lap, row = divmod(turn + i * len(drive) // count, len(drive))
            now_s, played = time.time(), drive[row]
            assert played.estimate is not None
            estimate = replace(played.estimate, time_s=now_s, speed_mps=now_s % LAP_S / 3.6)
            publisher.publish(Outputs(estimate, tuple(_now(alarm, now_s, lap) for alarm in played.alarms)))
            if turn % HEALTH_EVERY == 0:
                publisher.publish_health(intake_of(pipeline))
            if row == 0:
                publisher.publish_wear(pipeline.brake_book.brakes, settings.wear)


def _now(alarm: Any, now_s: float, lap: int) -> Any:
    """An alarm of this lap, as if its change were of now."""
    shift_s = now_s - alarm.updated_time_s
    times = {name: getattr(alarm, name) for name in ("raised_time_s", "updated_time_s", "cleared_time_s")}
    return replace(alarm, id=f"{alarm.id}-{lap}", **{n: s if s is None else s + shift_s for n, s in times.items()})


class Watched:
    """A process's memory and time, as the kernel tells them."""

    def __init__(self, pid: int) -> None:
        self._proc = Path(f"/proc/{pid}")
        self._before = (time.monotonic(), self._cpu_s())

    def _cpu_s(self) -> float:
        fields = (self._proc / "stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / CLOCK_TICKS

    def cpu(self) -> float:
        """Share of a core since it was asked last."""
        (then_s, used_s), self._before = self._before, (time.monotonic(), self._cpu_s())
        return (self._before[1] - used_s) / (self._before[0] - then_s)

    def resident_mb(self) -> float:
        return int((self._proc / "statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


class Looker:
    """The page in its browser, with the dashboard's process beside it."""

    def __init__(self, browser: Any, address: str, server_pid: int) -> None:
        self.page = browser.new_context(viewport={"width": 1440, "height": 1500}).new_page()
        self.page.add_init_script(WATCH)
        self.page.goto(address)
        processes = browser.new_browser_cdp_session().send("SystemInfo.getProcessInfo")["processInfo"]
        renderers = [Watched(one["id"]) for one in processes if one["type"] == "renderer"]
        self.page.wait_for_timeout(SETTLE_MS)
        self._renderer = max(renderers, key=Watched.cpu)  # another is kept in reserve
        self._developer = self.page.context.new_cdp_session(self.page)
        self._server = Watched(server_pid)

    def go(self, place: str) -> None:
        """To another view, as a click goes there."""
        self.page.evaluate("(place) => { location.hash = place; }", place)

    def held(self) -> tuple[float, int, int]:
        """Memory of scripts in MB, nodes and listeners once all that is no longer needed is gone."""
        self._developer.send("HeapProfiler.collectGarbage")
        counts = self._developer.send("Memory.getDOMCounters")
        heap_bytes = self._developer.send("Runtime.getHeapUsage")["usedSize"]
        return heap_bytes / 1e6, counts["nodes"], counts["jsEventListeners"]

    def minute(self) -> Minute:
        """Look on for a minute."""
        self.page.evaluate("takeNoted()")
        self._server.cpu()
        self._renderer.cpu()
        self.page.wait_for_timeout(60_000)
        noted = self.page.evaluate("takeNoted()")
        used = self._server.cpu(), self._renderer.cpu()
        held = self.held()
        late_ms = [late_s * 1e3 for late_s in noted["late_s"]]
        assert late_ms, "no wagon's speed is shown"
        return Minute(
            self._server.resident_mb(), used[0], self._renderer.resident_mb(), used[1], *held,
            noted["frames"], noted["longest_ms"], fmean(late_ms), max(late_ms),
        )  # fmt: skip

    def to_and_fro(self) -> None:
        """Open the wagons one after the other, and the fleet in between."""
        names = self.page.locator("td.id a").all_inner_texts()
        for k in range(TO_AND_FRO):
            self.go(f"#/wagon/{names[k % len(names)]}")
            self.page.locator(".chart canvas").first.wait_for()
            self.go("#/")
            self.page.locator("td.speed-now").first.wait_for()


def started_wagons(endpoint: str, count: int, stack: ExitStack) -> None:
    child = subprocess.Popen(
        [sys.executable, __file__, "wagons", endpoint, str(count)], stdout=subprocess.PIPE, text=True
    )
    stack.enter_context(child)
    stack.callback(child.kill)
    assert child.stdout is not None
    assert child.stdout.readline().strip() == "ready"


def main(count: int, minutes: int) -> None:
    from playwright.sync_api import sync_playwright  # noqa: PLC0415 - the wagons do without

    with ExitStack() as stack:
        depot = Depot(stack)
        depot.router()
        started_wagons(depot.endpoint, count, stack)
        server = depot.dashboard()
        playwright = stack.enter_context(sync_playwright())
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(QUIET))
        stack.callback(browser.close)
        looker = Looker(browser, depot.address, server.pid)
        print("minute " + " ".join(f"{name:>14}" for name in Minute._fields))
        for name, place in (("fleet", "#/"), ("wagon", "#/wagon/wagon-000")):
            seen = looked_on(looker, place, minutes // 2)
            print(f"\n{name}: {len(seen)} min, of which the first {SETTLED_MIN} are left out\n{table(seen)}\n")
        go_about(looker)


def looked_on(looker: Looker, place: str, minutes: int) -> list[Minute]:
    """One view for so long."""
    looker.go(place)
    looker.page.wait_for_timeout(SETTLE_MS)
    seen: list[Minute] = []
    while len(seen) < minutes:
        seen.append(looker.minute())
        print(f"{len(seen):6} " + " ".join(f"{value:14.2f}" for value in seen[-1]), flush=True)
    return seen


def go_about(looker: Looker) -> None:
    """What is left when views were opened and left: the first time some, then no more."""
    looker.go("#/")
    looker.page.locator("td.speed-now").first.wait_for()
    for times in range(3):
        if times:
            looker.to_and_fro()
        heap_mb, nodes, listeners = looker.held()
        print(f"{times * TO_AND_FRO} times to a wagon and back: {heap_mb:.2f} MB, {nodes} nodes, {listeners} listeners")


def table(seen: list[Minute]) -> str:
    """The first settled quarter against the last."""
    settled = seen[SETTLED_MIN:] or seen
    quarter = max(len(settled) // 4, 1)
    lines = [f"{'':16} {'first quarter':>14} {'last quarter':>14} {'all: least':>14} {'greatest':>14}"]
    for k, name in enumerate(Minute._fields):
        column = [minute[k] for minute in settled]
        figures = (fmean(column[:quarter]), fmean(column[-quarter:]), min(column), max(column))
        lines.append(f"{name:16} " + " ".join(f"{figure:14.2f}" for figure in figures))
    return "\n".join(lines)


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["wagons", endpoint, count]:
            wagons(endpoint, int(count))
        case []:
            main(20, 60)
        case [count]:
            main(int(count), 60)
        case [count, minutes] if int(minutes) >= LEAST_MIN:
            main(int(count), int(minutes))
        case _:
            sys.exit("expected [WAGONS] [MINUTES], at least one minute for each half, two in all")
