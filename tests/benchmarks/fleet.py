"""A fleet through one router: CPU, latency and loss. Run: python tests/benchmarks/fleet.py [WAGONS] [SECONDS].

Each wagon is a publisher of ours with a session of its own, giving out an estimate at 10 Hz (two wheelsets: five
messages) and an alarm every ten seconds; they share four processes. The router and the one dashboard, which hears
everything, are processes of their own.
"""

import json
import os
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from statistics import quantiles
from typing import IO, Any

import zenoh
from zenoh import ext

TESTS = Path(__file__).parents[1]
sys.path.insert(0, str(TESTS))
RATE_HZ = 10.0
PROCESSES = 4
CLOCK_TICKS = os.sysconf("SC_CLK_TCK")


def wagons(endpoint: str, first: int, count: int, seconds: float) -> None:
    """One process full of wagons; they start when told, and spread over the period."""
    from brake_monitor.host.python_can import load_cantools_alone  # noqa: PLC0415 - only this process needs it

    load_cantools_alone()  # as `brake-monitor` does
    from brake_monitor.processing.pipeline import Outputs  # noqa: PLC0415
    from brake_monitor.publishing.publisher import Publisher  # noqa: PLC0415
    from brake_monitor.settings.zenoh_settings import ZenohSettings  # noqa: PLC0415
    from estimates import alarm, estimate  # noqa: PLC0415
    from program import until  # noqa: PLC0415

    settings = ZenohSettings(connect=(endpoint,), listen=())
    publishers = [Publisher(settings, f"wagon-{first + i:03}") for i in range(count)]
    for publisher in publishers:
        publisher.start()
    print("ready", flush=True)
    sys.stdin.readline()
    begun_s = time.time()
    turns, alarms_given = int(seconds * RATE_HZ), 0
    for turn in range(turns):
        for i, publisher in enumerate(publishers):
            due_s = begun_s + (turn + i / count) / RATE_HZ
            time.sleep(max(0.0, due_s - time.time()))
            alarms = (alarm(id=f"a-{turn}"),) if turn % 100 == 50 else ()
            publisher.publish(Outputs(estimate(time_s=time.time()), alarms))
            alarms_given += len(alarms)
    time.sleep(2.0)
    counters = [publisher.counters for publisher in publishers]
    until(lambda: sum(c.estimates_sent + c.estimates_replaced for c in counters) == turns * count)
    until(lambda: sum(c.events_sent for c in counters) == alarms_given)
    print(
        json.dumps(
            {
                "given": turns * count,
                "sent": sum(c.estimates_sent for c in counters),
                "replaced": sum(c.estimates_replaced for c in counters),
                "alarms": sum(c.events_sent for c in counters),
            }
        ),
        flush=True,
    )
    for publisher in publishers:
        publisher.close()


def dashboard(endpoint: str) -> None:
    """Hear everything; tell how many wagons live, how many messages came and how old they were, whenever told to."""
    latencies_s: list[float] = []
    heard = {"adhesion": 0, "axle": 0, "alarm": 0}

    def note(sample: zenoh.Sample) -> None:
        now_s = time.time()
        kind = str(sample.key_expr).split("/")[3]
        heard[kind] += 1
        if kind == "adhesion":
            latencies_s.append(now_s - json.loads(sample.payload.to_bytes())["time_s"])

    config = zenoh.Config.from_json5(json.dumps({"mode": "client", "connect": {"endpoints": [endpoint]}}))
    with zenoh.open(config) as session:
        history = ext.HistoryConfig(detect_late_publishers=True)
        subscribers = [session.declare_subscriber(f"brake/v1/*/{key}", note) for key in ("adhesion", "axle/**")]
        with ext.declare_advanced_subscriber(session, "brake/v1/*/alarm/**", note, history=history):
            print("ready", flush=True)
            for _ in sys.stdin:
                lives = sum(reply.ok is not None for reply in session.liveliness().get("brake/v1/*"))
                print(json.dumps({"lives": lives} | heard | ages(latencies_s)), flush=True)
        for subscriber in subscribers:
            subscriber.undeclare()


