"""The daemon is told to reload its configuration, or to end: what it refuses, goes back to and does not wait for."""

import re
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import pytest

from background import in_background
from brake_monitor.bus.can_source import BusError
from brake_monitor.bus.python_can_bus import PythonCanBus
from brake_monitor.daemon import succession, watchdog
from brake_monitor.daemon.succession import Daemon
from brake_monitor.errors import InputError, WorkError
from brake_monitor.publishing import publisher
from brake_monitor.settings.config import CanBus
from brake_monitor.settings.example_vehicles import example_config
from brake_monitor.storage import memory_writer
from brake_monitor.storage.memory import Memory
from brake_monitor.storage.memory_directory import FILE_NAME
from brake_monitor.storage.store import Store
from brake_monitor.storage.store_batch import Batch
from brake_monitor.storage.store_file import StoreError
from brake_states import WHEELSETS, batch
from program import until

VEHICLE = "wagon-8127"
PATIENCE_S = 60.0


def bus_table(path: Path, name: str, example: Path) -> str:
    return (
        f'\n[[can]]\nname = "{name}"\ninterface = "virtual"\nchannel = "{path.parent.name}-{name}"\n'
        f'dbc = ["{example.with_suffix(".dbc")}"]\n'
    )


def written(path: Path, vehicle: str = "wagon", more: str = "") -> Path:
    """An example vehicle under the wagon's id, on virtual buses `a` and `b`, of which only `a` is mapped."""
    example = example_config(vehicle)
    text = re.sub(r"^id = .*$", f'id = "{VEHICLE}"', example.read_text(), flags=re.MULTILINE)
    text = re.sub(r"^\[can\]\n(.+\n)*", "", text, flags=re.MULTILINE).replace("{ message", '{ bus = "a", message')
    text += "".join(bus_table(path, name, example) for name in ("a", "b"))
    path.write_text(f"{text}\n{more}\n")
    return path


@pytest.fixture
def config(tmp_path: Path) -> Path:
    """With a memory that knows of some wear and an open alarm."""
    with Store.open(tmp_path / FILE_NAME, VEHICLE, WHEELSETS) as store:
        store.write(batch(2))
    return written(tmp_path / "wagon.toml", more=f'[store]\ndirectory = "{tmp_path}"')


@contextmanager
def running(
    config: Path, caplog: pytest.LogCaptureFixture, is_ready: Callable[[], object] | None = None
) -> Iterator[Daemon]:
    """The daemon, once it listens or `is_ready` says so, in a thread; what it raised is raised here."""
    is_ready = is_ready or (lambda: "listening on" in caplog.text)
    caplog.set_level("INFO")
    daemon = Daemon(config, waits_for_bus=False)
    with in_background(daemon.run, daemon.stop, 60.0):
        until(is_ready)
        yield daemon


def answered(daemon: Daemon, caplog: pytest.LogCaptureFixture) -> str:
    """Tell the daemon to reload: what it says to that."""
    caplog.clear()
    daemon.reload()
    until(lambda: "new configuration is" in caplog.text)
    return next(r.message for r in caplog.records if "new configuration is" in r.message)


def another_id(config: Path) -> None:
    config.write_text(config.read_text().replace(VEHICLE, "wagon-9999"))


def another_wheelset_count(config: Path) -> None:
    written(config, "bogie", f'[store]\ndirectory = "{config.parent}"')


