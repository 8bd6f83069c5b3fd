"""Estimates as a Parquet file: the columns of the CSV, typed, in full precision, each with its unit in its metadata."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from brake_monitor.estimation.estimate import Estimate
from brake_monitor.host import extras
from brake_monitor.host.whole_file import whole_file
from brake_monitor.processing import estimate_table
from brake_monitor.processing.estimate_table import Form
from brake_monitor.value_names import unit_of

ROWS_AT_ONCE = 20_000  # in memory, and in each row group of the file

Write = Callable[[Iterable[Estimate]], None]


@contextmanager
def parquet_table(path: Path, wheelset_count: int) -> Iterator[Write]:
    """Yield a function that appends estimates; the file appears when it is complete. InputError without the extra."""
    extras.require("parquet", "Parquet")
    import pyarrow as pa  # noqa: PLC0415 - an extra, and slow to import
    from pyarrow import parquet  # noqa: PLC0415

    schema = pa.schema([_field(pa, *column) for column in estimate_table.columns(wheelset_count).items()])
    rows: list[tuple[estimate_table.Value, ...]] = []
    with whole_file(path) as part, parquet.ParquetWriter(part, schema) as file:

        def flush() -> None:
            columns = zip(*rows, strict=True)
            file.write_batch(
                pa.record_batch([pa.array(c, f.type) for c, f in zip(columns, schema, strict=True)], schema)
            )
            rows.clear()

        def write(estimates: Iterable[Estimate]) -> None:
            rows.extend(map(estimate_table.values, estimates))
            if len(rows) >= ROWS_AT_ONCE:
                flush()

        yield write
        if rows:
            flush()


def _field(pa: Any, name: str, form: Form) -> Any:
    kinds = {Form.WORD: pa.string(), Form.FLAG: pa.bool_(), Form.COUNT: pa.int64()}
    return pa.field(name, kinds.get(form, pa.float64()), metadata={"unit": unit_of(name)})
