"""A progress bar on long work: on a terminal only, and only where rich is installed."""

import sys
from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

Item = TypeVar("Item")

REDRAW_EVERY = 2000  # items


def with_progress(
    items: Iterable[Item], done: Callable[[], float], title: str, every: int = REDRAW_EVERY
) -> Iterator[Item]:
    """Pass the items on and show how much is done (0..1) on standard error, updated after every `every` items."""
    if not sys.stderr.isatty():
        yield from items
        return
    try:
        from rich.console import Console  # noqa: PLC0415 - an extra, and slow to import
        from rich.progress import Progress  # noqa: PLC0415
    except ImportError:
        yield from items
        return
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(title, total=1.0)
        for count, item in enumerate(items):
            if count % every == 0:
                bar.update(task, completed=done())
            yield item
