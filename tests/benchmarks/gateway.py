"""What the daemon costs on a gateway: until READY=1, of a core on a full bus, from capture to a subscriber, of memory.

Run: python tests/benchmarks/gateway.py [--seconds 60]. It boots tests/guest/run, whose kernel has a CAN bus, and starts
the daemon as systemd would, without the packages that a gateway does not have. A sender plays ordinary service of the
example wagon with 300 mapped frames a second, alone or on a bus that is full with others; a subscriber compares when an
estimate arrives with when its frame was captured. Daemon, sender and subscriber share the guest's one slow CPU, of
which they get less than all while this machine is busy with something else. The guest samples processor time 100 times
a second. What the kernel's filter itself costs is in the sender's time, for a virtual bus delivers while it is sent to.

Before that the mapped frames go to a daemon on this machine itself, whose kernel need not know CAN: as datagrams of the
same bytes, which it stamps likewise, to a socket in the place of the daemon's. There system calls cost what they do
elsewhere, and daemon, sender and subscriber have a core each.
"""

import argparse
import json
import os
import re
import signal
import socket
import struct
import subprocess
import sys
import time
from collections.abc import Iterator
from heapq import merge
from itertools import chain, count, takewhile
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

sys.path.insert(0, str(Path(__file__).parent))  # when it is run as a script, or by one
sys.path.insert(0, str(Path(__file__).parents[1]))

import brake_monitor
from brake_monitor.bus.candump_log import parse_line
from program import BRAKE_MONITOR, Program
from replay import OTHER_IDS, WITHOUT, vehicle_files

HERE = Path(__file__).parent
UNIT = HERE.parents[1] / "systemd" / "brake-monitor.service"
CHANNEL = "vcan0"
FULL_HZ, MAPPED_HZ = 7400, 300  # of eight bytes, at 1 Mbit/s
BURST_S = 0.001  # the sender wakes as often
HASTE = 1.01  # else cycles of 10 ms keep in step with the guest's samples of processor time, and it errs by a half
STARTS = 5
SETTLED_S = 2.5  # before and after the frames: health is told once a second
ENOUGH_S = 60.0  # for any start
GUEST_S = 900
NOT_THERE = "asammdf,numba"  # on a gateway
COLUMNS = (
    *("frames/s", "sender, %", "daemon, %", "missing", "dropped"),
    *("p50, ms", "p99, ms", "Zenoh, ms", "start, MB", "end, MB"),
)
UNFILTERED = (HERE / "gateway.py", "unfiltered")
AS_DATAGRAMS = (HERE / "gateway.py", "datagrams")
LOOPBACK = "127.0.0.1"
PORT = "BUS_PORT"  # in the environment: where the datagrams go


class Load(NamedTuple):
    """What the daemon was given, and what it cost."""

    sent_hz: float
    sender_share: float  # of the CPU
    daemon_share: float
    missing_frames: int  # mapped ones that it never saw
    dropped_frames: int  # by the kernel, as its health says
    latencies_s: list[float]  # capture → subscriber, ascending
    published_s: float  # capture → given to Zenoh, on average over all estimates, as its health says
    start_mb: float
    end_mb: float


def main(seconds: float) -> None:
    with TemporaryDirectory() as name:
        folder = Path(name)
        config = vehicle_files("wagon", folder)
        minutes = str(seconds / 60.0)
        run(BRAKE_MONITOR, "simulate", "service", "-c", config, "--minutes", minutes, "-o", folder / "mapped.log")
        text = re.sub('^channel = ".*?"', f'channel = "{CHANNEL}"', config.read_text(), flags=re.MULTILINE)
        config.write_text(text)
        virtual = folder / "virtual.toml"
        virtual.write_text(text.replace('"socketcan"', '"virtual"'))
        tell("READY=1 after, s", "this machine", f"{ready_s(virtual):.2f}")
        print()
        tell("on the bus", *COLUMNS)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
            free.bind((LOOPBACK, 0))
            os.environ[PORT] = str(free.getsockname()[1])
        show("mapped only", load(config, folder / "mapped.log", 0, seconds, *AS_DATAGRAMS))
        del os.environ[PORT]
        print()
        environment = f"PYTHONPATH={Path(brake_monitor.__file__).parents[1]}"
        guest = [HERE.parent / "guest" / "run", "--share", folder, "--timeout", str(GUEST_S), "--"]
        inside = ["env", environment, sys.executable, __file__, "guest", folder, str(seconds)]
        subprocess.run([*guest, *inside], check=True)


