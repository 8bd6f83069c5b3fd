"""`brake-monitor observability`: what the sensors can tell about friction and adhesion, and what they cannot."""

from argparse import ArgumentParser, ArgumentTypeError, Namespace
from pathlib import Path

from brake_monitor.commands import options as shared
from brake_monitor.commands.file_checks import beside, check_outputs
from brake_monitor.observability.figure import FORMATS, draw
from brake_monitor.observability.survey import Survey
from brake_monitor.observability.tables import text
from brake_monitor.settings.config_file import load_settings

DESCRIPTION = """\
Shows what the vehicle's sensors can tell about pad friction mu_b, adhesion mu_w and the unmodelled
deceleration d: rank and smallest singular value of the map from the states to [y, dy/dt],
y = wheel speeds and vehicle speed, over pressing force, speed and adhesion."""

EPILOG = """\
examples:
  brake-monitor observability -c wagon.toml                the tables
  brake-monitor observability -c wagon.toml -o map.svg     and a figure (.svg or .png; extra 'report')
  brake-monitor observability -c wagon.toml --window 2     a window of two seconds instead of half a second"""

WINDOW_S = 0.5  # about as long as WSP leaves a pressure alone
LONGEST_WINDOW_S = 86400.0  # far beyond, what the samples weigh is no number any more


def add_options(parser: ArgumentParser) -> None:
    """Its options."""
    shared.add_config(parser)
    parser.add_argument("-o", "--output", type=_figure_path, metavar="FIGURE", help="draw a figure, .svg or .png")
    parser.add_argument(
        "--window",
        type=shared.number("a positive number of seconds, 86400 at the most", shared.SMALLEST, LONGEST_WINDOW_S),
        default=WINDOW_S,
        metavar="SECONDS",
        help=f"how long the sensors are looked at (default {WINDOW_S:g})",
    )


def run(options: Namespace) -> int:
    """Print the tables; draw the figure where one is asked for."""
    settings = load_settings(options.config)
    check_outputs({"-o": options.output}, settings)
    survey = Survey.of(settings, options.window)
    if options.output is not None:
        draw(survey, options.output)
    print(text(survey), file=beside([options.output]))
    return 0


def _figure_path(text: str) -> Path:
    path = Path(text)
    if path.suffix.lower() not in FORMATS:
        raise ArgumentTypeError(f"expected a file name that ends in {' or '.join(FORMATS)}, got {text!r}")
    return path
