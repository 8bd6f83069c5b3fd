"""The layers, enforced from the imports. This table is the architecture: a module that is not in it is a failure."""

import ast
from fnmatch import fnmatchcase
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest

import brake_monitor

ROOT = Path(brake_monitor.__file__).parent


class Layer(NamedTuple):
    """Modules of one layer in order (each may import those before it) and the other layers that they may import."""

    modules: str
    sees: str


def within(folder: str, modules: str) -> str:
    """The folder, and its modules by their whole names."""
    return " ".join([folder, *(f"{folder}.{module}" for module in modules.split())])


LAYERS = {
    "words": Layer(
        "__init__ errors nearest plural digits value_names arrays frame frame_block samples figure_style", ""
    ),
    "settings": Layer(
        within(
            "settings",
            "bounds key_space units alarm_settings wear_settings store_settings zenoh_settings config toml_lines "
            "config_text typed_table vehicle_check settings_check config_file example_vehicles",
        ),
        "words",
    ),
    "dbc": Layer("decoding.raw_number decoding.signal_field decoding.dbc", "words settings"),
    # From frame to alarm: no threads, no clock, no input or output.
    "decoding": Layer(
        within(
            "decoding",
            "decode_counts j1939 matching rolling_counter qualifier mapped_signal ordinary_frame sample_block "
            "signal_table time_outs routing message_decoder block_decoder run_out pole_wheel signals",
        ),
        "words settings dbc",
    ),
    "estimation": Layer(
        within(
            "estimation",
            "brake_work estimate "
            "kalman kalman.straight_line kalman.ekf kalman.foretold "
            "inputs inputs.alignment inputs.held_input inputs.pad_contact inputs.slide_protection "
            "rolling rolling.radius_calibration rolling.line_roughness "
            "doubts doubts.plausibility doubts.force_gate doubts.frozen_reading doubts.force_departure "
            "doubts.force_trend doubts.still_force doubts.still_speeds doubts.spike_watch doubts.force_timing "
            "doubts.dead_force doubts.seizing "
            "doubts.consistency doubts.braking_reference "
            "model model.friction_pause model.acting model.state_layout model.load_distribution model.wheelset "
            "model.wagon model.tuning model.regime model.brake_step "
            "moment "
            "filter filter.belief filter.physical filter.filter_lines filter.brake_filter filter.tape "
            "learned "
            "core core.core_numbers core.motor_watch core.regime_watch core.prediction core.friction_doubt "
            "core.change_doubt core.correction core.core core.new_core core.readout "
            "input_trust known_inputs statement earlier_run turning_points estimator",
        ),
        "words settings",
    ),
    "inspection": Layer(
        within(
            "inspection",
            "first_hour speed_lag force_lag lags repeated coarse wandering wheels_mean pulled arrivals traffic rates "
            "batches friction_size force_size remarks",
        ),
        "words settings decoding estimation",
    ),
    # What programs want of the machine they run on. Nothing from frame to alarm does.
    "host": Layer(within("host", "extras pacing whole_file python_can stop_signals processes"), "words"),
    # The same as machine code, for desk tools; a gateway has no numba.
    "compiled": Layer(
        within(
            "compiled",
            "code_folder machine_code inlining numba_classes held_tuple compiled_core compiled_estimator kept_code "
            "code_maker",
        ),
        "words host settings decoding estimation",
    ),
    "monitoring": Layer(
        within(
            "monitoring",
            "alarm reports misled passing_time running_mean contact_stiffness creep_meter brake_units "
            "brake_units.application_record brake_units.running_wheelset brake_units.running_application "
            "brake_units.application_recorder brake_units.wear brake_units.disc_temperature brake_units.brakes "
            "brake_units.gauge brake_units.brake_book inputs inputs.retardation inputs.watched_force "
            "inputs.pressed_brakes inputs.nominal_brakes inputs.fallen_force inputs.force_by_creep "
            "inputs.force_by_retardation inputs.force_watch inputs.flag_watch inputs.wheel_state "
            "inputs.vehicle_speed inputs.holding_force inputs.descent inputs.speed_bursts "
            "inputs.speed_scale inputs.odd_turning inputs.turning "
            "inputs.watched_wheelset inputs.wagon_past inputs.speed_doubt inputs.wheel_watch inputs.refusals "
            "inputs.lone_inputs inputs.frozen_forces inputs.dead_forces inputs.scatter_watch inputs.block_watch "
            "inputs.input_judge bus_watch observation rule alarm_cycle rules rules.earlier_count rules.event_end "
            "rules.slippery_stretch rules.low_adhesion rules.wheelset_not_rotating rules.slide rules.losses "
            "rules.bus_pace "
            "rules.inputs rules.buses rules.memory_failing rules.creep_shares rules.agreed_shares rules.told_apart "
            "rules.per_application rules.participation rules.rolled_way "
            "rules.block_means rules.hidden_drag rules.lasting_creep rules.dragging_brake rules.brake_not_applied "
            "rules.uneven_braking rules.mean_friction rules.friction_out_of_band rules.friction_drift rules.hot_disc "
            "rules.pads rules.all_rules monitor",
        ),
        "words settings decoding estimation",
    ),
    "processing": Layer(
        within(
            "processing",
            "at_hand remembered turns stretches block_taker aligned_taker pipeline playing whole_recording "
            "estimate_table smoother",
        ),
        "words settings decoding estimation compiled monitoring",
    ),
    # The edges of the daemon.
    "bus": Layer(
        within(
            "bus",
            "candump_log eight_digits candump_blocks text_lines blf_blocks time_order gathering damage mf4 can_message "
            "log_channels trc_reader can_log can_link can_socket python_can_bus can_source",
        ),
        "words host settings",
    ),
    "storage": Layer(
        within(
            "storage",
            "store_schema store_file store_batch plausible_brakes store store_outbox evidence memory_directory "
            "memory_handover memory_writer memory",
        ),
        "words host settings estimation monitoring processing bus",
    ),
    "publishing": Layer(
        within(
            "publishing",
            "encoding payloads payload_schemas about outbox published answers health open_metrics handover event_queue "
            "zenoh_endpoints zenoh_session zenoh_opening zenoh_callback zenoh_namesake zenoh_neighbour zenoh_link "
            "publisher",
        ),
        "words host settings estimation monitoring processing",
    ),
    "daemon": Layer(
        within(
            "daemon",
            "sd_notify log_lines alarm_log frame_clock bus_reader capture_order buses watchdog service succession",
        ),
        "words settings monitoring processing bus storage publishing",
    ),
    # The plant that the estimator is judged by shares none of its equations, so it sees none of its modules.
    "simulator": Layer("simulator.*", "words host settings dbc"),
    "desk": Layer(
        within(
            "desk",
            "json_lines parquet_table progress text_marks foreign_message watched watched_lines wagon_panel "
            "watched_panel fleet_listener",
        ),
        "words host settings estimation monitoring processing publishing",
    ),
    "observability": Layer(
        within("observability", "directions analysis survey tables figure"),
        "words host settings dbc decoding estimation",
    ),
    "dashboard": Layer(
        within("dashboard", "recent fleet views hearing visitors server"),
        "words estimation monitoring publishing desk",
    ),
    "report": Layer(
        within("report", "words curves recording summary tables track_map page figures"),
        "words host settings decoding estimation inspection monitoring processing dashboard",
    ),
    "validation": Layer("validation.*", "words host settings decoding estimation compiled processing simulator"),
    "alarm_campaign": Layer("alarm_campaign.*", "words settings monitoring processing simulator validation"),
    "tuner": Layer("tuner.*", "words host settings decoding estimation compiled processing validation"),
    "commands": Layer(
        "commands.* cli __main__",
        "words host settings decoding estimation inspection monitoring processing bus storage publishing daemon "
        "simulator desk dashboard report observability validation alarm_campaign tuner",
    ),
}

