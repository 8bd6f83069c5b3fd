"""The bar that tells how far a long work is."""

import sys
from io import StringIO

import pytest

from brake_monitor.desk.progress import with_progress


class Terminal(StringIO):
    def isatty(self) -> bool:
        return True


def test_it_names_what_is_read_as_it_is_written_and_passes_all_on(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.setattr(sys, "stderr", Terminal())
    assert list(with_progress([1, 2], lambda: 0.5, "reading trip[a].log")) == [1, 2]
    assert "reading trip[a].log" in sys.stderr.getvalue()
