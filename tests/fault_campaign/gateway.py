"""A gateway in the guest: the shipped unit, a bus with a wagon that drives on it, a router, and a peer that listens.

The bus is a pair of virtual CAN interfaces: can0 is the daemon's, the wagon's frames come in at the other end, wire0.
So whatever leaves can0 would be the daemon's: its counter of sent frames has to stay 0.
"""

import json
import re
import signal
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from brake_monitor.frame import Frame
from brake_monitor.settings.config_file import load_settings
from brake_monitor.simulator.files import write_log
from brake_monitor.simulator.scenarios import Profile, Scenario, steps
from brake_monitor.simulator.simulate import EPOCH_S
from brake_monitor.simulator.simulate import run as simulate
from bus_cycles import SLOW_MS, with_cycles
from installation import CONFIG, ENOUGH_S, ETC, SERVICE, install, run, shown
from program import Program, Router

HERE = Path(__file__).parent
ROUTER = "tcp/127.0.0.1:7447"
STATE_MOUNT = Path("/var/lib/private/brake-monitor")  # where systemd keeps the state of a dynamic user
MEMORY = STATE_MOUNT / "memory.db"
LOOK_EVERY_S = 0.3  # each look is a process
WATCHDOG_S = 8  # of the unit's 20: it is waited for in every hang

SERVICE_DRIVE = Scenario(
    name="service",
    summary="a wagon that brakes lightly for 4 s in every 12 s; nothing is wrong with it",
    initial_speed_mps=33.0,
    duration_s=96.0,
    demand=steps(
        *((from_s, demand) for k in range(8) for from_s, demand in ((6.0 + 12 * k, 0.3), (10.0 + 12 * k, 0.0)))
    ),
    rail_over_time=Profile(((0.0, 0.45),)),
)

# Alarms that say something about bus, sensors and disk; every other is about the brakes and would be false here.
OF_INPUTS = {"bus_silent", "bus_fault", "input_lost", "input_implausible", "memory_failing"}

DROP_IN = f"""\
[Unit]
Description=the campaign's own: a shorter watchdog, a way to make the main thread hang
[Service]
WatchdogSec={WATCHDOG_S}
Environment=PYTHONPATH=/opt/campaign
"""
HANGS_ON_REQUEST = """\
import signal, time
signal.signal(signal.SIGUSR1, lambda *_: time.sleep(1e6))
"""


# What Python's faulthandler writes of a process that is aborted: where each of its threads is.
PLACES = re.compile(r'Fatal Python error|Current thread 0x|Thread 0x|  File "|Extension modules|$')


def by_the_daemon(event: dict[str, Any]) -> bool:
    """Whether a line of the unit's journal is not systemd's own."""
    return event.get("_COMM") != "systemd"


@dataclass
class Mark:
    """A moment, and what was so in it."""

    restarts: int
    begun_s: float
    heard: int  # samples before
    until: int | None = None  # samples at the end of what counts


