"""What a replay costs by the length of the recording, from a minute to a day.

Run: python tests/benchmarks/lengths.py [--hours 24]. Ordinary service of the example wagon as in replay.py, as candump
text; what is longer than an hour repeats the hour, its clock running on. A day takes 6 GB where TMPDIR says.
"""

import argparse
import os
from itertools import groupby, islice
from pathlib import Path
from tempfile import TemporaryDirectory

from replay import MAPPED_HZ, OTHERS_HZ, heading, ours, run, tell

HERE = Path(__file__).parent
PARTS_MIN = (1.0, 5.0, 15.0, 60.0)
HOURS = (6, 24)
HOUR_S = 3600
PAUSE_S = 5  # between two playings
SECONDS = slice(1, 11)  # where a line of candump has its whole seconds: "(1700000000.005214) can0 1A0#00"


def main(hours: int) -> None:
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    with TemporaryDirectory() as name:
        folder = Path(name)
        run(HERE / "replay.py", "record", "wagon", HOUR_S / 60, folder)
        (folder / "wagon.log").rename(folder / "hour.log")
        heading("candump, minutes", "CPU, s", "ms per second", "times real time", "peak, MB")
        for minutes in PARTS_MIN:
            with (folder / "hour.log").open() as whole, (folder / "wagon.log").open("w") as part:
                part.writelines(islice(whole, int(minutes * 60.0 * (MAPPED_HZ + OTHERS_HZ))))
            measure(folder, minutes * 60.0)
        for times in (*(some for some in HOURS if some < hours), hours):
            repeat(folder / "hour.log", times, folder / "wagon.log")
            measure(folder, times * (HOUR_S + PAUSE_S))


def repeat(hour: Path, times: int, log: Path) -> None:
    """Write the frames of an hour so many times, each time later."""
    with log.open("w") as stream:
        for number in range(times):
            with hour.open() as frames:
                for second, lines in groupby(frames, key=lambda line: line[SECONDS]):
                    begin = f"({int(second) + number * (HOUR_S + PAUSE_S)}"
                    stream.writelines(begin + line[SECONDS.stop :] for line in lines)


def measure(folder: Path, length_s: float) -> None:
    """Play what lies there and tell of it."""
    cost = ours(folder / "wagon.toml", folder / "wagon.log")
    per_s, speed = f"{cost.cpu_s / length_s * 1e3:.2f}", f"{length_s / cost.cpu_s:.0f}"
    tell(f"{length_s / 60.0:.0f}", f"{cost.cpu_s:.1f}", per_s, speed, f"{cost.peak_mb:.0f}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--hours", type=int, default=24, help="the longest (default: 24)")
    main(parser.parse_args().hours)
