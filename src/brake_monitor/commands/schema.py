"""`brake-monitor schema`: the JSON Schemas of what is published."""

from argparse import ArgumentParser, Namespace

from brake_monitor.commands import options as shared
from brake_monitor.errors import InputError
from brake_monitor.host.whole_file import make_folder, whole_file
from brake_monitor.publishing.payload_schemas import TYPES, schema

DESCRIPTION = """\
Writes the JSON Schema of every payload that is published over Zenoh, made from the very types that are encoded.
The daemon answers the same on <prefix>/<wagon>/schema/<name>."""

EPILOG = """\
examples:
  brake-monitor schema                    what schemas there are
  brake-monitor schema alarm              one of them, on standard output
  brake-monitor schema -o docs/schema     all of them, one file each"""


def add_options(parser: ArgumentParser) -> None:
    """Its options."""
    what = "which one to print; left out, their names are"
    parser.add_argument("name", nargs="?", metavar="NAME", choices=tuple(TYPES), help=what)
    parser.add_argument("-o", "--output", type=shared.path, metavar="DIR", help="write all of them here")


def run(options: Namespace) -> int:
    """Print or write schemas."""
    if options.output is not None and options.name is not None:
        sentence = f"all schemas are written there: leave out {options.name!r}, or -o to print it"
        raise InputError(f"-o {options.output}: {sentence}")
    if options.output is not None:
        make_folder(options.output)
        for name in TYPES:
            with whole_file(options.output / f"{name}.json") as part:
                part.write_bytes(schema(name))
    elif options.name is not None:
        print(schema(options.name).decode(), end="")
    else:
        print("\n".join(TYPES))
    return 0
