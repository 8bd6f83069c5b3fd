"""A file that appears whole or not at all."""

import errno
import os
import subprocess
import sys
from pathlib import Path
from typing import Never

import pytest

from brake_monitor.errors import WorkError
from brake_monitor.host.whole_file import whole_file


def test_a_name_that_no_disk_takes_is_told_in_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(WorkError, match="cannot be written"), whole_file(tmp_path / ("a" * 300)):
        pytest.fail("there is nothing to write to")


def test_a_directory_is_told_before_anything_is_written(tmp_path: Path) -> None:
    with pytest.raises(WorkError, match="it is a directory"), whole_file(tmp_path):
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


def test_a_disk_that_becomes_read_only_is_told_with_the_name_that_was_given(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing can be removed from it either, the unfinished file included."""

    def refuse(path: Path, *_: object, **__: object) -> Never:
        raise OSError(errno.EROFS, os.strerror(errno.EROFS), str(path))

    for change in ("replace", "unlink"):
        monkeypatch.setattr(Path, change, refuse)
    with pytest.raises(WorkError) as told, whole_file(tmp_path / "table.csv") as part:
        part.write_text("new")
    assert str(told.value) == f"{tmp_path / 'table.csv'}: cannot be written: Read-only file system"


@pytest.mark.parametrize("was_there", [True, False])
def test_a_link_stays_one_and_what_it_leads_to_is_written(tmp_path: Path, was_there: bool) -> None:
    (tmp_path / "disk").mkdir()
    target, link = tmp_path / "disk" / "table.dat", tmp_path / "table.csv"
    if was_there:
        target.write_text("old")
    (tmp_path / "between").symlink_to("disk/table.dat")
    link.symlink_to("between")
    with whole_file(link) as part:
        assert part.suffix == ".csv"
        part.write_text("new")
    assert link.is_symlink()
    assert target.read_text() == "new"
    assert list(target.parent.iterdir()) == [target]


def test_what_a_process_has_open_is_written_to_and_not_replaced(tmp_path: Path) -> None:
    """As where a link leads to /dev/stdout."""
    link, opened = tmp_path / "table.csv", tmp_path / "opened"
    with opened.open("w+") as file:
        link.symlink_to(f"/proc/self/fd/{file.fileno()}")
        with whole_file(link) as part:
            part.write_text("new")
        assert file.read() == "new"
    assert link.is_symlink()
    assert sorted(tmp_path.iterdir()) == [opened, link]


def test_links_that_lead_in_a_circle_are_told_in_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "a").symlink_to("b")
    (tmp_path / "b").symlink_to("a")
    with pytest.raises(WorkError, match="a: cannot be written: Too many levels"), whole_file(tmp_path / "a"):
        pytest.fail("there is nothing to write to")


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
