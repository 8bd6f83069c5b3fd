"""Writes to a memory from processes that are killed at random instants; looks after each what is left.

    python killed_writer.py FILE SEED ROUNDS      prints the number of rounds, writes and kills in the midst of a write

One process is forked per round, for it would take long to start anew; what it has written it tells through a pipe.
"""

import os
import random
import signal
import struct
import sys
import time
from pathlib import Path

from brake_monitor.storage.store import Store
from brake_monitor.storage.store_batch import RECORDS_KEPT
from brake_states import WHEELSETS, batch, brakes, learned

NUMBER = struct.Struct("<q")
LONGEST_LIFE_S = 0.03
KILLED_EARLY = 0.3  # as many, while the file may be still being opened or made


def write_until_killed(path: Path, number: int, told: int) -> None:
    store = Store.open(path, "w", WHEELSETS)
    while True:
        number += 1
        store.write(batch(number))
        os.write(told, NUMBER.pack(number))


def look(path: Path) -> int:
    """The number of the last write; everything that was written with it is there, and everything before."""
    with Store.open(path, "w", WHEELSETS) as store:
        found = store.remembered()
        messages = list(store.messages())
        number = messages[-1][0] if messages else 0
        if number == 0:
            assert found.brakes is None
            assert found.learned is None
            return 0
        assert found.brakes is not None
        assert found.brakes.units == brakes(number).units
        assert found.learned == learned(number)
        assert [int(message) for _, message in messages] == list(range(1, number + 1))
        oldest = max(number - RECORDS_KEPT, 0) + 1
        assert [round(stop.start_time_s - 1.7e9) for stop in store.applications(number)] == list(
            range(oldest, number + 1)
        )
        assert [alarm.id for alarm in found.open_alarms] == [f"hot_disc-1-{i}" for i in range(1, number + 1)]
        return number


def main(path: Path, seed: int, rounds: int) -> None:
    chance = random.Random(seed)
    number = in_the_midst = 0
    for _ in range(rounds):
        heard, told = os.pipe()
        child = os.fork()
        if child == 0:
            os.close(heard)
            write_until_killed(path, number, told)
        os.close(told)
        first = b"" if chance.random() < KILLED_EARLY else os.read(heard, NUMBER.size)  # waits for a write
        time.sleep(chance.uniform(0.0, LONGEST_LIFE_S))
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        with os.fdopen(heard, "rb") as pipe:
            acknowledged = [n for (n,) in NUMBER.iter_unpack(first + pipe.read())]
        before, number = number, look(path)
        last = acknowledged[-1] if acknowledged else before
        assert last <= number <= last + 1, f"{last} was written, {number} is there"
        in_the_midst += number > last
    print(rounds, number, in_the_midst)


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