class Gateway:
    """What a fault is done to, and what is seen of it."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._frames: list[Frame] = []
        self.drive_log = folder / "drive.log"
        self.heard: list[dict[str, Any]] = []
        self._lines_read = 0
        self.mark = Mark(0, 0.0, 0)

    @contextmanager
    def set_up(self) -> Iterator["Gateway"]:
        """From installed to gone."""
        install()
        Path("/opt/campaign").mkdir(exist_ok=True)
        Path("/opt/campaign/sitecustomize.py").write_text(HANGS_ON_REQUEST)
        drop_in = Path(f"/etc/systemd/system/{SERVICE}.d/campaign.conf")
        drop_in.parent.mkdir()
        drop_in.write_text(DROP_IN)
        run("systemctl", "daemon-reload")
        STATE_MOUNT.mkdir(parents=True)
        run("mount", "-t", "tmpfs", "-o", "size=16M,mode=700", "tmpfs", STATE_MOUNT)
        good, dbc = CONFIG.read_text(), (ETC / "wagon.dbc").read_text()
        (ETC / "wagon.dbc").write_text(with_cycles(dbc, SLOW_MS))  # there is one slow processor
        CONFIG.write_text(good.replace("[signals]", f'[zenoh]\nconnect = ["{ROUTER}"]\n\n[signals]', 1))
        self._frames = list(simulate(SERVICE_DRIVE, load_settings(CONFIG), seed=1).frames)
        write_log(self.drive_log, self._frames)
        self.bus_appears()
        self.start_router()
        self.peer = Program(sys.executable, HERE / "peer.py", ROUTER)
        self.peer.wait_for("ready")
        try:
            yield self
        finally:
            run("systemctl", "stop", SERVICE)
            for program in (self.peer, self.router):
                program.__exit__()
            self.bus_goes()
            CONFIG.write_text(good)
            (ETC / "wagon.dbc").write_text(dbc)
            run("umount", STATE_MOUNT)
            drop_in.unlink()
            drop_in.parent.rmdir()
            run("systemctl", "daemon-reload")

    # -- doing -------------------------------------------------------------------------------------------------

    def start_router(self) -> None:
        self.router = Router(ROUTER)

    def bus_appears(self, *, up: bool = True) -> None:
        run("ip", "link", "add", "can0", "type", "vxcan", "peer", "name", "wire0")
        for name in ("can0", "wire0"):
            run("ip", "link", "set", name, "mtu", "72")
            if up:
                run("ip", "link", "set", name, "up")

    def bus_goes(self) -> None:
        self.assert_nothing_sent()
        run("ip", "link", "del", "can0")

    def systemctl(self, *arguments: str) -> None:
        run("systemctl", *arguments, SERVICE)
        if "stop" in arguments or "restart" in arguments:
            self.mark.restarts = 0  # systemd counts anew

    def kill(self, number: signal.Signals) -> None:
        run("systemctl", "kill", "--kill-who=main", f"--signal={number.name}", SERVICE)

    def log_without(self, name: str, unwanted: Callable[[float, Frame], bool]) -> Path:
        """The drive without some frames; `unwanted` is told the time since its beginning."""
        path = self._folder / f"{name}.log"
        write_log(path, [frame for frame in self._frames if not unwanted(frame.time_s - EPOCH_S, frame)])
        return path

    @contextmanager
    def driving(self, log: Path | None = None, *, again: bool = False, by_the_clock: bool = True) -> Iterator[None]:
        """The wagon drives, its estimate is valid and no alarm open: what counts begins here, unless it has."""
        begun_s = time.monotonic()
        self.mark.until = None
        player = ("canplayer", "wire0=can0", "-I") if by_the_clock else (sys.executable, HERE / "player.py")
        with Program(*player, log or self.drive_log):
            self.wait_for_estimate(begun_s, {"valid"})
            if not again:
                self.wait_for(lambda: not self.open_alarms(), "without an open alarm")
                self.begin()
            yield
            self.listen()
            self.mark.until = len(self.heard)

    @contextmanager
    def frames_on_the_wire(self, *arguments: str) -> Iterator[None]:
        """Somebody else puts frames on the bus meanwhile, by the flooding script."""
        with Program(sys.executable, HERE / "flood.py", *arguments):
            yield

    # -- seeing ------------------------------------------------------------------------------------------------

    @property
    def pid(self) -> int:
        return int(shown("MainPID"))

    def begin(self) -> None:
        """What follows is the next fault's."""
        if shown("ActiveState") != "active":
            self.systemctl("start")
        self.listen()
        self.mark = Mark(int(shown("NRestarts")), time.monotonic(), len(self.heard))

    def listen(self) -> None:
        """Take what the peer has heard meanwhile."""
        lines = self.peer.lines
        while self._lines_read < len(lines):
            line = lines[self._lines_read]
            self._lines_read += 1
            if line.startswith("{"):
                self.heard.append(json.loads(line))

    def wait_for(self, condition: Callable[[], Any], what: str) -> Any:
        """What the condition gives once it is true."""
        deadline_s = time.monotonic() + ENOUGH_S
        while True:
            self.listen()
            if given := condition():
                return given
            if time.monotonic() > deadline_s:
                raise AssertionError(f"never {what}; the journal:\n" + "\n".join(self.journal()[-30:]))
            time.sleep(LOOK_EVERY_S)

    def wait_for_estimate(self, after_s: float, statuses: Iterable[str] = ("valid", "converging")) -> float:
        """When, in s after the moment, the peer heard an estimate with one of the statuses."""
        wanted = set(statuses)

        def heard_s() -> float | None:
            return next(
                (
                    sample["heard_s"]
                    for sample in self.heard[self.mark.heard :]
                    if sample["key"].endswith("/adhesion")
                    and sample["heard_s"] > after_s
                    and sample["payload"]["status"] in wanted
                ),
                None,
            )

        return float(self.wait_for(heard_s, f"an estimate that is {wanted}")) - after_s

    def alarms(self) -> list[dict[str, Any]]:
        """What was heard of alarms in this fault, in order."""
        self.listen()
        counts = self.heard[self.mark.heard : self.mark.until]
        return [sample["payload"] for sample in counts if "/alarm/" in sample["key"]]

    def open_alarms(self) -> set[str]:
        """Ids of those that are not over; but a disk that fails cannot keep its own alarm over a restart."""
        told = [sample["payload"] for sample in self.heard if "/alarm/" in sample["key"]]
        last = {alarm["id"]: alarm["state"] for alarm in told if alarm["kind"] != "memory_failing"}
        return {name for name, state in last.items() if state != "cleared"}

    def wait_for_alarm(self, kind: str, state: str) -> dict[str, Any]:
        def found() -> dict[str, Any] | None:
            return next((a for a in self.alarms() if (a["kind"], a["state"]) == (kind, state)), None)

        alarm: dict[str, Any] = self.wait_for(found, f"an alarm {kind} {state}")
        return alarm

    def health(self) -> dict[str, Any]:
        """The next that is heard."""
        before_s = time.monotonic()

        def newest() -> dict[str, Any] | None:
            found = (s for s in reversed(self.heard) if s["key"].endswith("/health") and s["heard_s"] > before_s)
            return next(found, None)

        payload: dict[str, Any] = self.wait_for(newest, "health")["payload"]
        return payload

    def restarts(self) -> int:
        """Automatic ones, in this fault."""
        return int(shown("NRestarts")) - self.mark.restarts

    def journal(self) -> list[str]:
        """What the daemon logged in this fault."""
        return [line for line in self._said() if not PLACES.match(line)]

    def places(self) -> list[str]:
        """Where its threads were when it was aborted."""
        return [line for line in self._said() if PLACES.match(line)]

    def _said(self) -> list[str]:
        said = run("journalctl", "-u", SERVICE, "-o", "json")
        events = [json.loads(line) for line in said.splitlines() if line.startswith("{")]
        told = sorted((int(e["__MONOTONIC_TIMESTAMP"]) * 1e-6, str(e["MESSAGE"])) for e in events if by_the_daemon(e))
        return [message for when_s, message in told if when_s >= self.mark.begun_s]  # whatever the clock is set to

    def wait_for_restart(self) -> None:
        self.wait_for(lambda: self.restarts() > 0 and shown("ActiveState") == "active", "started anew")

    def wait_for_line(self, pattern: str) -> str:
        def found() -> str | None:
            return next((line for line in self.journal() if re.search(pattern, line)), None)

        return str(self.wait_for(found, f"{pattern!r} in the journal"))

    # -- what always holds -------------------------------------------------------------------------------------

    def assert_nothing_sent(self) -> None:
        assert Path("/sys/class/net/can0/statistics/tx_packets").read_text().strip() == "0", "the daemon sent a frame"

    def assert_sound(self, restarts: int = 0, alarms: Iterable[str] = (), *, once: bool = True) -> str:
        """Nothing is wrong but what has to be; a sentence of what is so in every fault.

        `alarms` are those that have to be raised; others about inputs may be, about brakes never.
        """
        self.wait_for(lambda: shown("ActiveState") == "active", "active")
        raised = {alarm["kind"] for alarm in self.alarms()}
        assert raised <= OF_INPUTS, f"false alarms: {raised - OF_INPUTS}"
        assert set(alarms) <= raised, f"missing alarms: {set(alarms) - raised}"
        assert self.restarts() == restarts, self.journal()
        self.assert_nothing_sent()
        lines = self.journal()
        assert not [line for line in lines if "Traceback" in line], lines
        assert len(lines) < 60, lines
        if once:
            numbers = [alarm["sequence"] for alarm in self.alarms()]
            assert numbers == list(range(numbers[0], numbers[0] + len(numbers))) if numbers else True, numbers
        told = ", ".join(sorted(raised)) or "none"
        return f"alarms: {told}; restarts: {restarts}; lines in the journal: {len(lines)}"
