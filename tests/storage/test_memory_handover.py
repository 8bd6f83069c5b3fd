"""What waits to be written, and in which directory."""

import time
from pathlib import Path

from brake_monitor.processing.remembered import Remembered
from brake_monitor.storage.memory_directory import MemoryDirectory
from brake_monitor.storage.memory_handover import MemoryHandover
from brake_monitor.storage.store_batch import Batch
from brake_states import WHEELSETS, batch


def test_the_writing_thread_has_work_only_where_something_waits_that_may_be_written() -> None:
    """Else it would turn for nothing, and so would the gateway's processor."""
    handover = MemoryHandover()
    assert not handover._has_work()
    handover.give(batch(1), [])
    assert not handover._has_work()  # what the disk holds is not known yet
    assert handover.take_batch() is None
    handover.note_resumed({})
    assert handover._has_work()
    taken = handover.take_batch()
    assert taken is not None
    assert (taken.brakes, taken.applications) == (
        None,
        batch(1).applications,
    )  # a state made without what the disk holds is none
    assert not handover._has_work()
    assert handover.take_batch() == Batch()


def test_the_writing_thread_rests_as_long_as_nothing_is_to_be_written() -> None:
    handover = MemoryHandover()
    handover.note_resumed({})
    began_s = time.monotonic()
    assert not handover.wait(0.2, for_work=True)
    assert time.monotonic() - began_s >= 0.2
    handover.give(batch(1), [])
    assert not handover.wait(60.0, for_work=True)
    handover.close()
    assert handover.wait(60.0, for_work=False)
    assert time.monotonic() - began_s < 60.0


def test_nobody_else_may_look_into_the_memory(tmp_path: Path) -> None:
    place = tmp_path / "state" / "wagon-1"
    directory = MemoryDirectory(place, "wagon-1", WHEELSETS)
    directory.lock()
    directory.unlock()
    assert place.stat().st_mode & 0o077 == 0
    assert (place / "lock").stat().st_mode & 0o077 == 0
    directory.lock()  # it is there already
    directory.unlock()


def test_what_was_found_is_given_once_also_while_the_pipeline_is_about_to_go_on_with_it() -> None:
    """Its wear would count twice."""
    handover = MemoryHandover()
    assert handover.offer(Remembered())
    handover.take_news()
    assert not handover.offer(Remembered())
    assert not handover.has_news