def in_guest(folder: Path, seconds: float) -> None:
    """All that needs a bus."""
    config, log = folder / "wagon.toml", folder / "mapped.log"
    tell("", "the guest", f"{ready_s(config):.2f}")
    print()
    tell("on the bus", *COLUMNS)
    for name, others_hz, command in (
        ("mapped only", 0, ()),
        ("full", FULL_HZ - MAPPED_HZ, ()),
        ("full, no filter", FULL_HZ - MAPPED_HZ, UNFILTERED),
    ):
        show(name, load(config, log, others_hz, seconds, *command))


def run(*command: str | Path) -> str:
    """What a program said that has to succeed."""
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


def tell(name: str, *columns: str) -> None:
    """A line of a table."""
    print(f"{name:18}" + "".join(f"{column:>13}" for column in columns), flush=True)


def show(name: str, seen: Load) -> None:
    """A line of the table of loads."""
    shares = (f"{100.0 * share:.1f}" for share in (seen.sender_share, seen.daemon_share))
    times = (percentile(seen.latencies_s, 0.5), percentile(seen.latencies_s, 0.99), seen.published_s)
    tell(
        name,
        f"{seen.sent_hz:.0f}",
        *shares,
        str(seen.missing_frames),
        str(seen.dropped_frames),
        *(f"{1e3 * time_s:.2f}" for time_s in times),
        f"{seen.start_mb:.1f}",
        f"{seen.end_mb:.1f}",
    )


def percentile(ascending: list[float], share: float) -> float:
    return ascending[int(share * (len(ascending) - 1))]