def ages(latencies_s: list[float]) -> dict[str, float]:
    """Of what came from capture to dashboard; nothing came yet while the fleet gathers."""
    if not latencies_s:
        return {}
    cuts = quantiles(latencies_s, n=1000)
    return {"p50_ms": cuts[499] * 1e3, "p99_ms": cuts[989] * 1e3, "max_ms": max(latencies_s) * 1e3}


def router(endpoint: str) -> None:
    """A router in Python."""
    values = {"mode": "router", "listen": {"endpoints": [endpoint]}, "scouting": {"multicast": {"enabled": False}}}
    with zenoh.open(zenoh.Config.from_json5(json.dumps(values))):
        print("ready", flush=True)
        sys.stdin.readline()


class Child:
    """One of the above in a process of its own."""

    def __init__(self, *arguments: object) -> None:
        self._process = subprocess.Popen(
            [sys.executable, __file__, *map(str, arguments)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self.line() == "ready"

    def say(self) -> None:
        stdin: IO[str] | None = self._process.stdin
        assert stdin is not None
        print(file=stdin, flush=True)

    def asked(self) -> dict[str, Any]:
        """What it tells when told to."""
        self.say()
        told: dict[str, Any] = json.loads(self.line())
        return told

    def line(self) -> str:
        assert self._process.stdout is not None
        return self._process.stdout.readline().strip()

    def cpu_s(self) -> float:
        """Processor time used so far."""
        fields = Path(f"/proc/{self._process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / CLOCK_TICKS

    def end(self) -> None:
        self._process.kill()
        with self._process:
            pass


def main(count: int, seconds: float) -> dict[str, Any]:
    """Run the fleet and tell the figures."""
    from network import free_port  # noqa: PLC0415
    from program import until  # noqa: PLC0415

    endpoint = f"tcp/127.0.0.1:{free_port()}"
    children = [Child("router", endpoint), Child("dashboard", endpoint)]
    share = count // PROCESSES
    try:
        children += [Child("wagons", endpoint, i * share, share, seconds) for i in range(PROCESSES)]
        until(lambda: children[1].asked()["lives"] == share * PROCESSES)
        time.sleep(3.0)
        before_s, begun_s = [child.cpu_s() for child in children], time.monotonic()
        for child in children[2:]:
            child.say()
        given = [json.loads(child.line()) for child in children[2:]]
        took_s = time.monotonic() - begun_s
        used = [(child.cpu_s() - before) / took_s for child, before in zip(children, before_s, strict=True)]
        sent, alarms = (sum(one[k] for one in given) for k in ("sent", "alarms"))
        with suppress(AssertionError):  # what is on its way still is not lost
            until(lambda: children[1].asked().items() >= {"adhesion": sent, "axle": sent * 4, "alarm": alarms}.items())
        heard = children[1].asked()
    finally:
        for child in children:
            child.end()
    return {
        "wagons": share * PROCESSES,
        "messages per second": round((sent * 5) / took_s),
        "estimates given, replaced, sent": [sum(one[k] for one in given) for k in ("given", "replaced", "sent")],
        "estimates lost on the way": sent - heard["adhesion"],
        "wheelset messages lost": sent * 4 - heard["axle"],
        "alarms sent, heard": [alarms, heard["alarm"]],
        "capture to dashboard, ms": {k: round(heard[f"{k}_ms"], 1) for k in ("p50", "p99", "max")},
        "share of a core": {
            "router": round(used[0], 2),
            "dashboard": round(used[1], 2),
            "per wagon": round(sum(used[2:]) / (share * PROCESSES), 4),
        },
    }


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["router", endpoint]:
            router(endpoint)
        case ["dashboard", endpoint]:
            dashboard(endpoint)
        case ["wagons", endpoint, first, count, seconds]:
            wagons(endpoint, int(first), int(count), float(seconds))
        case [count, seconds]:
            print(json.dumps(main(int(count), float(seconds)), indent=2))
        case _:
            print(json.dumps(main(200, 30.0), indent=2))
