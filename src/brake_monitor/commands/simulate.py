"""`brake-monitor simulate`: a recording, or live traffic, from the independent plant."""

import logging
from argparse import ArgumentParser, ArgumentTypeError, Namespace
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import replace

import can

from brake_monitor.bus.can_socket import reason_of
from brake_monitor.bus.python_can_bus import CANNOT_OPEN
from brake_monitor.commands import options as shared
from brake_monitor.commands.file_checks import beside, check_outputs
from brake_monitor.errors import InputError, WorkError
from brake_monitor.frame import Frame
from brake_monitor.plural import plural
from brake_monitor.settings.config import Settings
from brake_monitor.settings.config_file import load_settings
from brake_monitor.settings.example_vehicles import EXAMPLES, example_config
from brake_monitor.simulator.due import dues
from brake_monitor.simulator.files import check_log_kind, counts_from_s, write_due, write_log, write_truth
from brake_monitor.simulator.live import play
from brake_monitor.simulator.ordinary_service import SERVICE, ordinary_service
from brake_monitor.simulator.physics.coupler import GivenPull, SpringToTrain
from brake_monitor.simulator.physics.motors import Motors
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.scenarios import SCENARIOS
from brake_monitor.simulator.simulate import TRUTH_STEP_S, Recording
from brake_monitor.simulator.simulate import run as simulate
from brake_monitor.simulator.troubles import TROUBLES

DESCRIPTION = """\
Simulates a braking and writes what the wagon's CAN bus carried, and the truth behind it.
The plant has its own physics and shares no equation with the estimator."""

MINUTES = 30.0  # of service
MINUTES_OF_SERVICE = shared.number("minutes, 0.1 to 600", 0.1, 600.0)
FADE_KMH = 20.0
SCENARIO_LIST = "\n".join(
    (
        "brakings:",
        *(f"  {s.name:<25} {s.summary}" for s in SCENARIOS.values()),
        "\nsomething is wrong:",
        *(f"  {t.name:<25} {t.scenario.summary}" for t in TROUBLES.values()),
        "\nnothing is wrong:",
        f"  {SERVICE:<25} ordinary service of a coupled wagon, --minutes of it",
    )
)

EPILOG = f"""\
{SCENARIO_LIST}

examples:
  brake-monitor simulate wsp -o wsp.log --truth wsp.csv        candump log and truth (two-axle wagon)
  brake-monitor simulate leaf --vehicle bogie -o leaf.blf      four wheelsets, another log format
  brake-monitor simulate dry -c mine.toml -o dry.log           your vehicle, your DBC
  brake-monitor simulate dry --vehicle railcar --motors 1,2 -o blended.log    motors brake, pads do the rest
  brake-monitor simulate stuck -o stuck.log --due due.jsonl    a fault, and the alarms that are due by its truth
  brake-monitor simulate wsp --bus socketcan:vcan0             live onto a bus, in real time"""


