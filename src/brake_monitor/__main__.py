"""`brake-monitor COMMAND …` and `python -m brake_monitor COMMAND …`: the process around a command."""

import logging
import os
import signal
import sys
from contextlib import suppress
from io import TextIOWrapper
from typing import NoReturn

INTERRUPTED = 130  # what a shell reports after SIGINT


class StandardError(TextIOWrapper):
    """What is said in vain, on a full disk or to a reader that went away, changes neither the work nor its end."""

    def write(self, text: str) -> int:
        """Write, or not."""
        with suppress(OSError):
            super().write(text)
        return len(text)

    def flush(self) -> None:
        """Write what waits, or not."""
        with suppress(OSError):
            super().flush()


def run() -> NoReturn:
    """Run the command and end with its exit code.

    Once Zenoh was loaded, without the interpreter's own shutdown: Zenoh's threads go on after a session was closed,
    and one that comes back into Python meanwhile aborts the process. All that was to be saved is saved by then.
    """
    if isinstance(told := sys.stderr, TextIOWrapper):  # None where the shell closed it
        sys.stderr = StandardError(told.buffer, told.encoding, told.errors, line_buffering=True)
    try:
        from brake_monitor.cli import main  # noqa: PLC0415 - Ctrl-C may come while it is loaded

        code = main()
    except KeyboardInterrupt:
        print("brake-monitor: interrupted", file=sys.stderr)
        code = INTERRUPTED
    except SystemExit as end:  # at SIGTERM, or of the parser
        code = end.code if isinstance(end.code, int) else 1
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # all is done: in the shutdown Ctrl-C would make it look as if not
    if "zenoh" in sys.modules:
        logging.shutdown()
        try:
            sys.stdout.flush()
        except OSError:  # nobody reads it any more
            code = code or 1
        sys.stderr.flush()
        os._exit(code)
    sys.exit(code)


if __name__ == "__main__":
    run()