# Who may touch the world. What is not named here is free to all (numpy, msgspec, most of the standard library).
CAPABILITIES = {
    "can": "host.python_can bus.can_message bus.blf_blocks bus.mf4 bus.trc_reader bus.can_log bus.python_can_bus "
    "simulator.live simulator.files commands.check commands.demo commands.simulate",
    "cantools": "decoding.raw_number decoding.signal_field decoding.dbc decoding.matching decoding.routing "
    "simulator.can_encoder",
    "zenoh": "publishing.zenoh_* publishing.publisher desk.fleet_listener dashboard.hearing commands.watch",
    "sqlite3": "storage.store_file",
    "prometheus_client": "publishing.open_metrics",
    "rich": "desk.progress desk.*_panel commands.watch",
    "socket": "bus.can_link bus.can_socket daemon.sd_notify commands.dashboard",
    "threading": "host.processes host.stop_signals storage.store_outbox storage.memory_* publishing.published "
    "publishing.handover publishing.zenoh_* publishing.publisher daemon.bus_reader daemon.buses daemon.succession "
    "desk.fleet_listener dashboard.fleet dashboard.hearing commands.demo commands.watch",
    "queue": "host.stop_signals publishing.zenoh_* daemon.bus_reader daemon.buses dashboard.hearing",
    "signal": "host.processes host.stop_signals commands.run commands.dashboard cli __main__",
    "time": "host.pacing bus.python_can_bus storage.memory_writer publishing.event_queue publishing.zenoh_* "
    "publishing.publisher daemon.log_lines daemon.frame_clock daemon.bus_reader daemon.buses daemon.watchdog "
    "daemon.service daemon.succession dashboard.hearing dashboard.server compiled.kept_code commands.demo "
    "commands.watch commands.wear",
    "datetime": "storage.memory_directory report.words commands.wear",
    "pyarrow": "desk.parquet_table",
    "aiohttp": "dashboard.visitors dashboard.server",
    "asyncio": "dashboard.server commands.dashboard",
    "subprocess": "compiled.kept_code commands.demo",
    "multiprocessing": "host.processes",
    "numba": "compiled.machine_code compiled.inlining compiled.numba_classes compiled.held_tuple "
    "compiled.compiled_core simulator.physics.compiled",
    "matplotlib": "validation.figures report.figures observability.figure",
}
NO_INPUT_OR_OUTPUT = "decoding estimation monitoring processing"  # layers, and what they do without
INPUT_AND_OUTPUT = {"io", "logging", "os", "pathlib", "shutil", "sys", "tempfile"}