@pytest.mark.parametrize("vehicle", ["rig", "wagon", "bogie", "railcar"])
def test_every_example_vehicle_can_be_listened_to(
    vehicle: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Their DBC files have all that a DBC may: numbers of either byte order, multiplexed ones, floats."""
    with running(written(tmp_path / "its.toml", vehicle), caplog) as daemon:
        assert "is good" in answered(daemon, caplog)


@pytest.mark.parametrize("change", [another_id, another_wheelset_count])
def test_another_vehicle_does_not_take_over_the_memory_of_the_one_before(
    change: Callable[[Path], None], config: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with running(config, caplog) as daemon:
        good = config.read_text()
        change(config)
        assert "refused: the state directory holds the memory of another vehicle" in answered(daemon, caplog)
        config.write_text(good)
        assert "is good" in answered(daemon, caplog)
        until(lambda: "listening on" in caplog.text)
    assert not list(config.parent.glob("refused-*"))
    with Store.look(config.parent / FILE_NAME, VEHICLE) as store:
        brakes = store.brakes()
        assert brakes is not None
        assert brakes.units[0].pads.since_fitted.energy_j == 3.0
        assert len(store.remembered().open_alarms) == 1


def test_a_directory_that_keeps_nothing_is_refused_and_the_right_one_is_not(
    config: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Below a file there is no directory."""
    with running(config, caplog) as daemon:
        good = config.read_text()
        config.write_text(good.replace(f'directory = "{config.parent}"', f'directory = "{config}/below"'))
        assert f"refused: {config}/below: no memory can be kept there: Not a directory" in answered(daemon, caplog)
        config.write_text(good)
        assert "is good" in answered(daemon, caplog)
        until(lambda: "listening on" in caplog.text)


def test_with_a_directory_of_its_own_another_vehicle_takes_over(config: Path, caplog: pytest.LogCaptureFixture) -> None:
    other = config.parent / "other"
    with running(config, caplog) as daemon:
        another_id(config)
        config.write_text(config.read_text().replace(f'directory = "{config.parent}"', f'directory = "{other}"'))
        assert "is good" in answered(daemon, caplog)
        until(lambda: "listening on" in caplog.text)
        until(lambda: daemon._memory.has_resumed)
        assert not daemon._memory.failing


def test_what_was_kept_is_known_before_the_first_frame(
    config: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Else an alarm that stays open would be raised anew at each start."""
    monkeypatch.setattr(Memory, "see", lambda *_: None)
    with running(config, caplog) as daemon:
        assert len(daemon._service._pipeline.monitor.open_alarms()) == 1


def failing_buses(monkeypatch: pytest.MonkeyPatch, *names: str) -> set[str]:
    """Of these names; what is taken out of the set works."""
    down, opened = set(names), PythonCanBus.__init__

    def open_unless_down(ear: object, bus: CanBus, filters: object) -> None:
        if bus.name in down:
            raise BusError(f"{bus.name} is down")
        opened(ear, bus, filters)

    monkeypatch.setattr(PythonCanBus, "__init__", open_unless_down)
    return down


def test_a_bus_that_cannot_be_opened_ends_the_first_service_unless_it_is_to_be_waited_for(
    config: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    caplog.set_level("INFO")
    monkeypatch.setattr(succession, "WAIT_FOR_BUS_S", 0.01)
    down = failing_buses(monkeypatch, "b")
    with pytest.raises(BusError, match="b is down"):
        Daemon(config, waits_for_bus=False).run()
    daemon = Daemon(config, waits_for_bus=True)
    with in_background(daemon.run, daemon.stop, PATIENCE_S):
        until(lambda: "b is down; waiting for it" in caplog.text)
        assert "listening on" not in caplog.text
        down.clear()
        until(lambda: "listening on" in caplog.text)
    assert caplog.text.count("b is down; waiting for it") == 1


def test_what_is_refused_is_told_once_and_systemd_that_the_old_configuration_goes_on(
    config: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    told, states = list[str](), list[str]()
    monkeypatch.setattr(watchdog, "STATUS_EVERY_S", 0.0)
    monkeypatch.setattr(watchdog, "notify", lambda _, state: states.append(state))
    monkeypatch.setattr(succession, "notify", lambda *assignments: told.extend(assignments))
    failing_buses(monkeypatch, "c")
    with running(config, caplog) as daemon:
        config.write_text(config.read_text() + bus_table(config, "c", example_config("wagon")))
        assert "refused: c is down; going on with the old one" in answered(daemon, caplog)
        told_by = len(states)
        until(lambda: len(states) > told_by + 3)  # turns
        assert states[-1].endswith("a new configuration was refused: c is down")
        assert caplog.text.count("is refused") == 1
        reloading, monotonic, ready = told
        assert (reloading, monotonic.partition("=")[0], ready) == ("RELOADING=1", "MONOTONIC_USEC", "READY=1")


def test_an_old_configuration_that_does_not_work_any_more_either_ends_it(
    config: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise WorkError("nothing works any more")

    def play() -> None:
        with running(config, caplog) as daemon:
            monkeypatch.setattr(Daemon, "_open", fail)
            daemon.reload()
            until(lambda: caplog.text.count("going on with the old one") == 2)

    with pytest.raises(WorkError, match="nothing works any more"):
        play()
    assert caplog.text.count("going on with the old one") == 1


def test_an_endpoint_that_makes_no_sense_is_refused_before_anything_is_opened(config: Path) -> None:
    config.write_text(f'{config.read_text()}[zenoh]\nlisten = ["nonsense"]\n')
    with pytest.raises(InputError, match="nonsense"):
        Daemon(config, waits_for_bus=True)


def test_without_the_same_memory_another_vehicle_takes_over(config: Path, caplog: pytest.LogCaptureFixture) -> None:
    with running(config, caplog) as daemon:
        another_id(config)
        config.write_text(config.read_text().replace("[store]\n", "[store]\nenabled = false\n"))
        assert "is good" in answered(daemon, caplog)
        until(lambda: "listening on" in caplog.text)


def test_what_the_disk_has_not_taken_yet_is_not_given_up_for_a_new_configuration(
    config: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise StoreError("database or disk is full")

    with running(config, caplog) as daemon:
        memory = daemon._memory
        with monkeypatch.context() as patched:
            patched.setattr(Store, "write", fail)
            until(lambda: memory.failing)
            assert answered(daemon, caplog) == (
                "the new configuration is refused: the memory cannot be written: database or disk is full; "
                "going on with the old one"
            )
            assert daemon._memory is memory
        until(lambda: not memory.failing)
        assert "is good" in answered(daemon, caplog)
        until(lambda: "listening on" in caplog.text)


def hanging_disk(patched: pytest.MonkeyPatch) -> tuple[threading.Event, threading.Event]:
    """A disk that takes nothing more from now on: whether somebody waits for it, and what lets it go on."""
    waits, goes_on = threading.Event(), threading.Event()
    write = Store.write

    def hang(store: Store, *what: Any) -> None:
        waits.set()
        assert goes_on.wait(PATIENCE_S)
        write(store, *what)

    patched.setattr(Store, "write", hang)
    patched.setattr(memory_writer, "CLOSE_S", 0.1)
    patched.setattr(publisher, "CLOSE_S", 0.1)
    return waits, goes_on


def test_a_disk_that_hangs_holds_a_new_configuration_up_and_no_more(
    config: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The memory before has the lock as long as it writes: two at a time would spoil what is there."""
    with running(config, caplog) as daemon, monkeypatch.context() as patched:
        waits, goes_on = hanging_disk(patched)
        assert waits.wait(PATIENCE_S)
        before = daemon._memory
        assert "is good" in answered(daemon, caplog)
        until(lambda: "the disk hangs; leaving it" in caplog.text)
        assert daemon._memory is before
        goes_on.set()
        until(lambda: "listening on" in caplog.text)
        assert daemon._memory is not before
        assert "does not work" not in caplog.text


def test_events_are_kept_before_a_new_configuration_numbers_more(
    config: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two at a time would write over each other's."""
    told, waits, goes_on, write = list[str](), threading.Event(), threading.Event(), Store.write

    def hang_with_events(store: Store, what: Batch) -> None:
        if what.messages:
            waits.set()
            assert goes_on.wait(PATIENCE_S)
        write(store, what)

    monkeypatch.setattr(succession, "notify", lambda *assignments: told.extend(assignments))
    monkeypatch.setattr(Store, "write", hang_with_events)
    with running(config, caplog) as daemon:
        assert waits.wait(PATIENCE_S)
        before = daemon._outbox
        assert "is good" in answered(daemon, caplog)
        until(lambda: "STATUS=waiting: the disk does not answer" in told)
        assert not daemon._memory.is_writing
        assert daemon._outbox is before
        goes_on.set()
        until(lambda: "listening on" in caplog.text)
        assert daemon._outbox is not before


def test_going_back_waits_for_the_disk_of_what_could_not_be_opened_as_well(
    config: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whose certificate went after it was read, and whose memory has the lock as long as it writes."""
    told, hanging = list[str](), list[threading.Event]()
    monkeypatch.setattr(succession, "notify", lambda *assignments: told.extend(assignments))
    with running(config, caplog) as daemon, monkeypatch.context() as patched:

        def refuse(*_: object, **__: object) -> None:
            patched.undo()
            waits, goes_on = hanging_disk(patched)
            hanging.append(goes_on)
            assert waits.wait(PATIENCE_S)
            raise InputError("the certificate is gone")

        patched.setattr(succession, "Publisher", refuse)
        assert "is good" in answered(daemon, caplog)
        until(lambda: "does not work: the certificate is gone; going on with the old one" in caplog.text)
        until(lambda: "STATUS=waiting: the disk does not answer" in told)
        hanging[0].set()
        until(lambda: "listening on" in caplog.text)


def test_it_ends_while_the_disk_hangs(
    config: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patched:
        with running(config, caplog) as daemon:
            waits, goes_on = hanging_disk(patched)
            assert waits.wait(PATIENCE_S)
            assert "is good" in answered(daemon, caplog)
            memory = daemon._memory
            until(lambda: "the disk hangs; leaving it" in caplog.text)
        assert "does not work" not in caplog.text  # as if the memory was opened that is still locked
        goes_on.set()
        until(lambda: not memory.is_writing)


def test_going_back_to_the_old_configuration_is_not_held_up_by_a_bus_that_is_down(
    config: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    told = list[str]()
    monkeypatch.setattr(watchdog, "STATUS_EVERY_S", 0.0)
    monkeypatch.setattr(watchdog, "notify", lambda *states: told.extend(states))
    down = failing_buses(monkeypatch)
    monkeypatch.setattr(publisher, "OPEN_S", PATIENCE_S)
    with running(config, caplog) as daemon, closing(socket.socket()) as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        down.add("b")
        good = config.read_text()
        config.write_text(f'{config.read_text()}[zenoh]\nlisten = ["tcp/127.0.0.1:{other.getsockname()[1]}"]\n')
        assert "is good" in answered(daemon, caplog)
        until(lambda: "does not work" in caplog.text)
        assert "Address already in use" in caplog.text
        until(lambda: "listening on" in caplog.text)
        assert daemon._service._pipeline is not daemon._unused  # may be gone back to again, as it was configured
        assert "b is down; it is opened anew until it works" in caplog.text
        until(lambda: any("a new configuration does not work: the Zenoh session" in state for state in told))
        config.write_text(good)
        assert "is good" in answered(daemon, caplog)
        until(lambda: "listening on" in caplog.text)
        told.clear()
        until(lambda: told)
        assert "does not work" not in told[-1]


def exclusive_channels(monkeypatch: pytest.MonkeyPatch) -> dict[PythonCanBus, str]:
    """Channels that can be opened only once, as with some drivers: what is open."""
    in_use, opened, close = dict[PythonCanBus, str](), PythonCanBus.__init__, PythonCanBus.close

    def open_once(ear: PythonCanBus, bus: CanBus, filters: Any) -> None:
        if bus.channel in in_use.values():
            raise OSError("it is in use")
        opened(ear, bus, filters)
        in_use[ear] = bus.channel

    def note_closed(ear: PythonCanBus) -> None:
        close(ear)
        del in_use[ear]

    monkeypatch.setattr(PythonCanBus, "__init__", open_once)
    monkeypatch.setattr(PythonCanBus, "close", note_closed)
    return in_use


def test_a_bus_that_is_listened_to_already_is_not_opened_to_try_it(
    config: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What it is called, and which files tell of it, is no matter of the bus."""
    in_use = exclusive_channels(monkeypatch)
    with running(config, caplog) as daemon:
        text = config.read_text()
        for name, also in (("a", "a"), ("b", "second")):
            (config.parent / f"{also}.dbc").write_bytes(example_config("wagon").with_suffix(".dbc").read_bytes())
            table = bus_table(config, name, example_config("wagon"))
            renamed = bus_table(config, name, config.parent / f"{also}.toml").replace(f'"{name}"', f'"{also}"')
            text = text.replace(table, renamed)
        config.write_text(text)
        assert "is good" in answered(daemon, caplog)
        until(lambda: "listening on" in caplog.text)
        assert len(in_use) == 2


def test_buses_of_what_could_not_be_opened_are_given_back(
    config: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The configuration that is gone back to may need them."""
    in_use = exclusive_channels(monkeypatch)
    monkeypatch.setattr(publisher, "OPEN_S", PATIENCE_S)
    with running(config, caplog) as daemon, socket.create_server(("127.0.0.1", 0)) as other:
        config.write_text(f'{config.read_text()}[zenoh]\nlisten = ["tcp/127.0.0.1:{other.getsockname()[1]}"]\n')
        assert "is good" in answered(daemon, caplog)
        until(lambda: "does not work" in caplog.text)
        until(lambda: "listening on" in caplog.text)
        assert len(in_use) == 2
    assert not in_use


def test_it_ends_while_a_router_accepts_it_and_says_nothing(
    config: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(publisher, "OPEN_S", 3600.0)
    with socket.create_server(("127.0.0.1", 0)) as router:
        endpoint = f"tcp/127.0.0.1:{router.getsockname()[1]}"
        config.write_text(f'{config.read_text()}[zenoh]\nmode = "client"\nconnect = ["{endpoint}"]\n')
        router.settimeout(60.0)
        accepted: list[socket.socket] = []
        with running(config, caplog, lambda: accepted.append(router.accept()[0]) or accepted) as daemon:
            pass
        assert "leaving it" not in caplog.text
        assert not daemon._publisher._thread.is_alive()
        accepted[0].close()


TOLD_WHILE_IT_LOADS = """
import signal, sys
from brake_monitor.cli import main
from brake_monitor.daemon import succession
load = succession.load_settings
def told_meanwhile(path):
    signal.raise_signal(signal.SIGHUP)
    return load(path)
succession.load_settings = told_meanwhile
sys.exit(main(["run", "-c", "missing.toml"]))
"""


def test_a_reload_while_the_first_configuration_is_loaded_does_not_end_it(tmp_path: Path) -> None:
    command = [sys.executable, "-c", TOLD_WHILE_IT_LOADS]
    done = subprocess.run(
        command, stdin=subprocess.DEVNULL, capture_output=True, text=True, cwd=tmp_path, timeout=60.0, check=False
    )
    assert done.stderr.startswith("brake-monitor: missing.toml: ")
    assert done.returncode == 2
