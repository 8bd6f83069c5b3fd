"""A progress bar on long work: on a terminal only, and only where rich is installed."""

import sys
from collections.abc import Callable, Iterable, Iterator
from itertools import count
from typing import TypeVar

Item = TypeVar("Item")


def with_progress(items: Iterable[Item], done: Callable[[], float], title: str) -> Iterator[Item]:
    """Pass the items on and show how much is done (0..1), asked before each of them, on standard error."""
    if not sys.stderr.isatty():
        yield from items
        return
    try:
        from rich.console import Console  # noqa: PLC0415 - an extra, and slow to import
        from rich.markup import escape  # noqa: PLC0415
        from rich.progress import Progress  # noqa: PLC0415
    except ImportError:
        yield from items
        return
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(escape(title), total=1.0)
        for item in items:
            bar.update(task, completed=done())
            yield item


def counted(items: Iterable[Item], total: int, title: str) -> Iterator[Item]:
    """The same where there are to be `total` items."""
    before = count()  # how many items there were before each
    return with_progress(items, lambda: next(before) / total, title)
