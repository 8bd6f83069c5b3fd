"""The layers, enforced from the imports. This table is the architecture: a module that is not in it is a failure."""

import ast
from fnmatch import fnmatchcase
from pathlib import Path
from typing import NamedTuple

import pytest

import brake_monitor

ROOT = Path(brake_monitor.__file__).parent


class Layer(NamedTuple):
    """Modules of one layer in order (each may import those before it) and the other layers that they may import."""

    modules: str
    sees: str


LAYERS = {
    "words": Layer("__init__ errors nearest frame frame_block samples can_filter pacing whole_file", ""),
    "settings": Layer(
        "bounds key_space alarm_settings wear_settings store_settings zenoh_settings config units toml_lines "
        "config_file vehicle_files",
        "words",
    ),
    "dbc": Layer("dbc", "words settings"),
    # From frame to alarm: no threads, no clock, no input or output.
    "signals": Layer(
        "decode_counts j1939 matching rolling_counter routing ordinary_frame sample_block signal_table "
        "message_decoder block_decoder time_outs signals",
        "words settings dbc",
    ),
    "estimation": Layer(
        "learned plausibility alignment held_input pad_contact radius_calibration straight_line ekf consistency tape "
        "brake_work moment wagon load_transfer tuning regime brake_step brake_filter slide_protection friction_pause "
        "estimate input_trust core known_inputs statement estimator observability",
        "words settings signals",
    ),
    # The same as machine code, for desk tools; a gateway has no numba.
    "compiled": Layer(
        "kept_code machine_code numba_classes compiled_core compiled_estimator code_maker",
        "words settings signals estimation",
    ),
    "monitoring": Layer(
        "monitoring monitoring.alarm monitoring.creep_meter monitoring.stops monitoring.wear "
        "monitoring.disc_temperature monitoring.brakes monitoring.wheel_watch "
        "monitoring.retardation monitoring.force_watch monitoring.flag_watch monitoring.observation "
        "monitoring.input_watch monitoring.input_judge monitoring.bus_watch monitoring.brake_book monitoring.rule "
        "monitoring.alarm_cycle monitoring.low_adhesion monitoring.wheelset_not_rotating "
        "monitoring.slide monitoring.inputs monitoring.buses monitoring.memory_failing "
        "monitoring.creep_shares monitoring.per_stop "
        "monitoring.brake_application monitoring.hidden_drag monitoring.dragging_brake monitoring.brake_not_applied "
        "monitoring.uneven_braking "
        "monitoring.friction_out_of_band monitoring.friction_drift monitoring.hot_disc monitoring.pads "
        "monitoring.brake_rules "
        "monitoring.monitor",
        "words settings signals estimation",
    ),
    "pipeline": Layer(
        "remembered stretches pipeline playing estimate_table smoother",
        "words settings signals estimation compiled monitoring",
    ),
    # The edges of the daemon.
    "bus": Layer(
        "candump_log eight_digits candump_blocks blf_blocks can_message can_log can_link can_socket can_source",
        "words settings",
    ),
    "memory": Layer(
        "store_schema store store_outbox evidence memory", "words settings signals estimation monitoring pipeline bus"
    ),
    "zenoh": Layer(
        "payloads payload_schemas about outbox published answers health open_metrics zenoh_session "
        "zenoh_link publisher",
        "words settings signals estimation monitoring pipeline",
    ),
    "service": Layer(
        "sd_notify log_lines bus_reader capture_order service",
        "words settings dbc signals estimation monitoring pipeline bus memory zenoh",
    ),
    # The plant that the estimator is judged by shares none of its equations, so it sees none of its modules.
    "simulator": Layer("simulator.*", "words settings dbc"),
    "desk": Layer(
        "alarm_lines wear_lines parquet_table progress live_view watched fleet_listener watch_view",
        "words settings estimation monitoring pipeline zenoh",
    ),
    "dashboard": Layer(
        "dashboard dashboard.recent dashboard.fleet dashboard.views dashboard.hearing dashboard.visitors "
        "dashboard.server",
        "words settings estimation monitoring zenoh desk",
    ),
    "report": Layer(
        "report report.traffic report.recording report.words report.tables report.track_map report.page report.figures",
        "words settings dbc signals estimation monitoring pipeline zenoh dashboard",
    ),
    "validation": Layer("validation.*", "words settings signals estimation pipeline simulator desk"),
    "alarm_campaign": Layer("alarm_campaign.*", "words settings monitoring pipeline simulator validation"),
    "tuner": Layer("tuner.*", "words settings signals estimation validation"),
    "commands": Layer(
        "commands.* cli __main__",
        "words settings dbc signals estimation monitoring pipeline bus memory zenoh service simulator desk dashboard "
        "compiled report validation alarm_campaign tuner",
    ),
}

# Who may touch the world. What is not named here is free to all (numpy, msgspec, most of the standard library).
CAPABILITIES = {
    "can": "can_message blf_blocks can_log can_source simulator.live simulator.files commands.*",
    "cantools": "dbc matching routing simulator.can_encoder",
    "zenoh": "zenoh_session zenoh_link publisher fleet_listener dashboard.hearing commands.*",
    "sqlite3": "store",
    "prometheus_client": "open_metrics",
    "rich": "progress live_view watch_view commands.*",
    "socket": "can_link can_socket sd_notify commands.dashboard",
    "threading": "memory published zenoh_link publisher bus_reader service fleet_listener dashboard.fleet "
    "dashboard.hearing commands.*",
    "queue": "zenoh_link bus_reader service dashboard.hearing commands.*",
    "signal": "service commands.* cli validation.workers tuner.workers",
    "time": "memory pacing zenoh_link publisher log_lines bus_reader service dashboard.hearing dashboard.server "
    "kept_code commands.*",
    "datetime": "memory report.words commands.*",
    "pyarrow": "parquet_table",
    "aiohttp": "dashboard.visitors dashboard.server commands.dashboard",
    "asyncio": "dashboard.server commands.dashboard",
    "subprocess": "kept_code commands.demo",
    "multiprocessing": "validation.workers tuner.workers",
    "numba": "machine_code numba_classes compiled_core simulator.compiled",
    "matplotlib": "validation.figures report.figures commands.*",
}

SENDS = {"send", "send_periodic", "sendto", "sendmsg", "sendall", "sendfile"}
SEND_TO_THE_SYSTEM = {"sd_notify", "can_link"}  # a local datagram to systemd, a question to the kernel


def module_name(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" and len(parts) > 1 else parts)


MODULES = {module_name(path): path for path in sorted(ROOT.rglob("*.py"))}


def among(module: str, patterns: str) -> bool:
    return any(fnmatchcase(module, pattern) for pattern in patterns.split())


def layer_of(module: str) -> str | None:
    """The layer a module is named in; a package's own __init__ belongs to the layer of what is in the package."""
    names = [name for name, layer in LAYERS.items() if among(module, layer.modules)]
    names += [name for name, layer in LAYERS.items() if among(f"{module}.", layer.modules)]
    return names[0] if names else None


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
    used = {name.partition(".")[0] for name in imports(MODULES[module].read_text())}
    for capability in used & CAPABILITIES.keys():
        assert among(module, CAPABILITIES[capability]), f"{module} imports {capability}"


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
