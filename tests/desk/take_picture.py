"""Draws the terminal of the README anew: python tests/desk/take_picture.py [FILE.svg]

What `watch` shows of the demo's wagon in the midst of a slide.
"""

import sys
from io import StringIO
from pathlib import Path

from rich.console import Console

from brake_monitor.desk.watched import Watched
from brake_monitor.desk.watched_panel import panel
from brake_monitor.processing.pipeline import Outputs, Pipeline
from brake_monitor.publishing.about import about
from brake_monitor.publishing.payloads import AdhesionMessage, AlarmMessage, FrictionMessage, WearMessage
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.simulate import EPOCH_S
from brake_monitor.simulator.simulate import run as simulate

PICTURE = Path(__file__).parents[2] / "docs" / "img" / "live.svg"
MOMENT_S = EPOCH_S + 57.0  # in the stop on slippery rail
COLUMNS, LINES = 104, 24
FONTS = "DejaVu Sans Mono, Menlo, Consolas, monospace"  # Rich would have one fetched


def main(file: Path) -> None:
    """Write the picture."""
    console = Console(record=True, width=COLUMNS, height=LINES, file=StringIO())
    console.print(panel(watched(), MOMENT_S, COLUMNS, LINES))
    console.save_svg(str(file), title="brake-monitor demo")
    drawn = file.read_text()
    begin, end = drawn.index("@font-face"), drawn.index(".terminal-")
    file.write_text((drawn[:begin] + drawn[end:]).replace("Fira Code, monospace", FONTS))


def watched() -> Watched:
    """What is known of the wagon at that moment, heard as the daemon publishes it."""
    settings = example_settings("wagon")
    pipeline = Pipeline.from_settings(settings)
    known = Watched(settings.zenoh.prefix)
    known.lives(f"{settings.zenoh.prefix}/{settings.vehicle.id}", True)
    (wagon,) = known.wagons.values()
    wagon.take(about(settings, EPOCH_S), EPOCH_S)
    for frame in simulate("wsp", settings, 0).frames:
        if frame.time_s > MOMENT_S:
            break
        outputs = pipeline.step(frame)
        for message in said(outputs):
            wagon.take(message, frame.time_s)
    for i in (1, 2):
        wagon.take(WearMessage.of(pipeline.brake_book.brakes, i, settings.wear, 1, MOMENT_S), MOMENT_S)
    return known


def said(outputs: Outputs) -> list[AdhesionMessage | FrictionMessage | AlarmMessage]:
    """What is published of them; only the order of numbers and times matters here."""
    told = [AlarmMessage.of(alarm, 1, alarm.updated_time_s) for alarm in outputs.alarms]
    if (estimate := outputs.estimate) is None:
        return [*told]
    frictions = [FrictionMessage.of(estimate, i, 1, estimate.time_s) for i in (1, 2)]
    return [*told, AdhesionMessage.of(estimate, 1, estimate.time_s), *frictions]


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else PICTURE)
