"""Where the time of a replay goes: each stage by itself, over the same recording.

Run: python tests/benchmarks/stages.py [--minutes 5] [--vehicle wagon]. Figures are ms of processor time per second of
recording, on a bus with 300 mapped and 1,200 other frames a second, and shares of the whole; the shares are to be
compared. What is due ten times a second is timed within a play of everything.
"""

import argparse
import gc
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from brake_monitor.bus.can_log import open_log
from brake_monitor.compiled.compiled_estimator import CompiledEstimator
from brake_monitor.frame_block import FrameBlock
from brake_monitor.processing import estimate_table
from brake_monitor.processing.block_taker import OneByOne
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.settings.config import Settings
from brake_monitor.settings.config_file import load_settings
from replay import record

TENTH = 77  # samples that come in a tenth of a second


class Clock:
    """Adds up processor time by stage, and what the clock itself takes not."""

    def __init__(self) -> None:
        self.spent_s: Counter[str] = Counter()

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        begun_s = time.process_time()
        yield
        self.spent_s[name] += time.process_time() - begun_s

    def timed(self, name: str, function: Callable[..., Any]) -> Callable[..., Any]:
        def call(*arguments: Any, **named: Any) -> Any:
            begun_s = time.perf_counter()
            result = function(*arguments, **named)
            self.spent_s[name] += time.perf_counter() - begun_s
            return result

        return call


def stages(settings: Settings, log: Path) -> Counter[str]:
    """Of all stages, in s."""
    clock = Clock()
    with clock.stage("reading"):
        blocks = list(open_log(log, settings.can).blocks())
    decoder = Pipeline.from_settings(settings).decoder
    gc.disable()  # a replay does not keep all samples of a recording for it to look at
    with clock.stage("decoding"):
        decoded = [decoder.decode_block(block) for block in blocks]
    gc.enable()
    gc.freeze()
    pipeline = Pipeline.from_settings(settings)
    judge = pipeline._input_judge
    with clock.stage("watching the samples"):
        for samples in decoded:
            for begin in range(0, len(samples), TENTH):
                judge.see_together(samples, begin, min(begin + TENTH, len(samples)))
    for name, kind in (("estimator, in Python", OneByOne), ("estimator, machine code", CompiledEstimator)):
        taker = kind(Pipeline.from_settings(settings).estimator)
        with clock.stage(name):
            for samples in decoded:
                for begin in range(0, len(samples), TENTH):
                    taker.take(samples, begin, min(begin + TENTH, len(samples)))
                    taker.settle()
    everything(settings, blocks, clock)
    return clock.spent_s


def everything(settings: Settings, blocks: Iterable[FrameBlock], clock: Clock) -> None:
    """Play the recording, with a clock in the stages of what is due ten times a second."""
    pipeline = Pipeline.from_settings(settings)
    pipeline.taker = CompiledEstimator(pipeline.estimator)
    pipeline.taker.estimate = clock.timed("statement", pipeline.taker.estimate)  # type: ignore[method-assign]
    pipeline._input_judge.judge = clock.timed("inputs", pipeline._input_judge.judge)  # type: ignore[method-assign]
    pipeline.brake_book.see = clock.timed("brakes", pipeline.brake_book.see)  # type: ignore[method-assign]
    pipeline.monitor.see = clock.timed("rules", pipeline.monitor.see)  # type: ignore[method-assign]
    estimates = []
    with clock.stage("all but reading and writing"):
        for block in blocks:
            for outputs in pipeline.play(block):
                if outputs.estimate is not None:
                    estimates.append(outputs.estimate)
    with clock.stage("table rows"):
        for estimate in estimates:
            estimate_table.line(estimate)


def main(vehicle: str, minutes: float) -> None:
    with TemporaryDirectory() as name:
        folder = Path(name)
        record(vehicle, minutes, folder)
        settings = load_settings(folder / f"{vehicle}.toml")
        stages(settings, folder / f"{vehicle}.log")  # machine code is there from now on
        spent_s = stages(settings, folder / f"{vehicle}.log")
    whole_s = spent_s["reading"] + spent_s["all but reading and writing"] + spent_s["table rows"]
    for stage, stage_s in spent_s.items():
        per_second_ms = stage_s / (minutes * 60.0) * 1e3
        print(f"{stage:30} {per_second_ms:7.3f} ms/s {stage_s / whole_s:7.1%}")
    print(f"{'whole':30} {whole_s / (minutes * 60.0) * 1e3:7.3f} ms/s, {minutes * 60.0 / whole_s:.0f} times real time")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--minutes", type=float, default=5.0, help="of service (default: 5)")
    parser.add_argument("--vehicle", default="wagon", help="rig, wagon or bogie (default: wagon)")
    given = parser.parse_args()
    main(given.vehicle, given.minutes)
