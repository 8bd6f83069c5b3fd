"""What a replay costs, against what one would put together oneself.

Run: python tests/benchmarks/replay.py [--minutes 60]. Both read the same recording on the same core: ordinary service
of an example vehicle with 300 mapped frames a second and 1,200 others on the bus. Ours writes estimates and alarms,
what is put together (assembled.py) its filter's estimates alone. Each is a process of its own; the kernel tells its
processor time and memory, start included. "Live" is a mapped frame without reading and writing, as on a gateway:
without numba.
"""

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from heapq import merge
from itertools import count, islice, takewhile
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent)]  # when it is run as a script

CYCLES_MS = {  # that make 300 mapped frames a second
    "rig": {256: 8, 257: 8, 258: 20},
    "wagon": {288: 10, 416: 8, 672: 20, 673: 200, 800: 100, 2566869040: 100},
    "bogie": {
        2365530123: 10, 2365530379: 20, 2298425377: 20, 2298425378: 20, 2365538332: 40, 2566861089: 50, 2566865180: 200,
    },
}  # fmt: skip
WHEELSETS = {"rig": 1, "wagon": 2, "bogie": 4}
MAPPED_HZ, OTHERS_HZ = 300, 1200
OTHER_IDS = range(0x400, 0x418)  # no example vehicle has them
VEHICLES_MIN = 5.0  # of each example vehicle
LIVE_FRAMES = 50_000  # mapped: some three minutes
ROUNDS = 3

# Runs a script or module that finds none of these packages: python-can would load asammdf, and a gateway has no numba.
WITHOUT = """
import runpy, sys
left_out, sys.argv = sys.argv[1].split(","), sys.argv[2:]
sys.modules |= dict.fromkeys(left_out)
start = runpy.run_path if sys.argv[0].endswith(".py") else runpy.run_module
start(sys.argv[0], run_name="__main__")
"""


class Cost(NamedTuple):
    """Of a process, from its start to its end."""

    cpu_s: float
    peak_mb: float


def main(minutes: float) -> None:
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    with TemporaryDirectory() as name:
        folder = Path(name)
        run(__file__, "record", "wagon", minutes, folder)
        print(f"{minutes:g} min of ordinary service, 2 wheelsets, {MAPPED_HZ} mapped and {OTHERS_HZ} other frames/s")
        compare_formats(folder, minutes)
        compare_vehicles(folder, min(minutes, VEHICLES_MIN))


def compare_formats(folder: Path, minutes: float) -> None:
    """Both of them, from text and from BLF."""
    heading("", "CPU, s", "times real time", "against ours", "peak, MB")
    for suffix, kind in ((".log", "candump"), (".blf", "BLF")):
        config, log = folder / "wagon.toml", folder / f"wagon{suffix}"
        own, late, plain = ours(config, log), ours(late_speed(config), log), ours(config, log, "numba")
        costs = {"ours": own, "a late speed": late, "without numba": plain, "assembled": assembled(config, log)}
        for name, cost in costs.items():
            speed = f"{minutes * 60.0 / cost.cpu_s:.0f}"
            tell(f"{kind}, {name}", f"{cost.cpu_s:.1f}", speed, f"{cost.cpu_s / own.cpu_s:.1f}", f"{cost.peak_mb:.0f}")


def late_speed(config: Path) -> Path:
    """The same configuration with a vehicle speed that lags, for which all other samples wait."""
    late = config.with_name("late.toml")
    text = config.read_text(encoding="utf-8")
    late.write_text(text.replace("\nspeed = {", "\nspeed = { delay_s = 0.1,"), encoding="utf-8")
    return late


def compare_vehicles(folder: Path, minutes: float) -> None:
    """Both by the number of wheelsets, over a recording and live."""
    heading(f"wheelsets, {minutes:g} min", "ours, s", "assembled, s", "ratio", "live, µs", "assembled, µs", "ratio")
    for name, wheelsets in WHEELSETS.items():
        place = folder / name
        place.mkdir()
        run(__file__, "record", name, minutes, place)
        config, log = place / f"{name}.toml", place / f"{name}.log"
        replayed = ours(config, log).cpu_s, assembled(config, log).cpu_s
        lived = live("ours", config, log), live("assembled", config, log)
        pairs = ((own, other, other / own) for own, other in (replayed, lived))
        tell(str(wheelsets), *(f"{figure:.1f}" for pair in pairs for figure in pair))


def heading(name: str, *columns: str) -> None:
    print()
    tell(name, *columns)


def tell(name: str, *columns: str) -> None:
    """A line of a table."""
    print(f"{name:20}" + "".join(f"{column:>16}" for column in columns), flush=True)


def ours(config: Path, log: Path, *left_out: str) -> Cost:
    """Of a replay with machine code that is there already, unless numba is left out."""
    if "numba" not in left_out:
        run(__file__, "compile", config)
    out, alarms = log.with_name("ours.csv"), log.with_name("ours.jsonl")
    return run("brake_monitor", "replay", "-c", config, log, "-o", out, "--alarms", alarms, left_out=left_out)


