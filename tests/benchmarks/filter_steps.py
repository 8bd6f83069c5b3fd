"""How many filter steps a second one core does where recordings are taken at once: in `validate` and `tune`.

Run: python tests/benchmarks/filter_steps.py [--minutes 15]. A step is a prediction or a correction by one reading, with
all that belongs to it: alignment, doubts, work of the brakes. Machine code is compared with Python over the same
samples of ordinary service with 300 mapped frames a second, and with what the whole recording takes to decode.
"""

import argparse
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from brake_monitor.bus.can_log import open_log
from brake_monitor.compiled.compiled_estimator import CompiledEstimator
from brake_monitor.decoding.sample_block import SampleBlock
from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.estimation.estimator import Estimator
from brake_monitor.processing import whole_recording
from brake_monitor.processing.whole_recording import all_samples, take_all
from brake_monitor.samples import MEASURED, Quality
from brake_monitor.settings.config import Settings
from brake_monitor.settings.config_file import load_settings
from replay import WHEELSETS, record

ROUNDS = 3
TUNING_S = 0.05  # between the estimates that `tune` looks at


def steps(samples: SampleBlock) -> int:
    """Readings, and the instants that they come at."""
    measured = np.array([channel.quantity in MEASURED for channel in samples.channels])
    readings = measured[samples.channel] & (samples.quality == Quality.GOOD)
    return int(np.count_nonzero(readings)) + len(np.unique(samples.time_s[readings]))


def taken_s(settings: Settings, samples: SampleBlock, every_s: float, *, foretells: bool) -> float:
    """The least processor time of a few rounds."""

    def once() -> float:
        estimator = Estimator(settings.vehicle, settings.estimator, samples.channels, foretells=foretells)
        begun_s = time.process_time()
        take_all(estimator, samples, every_s)
        return time.process_time() - begun_s

    return min(once() for _ in range(ROUNDS))


def main(minutes: float) -> None:
    takers: dict[str, Callable[[Estimator], CompiledEstimator | None]] = {
        "machine code": CompiledEstimator,
        "Python": lambda _: None,
    }
    for vehicle, count in WHEELSETS.items():
        with TemporaryDirectory() as name:
            record(vehicle, minutes, Path(name))
            settings = load_settings(Path(name) / f"{vehicle}.toml")
            begun_s = time.process_time()
            log = open_log(Path(name) / f"{vehicle}.log", settings.can)
            samples = all_samples(SignalDecoder.from_settings(settings), log.blocks())
            print(f"{count} wheelsets, {steps(samples):,} steps; decoded in {time.process_time() - begun_s:.2f} s")
        for what, every_s, foretells in (
            ("estimates at each frame (validate)", 0.0, False),
            ("twenty a second (tune, by a truth)", TUNING_S, False),
            ("the likelihood (tune)", TUNING_S, True),
        ):
            found_s = {}
            for name, taker in takers.items():
                whole_recording.with_machine_code = taker  # whether it is kept on disk or not
                found_s[name] = taken_s(settings, samples, every_s, foretells=foretells)
            speeds = ", ".join(f"{name} {steps(samples) / of_s:,.0f} a second" for name, of_s in found_s.items())
            print(f"    {what}: {speeds}, ratio {found_s['Python'] / found_s['machine code']:.0f}", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--minutes", type=float, default=15.0, help="of service (default: 15)")
    main(parser.parse_args().minutes)
