"""`brake-monitor report`: one file that tells all of a recording."""

from argparse import ArgumentParser, Namespace

from brake_monitor.bus.can_log import open_log
from brake_monitor.commands import options as shared
from brake_monitor.commands.file_checks import beside, check_outputs, check_suffix
from brake_monitor.commands.playback import check_mapped, tell_remarks
from brake_monitor.desk.progress import with_progress
from brake_monitor.errors import InputError
from brake_monitor.host import extras
from brake_monitor.host.whole_file import whole_file
from brake_monitor.plural import plural
from brake_monitor.report.page import page
from brake_monitor.report.recording import Recording
from brake_monitor.settings.config_file import load_settings

DESCRIPTION = """\
Writes one HTML file about a recording that needs nothing else: a summary in words, alarms with their evidence, figures
to zoom into, brake applications, adhesion over slip, a map of slippery places where positions are mapped, wear, data
quality and settings. The same recording always gives the same bytes."""

EPILOG = """\
examples:
  brake-monitor report -c wagon.toml wsp.log -o wsp.html
  brake-monitor report -c wagon.toml wsp.log -o wsp.html --figures plots --format png   each figure also as a picture"""

FORMATS = ("svg", "png")


def add_options(parser: ArgumentParser) -> None:
    """Its options."""
    shared.add_config(parser)
    parser.add_argument("log", type=shared.path, metavar="LOG", help="the recording")
    parser.add_argument("-o", "--output", type=shared.path, required=True, metavar="OUT.html", help="the report")
    parser.add_argument(
        "--figures",
        type=shared.path,
        metavar="DIR",
        help="write every figure there as its own file (extra 'report')",
    )
    parser.add_argument("--format", choices=FORMATS, help="of these files (default: svg)")


def run(options: Namespace) -> int:
    """Play the recording, write the report."""
    if options.format is not None and options.figures is None:
        raise InputError("--format changes nothing but the figures: say where to write them with --figures DIR")
    if options.figures is not None:
        extras.require("report", "--figures")
        if options.figures.exists() and not options.figures.is_dir():
            raise InputError(f"--figures {options.figures}: expected a directory")
    settings = load_settings(options.config)
    check_outputs({"-o": options.output}, settings, options.log, options.figures)
    check_suffix(options.output, ".html", ".htm")
    log = open_log(options.log, settings.can)
    recording = Recording(settings)
    blocks = with_progress(log.blocks(), log.progress, f"playing {options.log.name}")
    recording.play(blocks, lambda: log.remarks, log.progress)
    name = options.log.name.encode(errors="replace").decode()  # what is no UTF-8 in it cannot be shown
    source = options.config.read_text(encoding="utf-8", errors="replace")
    text = page(recording, name, source)
    with whole_file(options.output) as part:
        part.write_text(text, encoding="utf-8")
    braked, alarms = plural(len(recording.applications), "brake application"), plural(len(recording.alarms), "alarm")
    print(f"{options.output}: {braked}, {alarms}", file=beside([options.output]))
    if options.figures is not None:
        from brake_monitor.report.figures import write_figures  # noqa: PLC0415 - needs an extra, and is slow to import

        for path in write_figures(recording, options.figures, options.format or FORMATS[0]):
            print(path, file=beside([options.output]))
    tell_remarks(log)
    check_mapped(recording.decoder.counts, options.log, options.config)
    return 0