class Daemon(Program):
    """The daemon, started as its unit does and ready; `command` is another script that runs it."""

    def __init__(self, config: Path, folder: Path, *command: str | Path) -> None:
        (folder / "state").mkdir()
        os.environ |= {
            "NOTIFY_SOCKET": str(folder / "notify"),
            "STATE_DIRECTORY": str(folder / "state"),
            "WATCHDOG_USEC": "20000000",
            **dict(re.findall(r"^Environment=(\w+)=(.*)$", UNIT.read_text(), re.MULTILINE)),
        }
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as told:
            told.bind(os.environ["NOTIFY_SOCKET"])
            begun_s = time.monotonic()
            ours = command or ("brake_monitor", "run", "-c")
            super().__init__(sys.executable, "-c", WITHOUT, NOT_THERE, *ours, config)
            told.settimeout(ENOUGH_S)
            try:
                while b"READY=1" not in told.recv(4096).splitlines():
                    pass
            except TimeoutError:
                raise AssertionError("\n".join(("never ready, but:", *self.lines))) from None
            self.ready_s = time.monotonic() - begun_s
        self._proc = Path("/proc") / str(self._process.pid)

    def cpu_s(self) -> float:
        """Of all its threads, in user and kernel mode."""
        fields = (self._proc / "stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def resident_mb(self) -> float:
        match = re.search(r"VmRSS:\s+(\d+) kB", (self._proc / "status").read_text())
        assert match is not None
        return int(match[1]) * 1024 / 1e6


def ready_s(config: Path) -> float:
    """Seconds from exec to READY=1, the start in the middle; one before them fills the caches, also of bytecode."""
    os.environ |= {"PYTHONPYCACHEPREFIX": str(config.with_name("bytecode")), "PYTHONDONTWRITEBYTECODE": ""}
    seen_s = []
    for _ in range(1 + STARTS):
        with TemporaryDirectory() as name, Daemon(config, Path(name)) as daemon:
            seen_s.append(daemon.ready_s)
            daemon.end()
    return median(seen_s[1:])


def load(config: Path, log: Path, others_hz: int, seconds: float, *command: str | Path) -> Load:
    """A new daemon, with so much on its bus."""
    with TemporaryDirectory() as name, Daemon(config, Path(name), *command) as daemon:
        start_mb = daemon.resident_mb()
        endpoint = daemon.wait_for(r"Zenoh session open, (?:on )?(\S+)")[1]
        with Program(sys.executable, __file__, "subscribe", endpoint) as subscriber:
            subscriber.wait_for("subscribed")
            time.sleep(SETTLED_S)
            before_s = daemon.cpu_s()
            sent = json.loads(run(sys.executable, __file__, "send", log, str(others_hz), str(seconds)))
            cpu_s = daemon.cpu_s() - before_s
            time.sleep(SETTLED_S)
            subscriber.end()
            heard = json.loads(subscriber.lines[-1])
        latencies_s, published_s = while_sent(heard, sent["begun_s"] + 1.0, sent["begun_s"] + sent["took_s"])
        return Load(
            sent_hz=(sent["mapped"] + sent["others"]) / sent["took_s"],
            sender_share=sent["cpu_s"] / sent["took_s"],
            daemon_share=cpu_s / sent["took_s"],
            missing_frames=sent["mapped"] - heard["health"][-1]["mapped_frames"],
            dropped_frames=heard["health"][-1]["dropped_frames"],
            latencies_s=latencies_s,
            published_s=published_s,
            start_mb=start_mb,
            end_mb=daemon.resident_mb(),
        )


def while_sent(heard: dict[str, Any], begun_s: float, ended_s: float) -> tuple[list[float], float]:
    """Latencies while there were frames: without, estimates are of a time that is kept behind on purpose."""
    latencies_s = [arrived_s - time_s for time_s, arrived_s in heard["adhesion"] if begun_s <= time_s <= ended_s]
    told = [health for health in heard["health"] if begun_s <= health["publish_time_s"] <= ended_s]
    first, last = ((health["latency_sum_s"], sum(health["latency_counts"])) for health in (told[0], told[-1]))
    return sorted(latencies_s), (last[0] - first[0]) / (last[1] - first[1])


def send(log: Path, others_hz: int, seconds: float) -> dict[str, float]:
    """Send the recording's frames, each when its time has come, and so many others evenly between them."""
    sent, others = 0, 0
    with bus_to_send_on() as opened:
        due = takewhile(lambda frame: frame[0] < seconds, merge(recorded(log), other_frames(others_hz)))
        begun_s, zero_s, cpu_s = time.time(), time.monotonic(), time.process_time()
        for time_s, is_mapped, packed in due:
            while time_s > (time.monotonic() - zero_s) * HASTE:
                time.sleep(BURST_S)
            opened.send(packed)
            sent += 1
            others += not is_mapped
        took_s, cpu_s = time.monotonic() - zero_s, time.process_time() - cpu_s
    return {"mapped": sent - others, "others": others, "begun_s": begun_s, "took_s": took_s, "cpu_s": cpu_s}


def bus_to_send_on() -> socket.socket:
    if port := os.environ.get(PORT):
        opened = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        opened.connect((LOOPBACK, int(port)))
        return opened
    opened = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
    opened.bind((CHANNEL,))
    return opened


def recorded(log: Path) -> Iterator[tuple[float, bool, bytes]]:
    """The frames of a candump log: when, that they are mapped, as the socket takes them."""
    with log.open() as stream:
        frames = map(parse_line, stream)
        first = next(frames)
        for frame in chain([first], frames):
            flag = socket.CAN_EFF_FLAG if frame.extended else 0
            yield frame.time_s - first.time_s, True, packed_frame(frame.can_id | flag, frame.data)


def other_frames(rate_hz: int) -> Iterator[tuple[float, bool, bytes]]:
    """Likewise, without end, with ids that are not mapped."""
    if rate_hz:
        for k in count():
            yield k / rate_hz, False, packed_frame(OTHER_IDS[k % len(OTHER_IDS)], k.to_bytes(8, "little"))


def packed_frame(flagged_id: int, data: bytes) -> bytes:
    return struct.pack("=IB3x8s", flagged_id, len(data), data)


def subscribe(endpoint: str) -> dict[str, list[Any]]:
    """Until SIGTERM: of each estimate its time and when it arrived, and what was told of the daemon's health."""
    import zenoh  # noqa: PLC0415 - the sender stays small

    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM})
    values = {"mode": "client", "connect": {"endpoints": [endpoint]}, "scouting": {"multicast": {"enabled": False}}}
    heard: dict[str, list[Any]] = {"adhesion": [], "health": []}

    def take_estimate(sample: zenoh.Sample) -> None:
        arrived_s = time.time()
        heard["adhesion"].append((json.loads(sample.payload.to_bytes())["time_s"], arrived_s))

    def take_health(sample: zenoh.Sample) -> None:
        heard["health"].append(json.loads(sample.payload.to_bytes()))

    with zenoh.open(zenoh.Config.from_json5(json.dumps(values))) as session:
        keys = {"brake/v1/*/adhesion": take_estimate, "brake/v1/*/health": take_health}
        subscribers = [session.declare_subscriber(key, take) for key, take in keys.items()]
        print("subscribed", flush=True)
        signal.sigwait({signal.SIGTERM})
        for subscriber in subscribers:
            subscriber.undeclare()
    return heard


