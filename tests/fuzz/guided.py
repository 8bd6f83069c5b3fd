"""Fuzzing guided by coverage: an input that reaches something new is spoilt further. Needs: pip install atheris.

Run: python tests/fuzz/guided.py KIND [FOLDER] [LIBFUZZER_OPTIONS], for instance 'recording .log' -max_total_time=600.
FOLDER holds what earlier runs have found, and takes what this one finds. Ends with status 1, and keeps the input,
where anything fails otherwise than by a refusal.
"""

import logging
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import atheris

with atheris.instrument_imports(include=["brake_monitor", "can", "cantools"]):
    from fuzzing import TARGETS, is_taken

logging.getLogger("can").setLevel(logging.CRITICAL)  # as the program does
kinds = ", ".join(f"'{kind}'" for kind in TARGETS)
if len(sys.argv) < 2 or sys.argv[1] not in TARGETS:
    sys.exit(f"expected a KIND, one of {kinds}")
target = TARGETS[sys.argv[1]]

with TemporaryDirectory() as name:
    folder = Path(name)
    (begin := folder / "begin").mkdir()
    (begin / "good").write_bytes(target.good(folder))
    atheris.Setup([sys.argv[0], *sys.argv[2:], str(begin)], lambda content: is_taken(target.read, content, folder))
    atheris.Fuzz()
