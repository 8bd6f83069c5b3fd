"""`brake-monitor run`: the daemon."""

import logging
import sys
import time
from argparse import ArgumentParser, Namespace, RawDescriptionHelpFormatter, _SubParsersAction
from contextlib import ExitStack, closing

from brake_monitor.about import about
from brake_monitor.commands import options as shared
from brake_monitor.config_file import load_settings
from brake_monitor.memory import FILE_NAME, Memory, state_directory
from brake_monitor.open_metrics import open_metrics
from brake_monitor.pipeline import Pipeline
from brake_monitor.publisher import Publisher
from brake_monitor.service import Service, stopped_by_signals
from brake_monitor.store_outbox import StoreOutbox

log = logging.getLogger(__name__)

DESCRIPTION = """\
Listens to the configured CAN bus until SIGTERM or Ctrl-C, estimates, and publishes over Zenoh.
It sends nothing to the bus. A bus that goes down is opened anew; a Zenoh router may come and go."""

EXAMPLES = """\
examples:
  brake-monitor run -c /etc/brake-monitor/wagon.toml
  brake-monitor check -c wagon.toml && brake-monitor run -c wagon.toml"""


def add_parser(subparsers: "_SubParsersAction[ArgumentParser]") -> None:
    """Describe the command."""
    parser = subparsers.add_parser(
        "run",
        help="the daemon: listen, estimate, publish",
        description=DESCRIPTION,
        epilog=EXAMPLES,
        formatter_class=RawDescriptionHelpFormatter,
    )
    shared.add_config(parser)
    parser.add_argument(
        "--log-level",
        choices=("debug", "info", "warning", "error"),
        default="info",
        help="least severity that is logged on standard error (default: info)",
    )
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Run the service until it is told to stop."""
    logging.basicConfig(
        stream=sys.stderr, level=options.log_level.upper(), format="%(levelname)s %(name)s: %(message)s"
    )
    logging.getLogger("can").setLevel(logging.CRITICAL)  # python-can logs what it raises as well
    settings = load_settings(options.config)
    pipeline = Pipeline.from_settings(settings)
    directory = state_directory(settings)
    with ExitStack() as stack:
        memory = outbox = publisher = None
        if directory is not None:
            outbox = stack.enter_context(closing(StoreOutbox(directory / FILE_NAME, settings.vehicle.id)))
            memory = stack.enter_context(Memory(settings, directory))
            memory.resume(pipeline)
        if settings.zenoh.enabled:
            publisher = Publisher(
                settings.zenoh, settings.vehicle.id, outbox=outbox, about=about(settings, time.time())
            )
        service = Service(settings, pipeline, publisher, memory=memory)
        service.open()  # before Zenoh: a daemon that has no bus must not be seen alive
        if memory is None:
            log.warning("there is no state directory: what is learned and worn is forgotten at the end")
        if publisher is not None:
            stack.enter_context(publisher)
            if settings.metrics.port:
                stack.enter_context(open_metrics(settings.metrics.port, lambda: publisher.health))
        with stopped_by_signals(service.stop):
            service.run()
    return 0