BY_ONE_NUMBER = "estimation.model.load_distribution"  # what it repeats by
SENDS = {"send", "send_periodic", "sendto", "sendmsg", "sendall", "sendfile"}
SEND_TO_THE_SYSTEM = {"daemon.sd_notify", "bus.can_link"}  # a local datagram to systemd, a question to the kernel


def module_name(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" and len(parts) > 1 else parts)


MODULES = {module_name(path): path for path in sorted(ROOT.rglob("*.py"))}


def among(module: str, patterns: str) -> bool:
    return any(fnmatchcase(module, pattern) for pattern in patterns.split())


@cache
def layer_of(module: str) -> str | None:
    """The layer a module is named in; a package's own __init__ belongs to the layer of what is in the package."""
    names = [name for name, layer in LAYERS.items() if among(module, layer.modules)]
    names += [name for name, layer in LAYERS.items() if among(f"{module}.", layer.modules)]
    return names[0] if names else None


@cache
def imports(source: str) -> set[str]:
    """Everything the source imports, at any depth of it; our own modules as `brake_monitor.<module>`."""
    found = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"line {node.lineno}: relative import"
            found |= {own_module(f"{node.module}.{alias.name}") for alias in node.names}
    return found


def own_module(dotted: str) -> str:
    """`brake_monitor.frame.Frame` → `brake_monitor.frame`; what is not ours stays as it is."""
    package, _, rest = dotted.partition(".")
    if package != "brake_monitor":
        return dotted
    while rest and rest not in MODULES:
        rest = rest.rpartition(".")[0]
    return f"brake_monitor.{rest or '__init__'}"


@cache
def packages(module: str) -> set[str]:
    """Top-level packages that it imports."""
    return {name.partition(".")[0] for name in imports(MODULES[module].read_text())}


@cache
def own_imports(module: str) -> set[str]:
    ours = {name for name in imports(MODULES[module].read_text()) if name.startswith("brake_monitor.")}
    return {name.removeprefix("brake_monitor.") for name in ours}


def test_every_module_has_its_place_in_the_table() -> None:
    assert not [module for module in MODULES if layer_of(module) is None]


@pytest.mark.parametrize("module", [module for module in MODULES if layer_of(module)])
def test_a_module_imports_only_from_the_layers_it_may_see(module: str) -> None:
    layer = layer_of(module)
    assert layer
    for imported in own_imports(module):
        theirs = layer_of(imported)
        if theirs not in (layer, None):
            assert theirs in LAYERS[layer].sees.split(), f"{module} ({layer}) imports {imported} ({theirs})"
            continue
        order = LAYERS[layer].modules.split()
        if module in order and imported in order:
            assert order.index(imported) < order.index(module), f"{module} imports {imported}, which is above it"


@pytest.mark.parametrize("module", MODULES)
def test_a_module_touches_only_what_it_may_of_the_world(module: str) -> None:
    for capability in packages(module) & CAPABILITIES.keys():
        assert among(module, CAPABILITIES[capability]), f"{module} imports {capability}"
    if layer_of(module) in NO_INPUT_OR_OUTPUT.split():
        assert not packages(module) & INPUT_AND_OUTPUT


@pytest.mark.parametrize("layer", LAYERS)
def test_no_layer_may_see_what_it_does_not_look_at(layer: str) -> None:
    own = [module for module in MODULES if layer_of(module) == layer]
    assert {layer_of(imported) for module in own for imported in own_imports(module)} >= set(LAYERS[layer].sees.split())


@pytest.mark.parametrize("capability", CAPABILITIES)
def test_no_module_may_touch_what_it_does_not(capability: str) -> None:
    users = [module for module in MODULES if capability in packages(module)]
    for pattern in CAPABILITIES[capability].split():
        assert any(among(module, pattern) for module in users), f"{pattern} does not import {capability}"


def test_the_daemon_has_no_call_that_sends_a_frame() -> None:
    waiting = ["commands.run"]
    daemon: set[str] = set()
    while waiting:
        module = waiting.pop()
        if module not in daemon:
            daemon.add(module)
            waiting += own_imports(module)
    assert not [module for module in daemon if layer_of(module) in {"simulator", "desk", "validation"}]
    for module in daemon - SEND_TO_THE_SYSTEM:
        for node in ast.walk(ast.parse(MODULES[module].read_text())):
            sends = isinstance(node, ast.Attribute) and node.attr in SENDS
            assert not sends, f"{module}, line {node.lineno}: a call that could send"


@pytest.mark.parametrize("module", sorted(SEND_TO_THE_SYSTEM))
def test_what_may_send_elsewhere_knows_no_can_socket(module: str) -> None:
    names = {node.attr for node in ast.walk(ast.parse(MODULES[module].read_text())) if isinstance(node, ast.Attribute)}
    assert not names & {"AF_CAN", "PF_CAN", "CAN_RAW", "CAN_BCM", "AF_PACKET"}


def test_the_table_is_read_top_down_and_every_import_is_seen() -> None:
    above: set[str] = set()
    for name, layer in LAYERS.items():
        assert set(layer.sees.split()) <= above, f"{name} sees a layer that is not above it in the table"
        above.add(name)
    source = """
from brake_monitor import frame, __version__
if True:
    import can.bus as b
def late():
    from brake_monitor.errors import InputError
"""
    expected = {"brake_monitor.frame", "brake_monitor.__init__", "can.bus", "brake_monitor.errors"}
    assert imports(source) == expected


def counts_and_repeats_by(source: str) -> list[str]:
    """What numpy is to count, or to repeat by."""
    calls = [node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Call)]
    place = {"np.bincount": 0, "np.repeat": 1}
    named = [(node, place.get(ast.unparse(node.func))) for node in calls]
    return [ast.unparse(node.args[which]) for node, which in named if which is not None]


def test_numpy_counts_and_repeats_by_integers_that_every_processor_takes() -> None:
    """One of 32 bits, as gateways have, refuses integers of 64 there, and nothing else shows it on one of 64."""
    found = {module: counts_and_repeats_by(path.read_text()) for module, path in MODULES.items()}
    assert found.pop(BY_ONE_NUMBER)
    assert {module for module, all_by in found.items() if not all(by.startswith("indices(") for by in all_by)} == set()