def assembled(config: Path, log: Path) -> Cost:
    return run(HERE / "assembled.py", config, log, log.with_name("assembled.csv"))


def run(*arguments: object, left_out: Sequence[str] = ()) -> Cost:
    """A program of ours, or a script, to its end."""
    command = [sys.executable, "-c", WITHOUT, ",".join(("asammdf", *left_out)), *map(str, arguments)]
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    assert child.returncode == 0, arguments
    return Cost(usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1e3)


def live(what: str, config: Path, log: Path) -> float:
    """Processor time of a mapped frame, in µs, measured in a process of its own."""
    command = [sys.executable, "-c", WITHOUT, "asammdf,numba", __file__, "live", what, config, log]
    return float(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def compile_estimator(config: Path) -> None:
    """Have the machine code made that a replay looks for, if nobody has yet; it is kept."""
    from brake_monitor.compiled.code_maker import make  # noqa: PLC0415 - what only compares stays small
    from brake_monitor.compiled.kept_code import EstimatorOrder, KeptCode  # noqa: PLC0415
    from brake_monitor.processing.pipeline import Pipeline  # noqa: PLC0415
    from brake_monitor.settings.config_file import load_settings  # noqa: PLC0415

    code = KeptCode(EstimatorOrder.of(Pipeline.from_settings(load_settings(config)).estimator))
    if not code.is_ready:
        make(code.ordered())


def live_ours(config: Path, log: Path) -> float:
    """Of decoder, estimator and rules."""
    from brake_monitor.bus.can_log import open_log  # noqa: PLC0415 - what only compares stays small
    from brake_monitor.processing.pipeline import Pipeline  # noqa: PLC0415
    from brake_monitor.settings.config_file import load_settings  # noqa: PLC0415

    settings = load_settings(config)
    mapped = (frame for frame in open_log(log, settings.can) if frame.can_id not in OTHER_IDS)
    return per_frame_us(lambda: Pipeline.from_settings(settings).step, [*islice(mapped, LIVE_FRAMES)])


def live_assembled(config: Path, log: Path) -> float:
    """Of decoder and filter."""
    import can  # noqa: PLC0415

    from assembled import Assembled  # noqa: PLC0415

    with can.LogReader(log) as reader:
        mapped = [*islice((one for one in reader if one.arbitration_id not in OTHER_IDS), LIVE_FRAMES)]
    return per_frame_us(lambda: Assembled(config).take, mapped)


def per_frame_us(new: Callable[[], Callable[[Any], object]], frames: list[Any]) -> float:
    """What `new` makes takes all frames, made anew for each round; the round in the middle counts."""
    rounds_us = []
    for _ in range(ROUNDS):
        take = new()
        begun_s = time.process_time()
        for frame in frames:
            take(frame)
        rounds_us.append((time.process_time() - begun_s) / len(frames) * 1e6)
    return median(rounds_us)


def record(name: str, minutes: float, folder: Path) -> None:
    """Simulate a drive and write what the bus carried, as candump text and as BLF."""
    from brake_monitor.frame import Frame  # noqa: PLC0415
    from brake_monitor.settings.config_file import load_settings  # noqa: PLC0415
    from brake_monitor.simulator.files import write_log  # noqa: PLC0415
    from brake_monitor.simulator.ordinary_service import ordinary_disturbances, ordinary_service  # noqa: PLC0415
    from brake_monitor.simulator.simulate import run as simulate  # noqa: PLC0415

    settings = load_settings(vehicle_files(name, folder))
    disturbances = ordinary_disturbances(1, settings.vehicle.wheelset_count, in_train=False)
    frames = simulate(ordinary_service(1, minutes * 60.0), settings, 1, disturbances, row_s=0.01).frames
    begun_s = frames[0].time_s

    def others() -> Iterator[Frame]:
        for k in count():
            can_id = OTHER_IDS[k % len(OTHER_IDS)]
            yield Frame(begun_s + k / OTHERS_HZ, frames[0].bus, can_id, False, k.to_bytes(8, "little"))

    for suffix in (".log", ".blf"):
        on_the_bus = merge(frames, others(), key=lambda frame: frame.time_s)
        write_log(folder / f"{name}{suffix}", takewhile(lambda f: f.time_s < begun_s + minutes * 60.0, on_the_bus))


def vehicle_files(name: str, folder: Path) -> Path:
    """An example vehicle whose mapped messages come 300 times a second."""
    from bus_cycles import vehicle_with_cycles  # noqa: PLC0415

    return vehicle_with_cycles(name, folder, CYCLES_MS[name])


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["record", name, minutes, folder]:
            record(name, float(minutes), Path(folder))
        case ["compile", config]:
            compile_estimator(Path(config))
        case ["live", what, config, log]:
            print({"ours": live_ours, "assembled": live_assembled}[what](Path(config), Path(log)))
        case arguments:
            parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
            parser.add_argument("--minutes", type=float, default=5.0, help="of service (default: 5)")
            main(parser.parse_args(arguments).minutes)