def add_options(parser: ArgumentParser) -> None:
    """Its options."""
    parser.add_argument("scenario", choices=(*SCENARIOS, *TROUBLES, SERVICE), metavar="SCENARIO", help="see below")
    parser.add_argument("-o", "--output", type=shared.path, metavar="LOG", help="the log; its suffix names the format")
    what = "the truth, 100 rows a second, times as in the log"
    parser.add_argument("--truth", type=shared.path, metavar="CSV", help=what)
    parser.add_argument("--due", type=shared.path, metavar="JSONL", help="alarms due by the truth, one per line")
    parser.add_argument("--bus", type=_bus, metavar="INTERFACE:CHANNEL", help="send the frames on a python-can bus")
    parser.add_argument("--speed", type=shared.speed, metavar="FACTOR", help="of real time on the bus (default: 1)")
    parser.add_argument(
        "--seed",
        type=shared.seed,
        default=0,
        metavar="N",
        help="the same seed gives the same frames, in .log, .csv and .blf the same bytes",
    )
    parser.add_argument("--minutes", type=MINUTES_OF_SERVICE, metavar="M", help=f"of service (default: {MINUTES:g})")
    vehicle = parser.add_mutually_exclusive_group()
    vehicle.add_argument(
        "-c", "--config", type=shared.path, metavar="CONFIG", help="simulate this vehicle with its DBC"
    )
    vehicle.add_argument("--vehicle", choices=EXAMPLES, default="wagon", help="an example vehicle (default: wagon)")
    parser.add_argument(
        "--motors",
        type=_wheelsets,
        metavar="1,2",
        help="wheelsets with motors, which drive the wagon and brake before their pads do; mapped as wheel_torque",
    )
    parser.add_argument(
        "--motors-fade",
        type=shared.number("km/h, 1 to 200", 1.0, 200.0),
        metavar="KM/H",
        help=f"below it pads take over from motors, wholly at half of it (default: {FADE_KMH:g})",
    )
    truth = parser.add_argument_group("what the estimator does not know")
    truth.add_argument(
        "--gradient", type=_between(-0.1, 0.1), default=0.0, metavar="RISE", help="rise over run, 0.01 is 10 per mille"
    )
    train = truth.add_mutually_exclusive_group()
    for name, coupled, said in (
        ("--coupler", GivenPull, "the train pulls by 20 ± 10 kN per 36 t while braking"),
        ("--spring-coupler", SpringToTrain, "a spring to a train that brakes at its own rate"),
    ):
        train.add_argument(name, dest="train", action="store_const", const=coupled, help=said)
    truth.add_argument(
        "--mass-factor", type=_between(0.2, 5.0), default=1.0, metavar="F", help="true over configured mass"
    )
    truth.add_argument(
        "--wheel-factor", type=_between(0.8, 1.2), default=1.0, metavar="F", help="true over configured wheel radius"
    )
    truth.add_argument(
        "--run-out",
        type=_between(0.0, 0.05),
        default=0.0,
        metavar="SHARE",
        help="eccentricity of the pole wheels over the radius of their teeth: wheel speeds tell as much too high and "
        "too low once a revolution",
    )
    truth.add_argument(
        "--frame-loss", type=_between(0.0, 0.99), default=0.0, metavar="SHARE", help="frames that never arrive, 0..1"
    )
    truth.add_argument("--no-slide-protection", action="store_true", help="a goods wagon: its wheels may lock")


def _between(least: float, greatest: float) -> Callable[[str], float]:
    return shared.number(f"a number from {least:g} to {greatest:g}", least, greatest)


def _wheelsets(text: str) -> frozenset[int]:
    """Wheelsets from 0."""
    try:
        numbers = [int(number) for number in text.split(",")]
    except ValueError:
        numbers = [0]
    if min(numbers) < 1:
        raise ArgumentTypeError(f"expected numbers of wheelsets such as 1,2, got {text!r}")
    return frozenset(number - 1 for number in numbers)


def _bus(text: str) -> tuple[str, str]:
    interface, colon, channel = text.partition(":")
    if not (interface and colon and channel):
        raise ArgumentTypeError(f"expected INTERFACE:CHANNEL such as socketcan:vcan0, got {text!r}")
    return interface, channel


def run(options: Namespace) -> int:
    """Simulate, then write and play what was asked for."""
    settings = _checked(options)
    with _opened(options.bus) if options.bus else nullcontext() as bus:
        recording = _simulated(options, settings)
        _write(options, recording)
        stream = beside([options.output, options.truth, options.due])
        print(_told(options.scenario, recording), file=stream, flush=True)
        if bus is not None:
            _play_live(recording.frames, bus, options)
    trouble = TROUBLES.get(options.scenario)
    if trouble and trouble.pad_above_limit_mm is not None:
        thickness_mm = recording.settings.wear.new_pad_thickness_mm
        print(
            f"its pads begin with what a configuration says as [wear] new_pad_thickness_mm = {thickness_mm:g}; the "
            "margins of [alarms.pad_near_limit] and [alarms.pad_at_limit] have to leave room for them",
            file=stream,
        )
    return 0


