"""Fuzzing at length. Run: python tests/fuzz/run.py [FRAMES] [FILES_OF_EACH_KIND] [SEED] (1,000,000, 2000, 0).

Ends with status 1 at the first input that makes anything fail otherwise than by a refusal, and keeps that input.
"""

import logging
import random
import sys
import time
import traceback
from collections import Counter
from pathlib import Path
from tempfile import TemporaryDirectory

from fuzzing import TARGETS, is_taken, mutated, play, random_frames

logging.getLogger("can").setLevel(logging.CRITICAL)  # as the program does
frames, files, seed = (int(text) for text in (*sys.argv[1:], *("1000000", "2000", "0")[len(sys.argv) - 1 :]))

begun_s = time.monotonic()
estimates = play(random_frames(random.Random(seed)), frames)
print(f"{frames:,} frames, {estimates:,} estimates: {time.monotonic() - begun_s:.0f} s", flush=True)

with TemporaryDirectory() as name:
    folder = Path(name)
    for kind, target in TARGETS.items():
        begun_s = time.monotonic()
        good, counts = target.good(folder), Counter[bool]()
        for number in range(files):
            content = mutated(good, random.Random(f"{seed} {kind} {number}"))
            try:
                counts[is_taken(target.read, content, folder)] += 1
            except Exception:  # noqa: BLE001 - it is shown, and ends the run
                kept = Path(f"fuzz-{kind.replace(' ', '-')}-{seed}-{number}")
                kept.write_bytes(content)
                traceback.print_exc()
                sys.exit(f"{kind} number {number} fails; its content is in {kept}")
        print(f"{kind}: {counts[True]} taken, {counts[False]} refused: {time.monotonic() - begun_s:.0f} s", flush=True)
