"""A file that appears whole or not at all."""

from pathlib import Path

import pytest

from brake_monitor.errors import WorkError
from brake_monitor.whole_file import whole_file


def test_a_name_that_no_disk_takes_is_told_in_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(WorkError, match="cannot be written"), whole_file(tmp_path / ("a" * 300)):
        pytest.fail("there is nothing to write to")


def test_what_was_there_stays_until_the_new_one_is_complete(tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    path.write_text("old")
    with pytest.raises(UnicodeEncodeError), whole_file(path) as part:
        part.write_text("half of it and then \ud800", encoding="utf-8")
    assert path.read_text() == "old"
    with whole_file(path) as part:
        part.write_text("new")
    assert path.read_text() == "new"
    assert list(tmp_path.iterdir()) == [path]