def _checked(options: Namespace) -> Settings:
    """The settings; InputError where the options do not go together, with them or with each other."""
    if not (options.output or options.truth or options.due or options.bus):
        raise InputError("simulate: nothing to do: give -o LOG, --truth CSV, --due JSONL or --bus INTERFACE:CHANNEL")
    if options.speed is not None and not options.bus:
        raise InputError("--speed changes nothing but the sending: say on which bus with --bus INTERFACE:CHANNEL")
    if options.minutes is not None and options.scenario != SERVICE:
        raise InputError(f"--minutes changes nothing but '{SERVICE}': '{options.scenario}' takes as long as it takes")
    settings = load_settings(options.config or example_config(options.vehicle))
    if max(options.motors or [0]) >= settings.vehicle.wheelset_count:
        raise InputError(f"--motors: the vehicle has {plural(settings.vehicle.wheelset_count, 'wheelset')}")
    if options.motors_fade is not None and options.motors is None:
        raise InputError("--motors-fade changes nothing but motors: say on which wheelsets with --motors 1,2")
    check_outputs({"-o": options.output, "--truth": options.truth, "--due": options.due}, settings)
    if options.output:
        check_log_kind(options.output, settings.can)
    return settings


def _simulated(options: Namespace, settings: Settings) -> Recording:
    """The drive that was asked for; a trouble's own faults come on top of the options."""
    name, seed, modifiers = options.scenario, options.seed, _modifiers(options)
    if name == SERVICE:
        return simulate(
            ordinary_service(seed, (options.minutes or MINUTES) * 60.0), settings, seed, modifiers, row_s=TRUTH_STEP_S
        )
    trouble = TROUBLES.get(name)
    if trouble is None:
        return simulate(name, settings, seed, modifiers)
    if settings.vehicle.wheelset_count < trouble.least_wheelsets:
        raise InputError(f"{name}: expected a vehicle with at least {trouble.least_wheelsets} wheelsets")
    faults = trouble.modifiers
    modifiers = replace(
        modifiers,
        gradient=modifiers.gradient + faults.gradient,
        slide_protection=modifiers.slide_protection and faults.slide_protection,
        brake_faults=faults.brake_faults,
        sensor_faults=faults.sensor_faults,
        bus_faults=faults.bus_faults,
    )
    return simulate(trouble.scenario, trouble.settings(settings), seed, modifiers, row_s=TRUTH_STEP_S)


def _modifiers(options: Namespace) -> Modifiers:
    return Modifiers(
        gradient=options.gradient,
        train=options.train,
        mass_factor=options.mass_factor,
        wheel_radius_factor=(options.wheel_factor,),
        motors=Motors(options.motors, (options.motors_fade or FADE_KMH) / 3.6) if options.motors else None,
        run_out=options.run_out,
        frame_loss=options.frame_loss,
        slide_protection=not options.no_slide_protection,
    )


def _write(options: Namespace, recording: Recording) -> None:
    if options.output:
        write_log(options.output, recording.frames, recording.settings.can)
    log_zero_s = counts_from_s(options.output, recording.frames) if options.output else 0.0
    if options.truth:
        write_truth(options.truth, recording, log_zero_s)
    if options.due:
        write_due(options.due, dues(recording), log_zero_s)


def _opened(address: tuple[str, str]) -> can.BusABC:
    interface, channel = address
    logging.getLogger("can.bus").setLevel(logging.CRITICAL)  # it complains of a bus that could not be set up, besides
    try:
        return can.Bus(channel=channel, interface=interface)
    except (*CANNOT_OPEN, can.CanError, OSError) as error:
        raise InputError(f"--bus {interface}:{channel}: cannot be opened: {reason_of(error)}") from None


def _play_live(frames: Sequence[Frame], bus: can.BusABC, options: Namespace) -> None:
    try:
        play(frames, bus, options.speed or 1.0)
    except can.CanError as error:
        raise WorkError(f"{':'.join(options.bus)}: cannot send: {error}") from error


def _told(scenario: str, recording: Recording) -> str:
    return (
        f"{scenario}: {recording.duration_s:.0f} s, {plural(len(recording.frames), 'frame')}, "
        f"{plural(recording.settings.vehicle.wheelset_count, 'wheelset')}, seed {recording.seed}"
    )
