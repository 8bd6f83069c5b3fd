"""A file that appears whole or not at all."""

import subprocess
import sys
from pathlib import Path

import pytest

from brake_monitor.errors import WorkError
from brake_monitor.host.whole_file import whole_file


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


OTHER = """
import sys
from pathlib import Path
from brake_monitor.host.whole_file import whole_file
with whole_file(Path(sys.argv[1])) as part, part.open("w") as file:
    print("begun", file=file, flush=True)
    print("begun", flush=True)
    print(input(), file=file)
"""


def test_two_processes_that_write_the_same_file_do_not_mix_it(tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    command = [sys.executable, "-c", OTHER, str(path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "begun\n"
        with whole_file(path) as part:
            part.write_text("ours")
        assert path.read_text() == "ours"
        other.communicate("ended\n", timeout=60.0)
    assert other.returncode == 0
    assert path.read_text() == "begun\nended\n"
    assert list(tmp_path.iterdir()) == [path]