def run_unfiltered(config: str) -> None:
    """The daemon, but the kernel lets every frame through to it."""
    from brake_monitor import cli  # noqa: PLC0415
    from brake_monitor.bus import can_source  # noqa: PLC0415
    from brake_monitor.bus.can_socket import CanSocket  # noqa: PLC0415

    can_source.CanSocket = lambda channel, _filters, bus: CanSocket(channel, (), bus)  # type: ignore[assignment,misc]
    sys.exit(cli.main(["run", "-c", config]))


def run_on_datagrams(config: str) -> None:
    """The daemon, but its frames come as datagrams."""
    from brake_monitor import cli  # noqa: PLC0415
    from brake_monitor.bus import can_socket, can_source  # noqa: PLC0415

    class DatagramSocket(can_socket.CanSocket):
        def __init__(self, _channel: str, _filters: object, bus: str) -> None:
            self.dropped = 0
            self._bus = bus
            self._timeout_s = None
            opened = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            opened.setsockopt(socket.SOL_SOCKET, can_socket._SO_TIMESTAMPNS, 1)
            opened.bind((LOOPBACK, int(os.environ[PORT])))
            self._recvmsg, self._setsockopt, self._shutdown = opened.recvmsg, opened.setsockopt, opened.close

    can_source.CanSocket = DatagramSocket  # type: ignore[misc]
    can_source._check_link = lambda _bus, _place: None  # there is no interface
    sys.exit(cli.main(["run", "-c", config]))


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["guest", folder, seconds]:
            in_guest(Path(folder), float(seconds))
        case ["send", log, others_hz, seconds]:
            print(json.dumps(send(Path(log), int(others_hz), float(seconds))))
        case ["subscribe", endpoint]:
            print(json.dumps(subscribe(endpoint)))
        case ["unfiltered", config]:
            run_unfiltered(config)
        case ["datagrams", config]:
            run_on_datagrams(config)
        case arguments:
            parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
            parser.add_argument("--seconds", type=float, default=60.0, help="of each load (default: 60)")
            main(parser.parse_args(arguments).seconds)
