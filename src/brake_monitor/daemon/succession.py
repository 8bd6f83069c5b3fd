"""One service after another: what a daemon opens, waits for, and takes over when its configuration changes."""

import logging
import threading
import time
from contextlib import ExitStack
from copy import deepcopy
from pathlib import Path

from brake_monitor.bus.can_source import BusError, open_bus
from brake_monitor.daemon.sd_notify import notify
from brake_monitor.daemon.service import Service
from brake_monitor.errors import BrakeMonitorError, InputError, WorkError
from brake_monitor.plural import plural
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.publishing.about import about
from brake_monitor.publishing.open_metrics import open_metrics
from brake_monitor.publishing.publisher import Publisher
from brake_monitor.publishing.zenoh_endpoints import naming_endpoints
from brake_monitor.publishing.zenoh_session import session_config
from brake_monitor.settings.config import CanBus, Settings
from brake_monitor.settings.config_file import load_settings
from brake_monitor.storage.memory import Memory
from brake_monitor.storage.memory_directory import FILE_NAME, MemoryDirectory, state_directory
from brake_monitor.storage.store_outbox import StoreOutbox

WAIT_FOR_BUS_S = 0.5  # between attempts
WAIT_FOR_DISK_S = 0.1

log = logging.getLogger(__name__)


def load(config: Path) -> Pipeline:
    """A pipeline of the present configuration file; InputError when that or one of its DBC files is not good.

    The files are read completely, as they may change afterwards.
    """
    settings = load_settings(config)
    with naming_endpoints(settings.path):
        session_config(settings.zenoh)  # refuses what is malformed
    return Pipeline.from_settings(settings)


def _as_opened(bus: CanBus) -> tuple[str, str, bool]:
    """What of a bus matters where it is opened; some drivers let that be done only once at a time."""
    return bus.interface, bus.channel, bus.allow_active


class Daemon:
    """One service after another, each with the configuration of its time; `stop` and `reload` from any thread."""

    def __init__(self, config: Path, *, waits_for_bus: bool) -> None:
        self._config = config
        self._waits_for_bus = waits_for_bus
        self._stopping = threading.Event()
        self._reloading = threading.Event()
        self._service: Service | None = None
        self._publisher: Publisher | None = None
        self._unused = load(config)  # each service has a copy of it
        self._old: Pipeline | None = None  # likewise, to go back to when what takes over cannot be opened
        self._remark = ""  # of the next service, for systemd's status
        self._memory: Memory | None = None
        self._outbox: StoreOutbox | None = None
        self._was_ready = False  # a service has been ready

    def stop(self) -> None:
        """End `run` soon."""
        self._stopping.set()
        if self._service is not None:
            self._service.stop()
        if self._publisher is not None:
            self._publisher.give_up_waiting()

    def reload(self) -> None:
        """Have the configuration read again soon; one that is not good is refused, and the old one stays."""
        self._reloading.set()
        if self._service is not None:
            self._service.wake()

    def run(self) -> None:
        """Listen until `stop`; InputError or WorkError when the first configuration cannot be opened."""
        gives_way = True
        while gives_way and not self._stopping.is_set():
            with ExitStack() as stack:
                try:
                    service = self._open(stack)
                except BrakeMonitorError as error:
                    if self._old is None:
                        raise
                    log.warning("the new configuration does not work: %s; going on with the old one", error)
                    self._remark = f"a new configuration does not work: {error}"
                    self._unused, self._old = self._old, None
                    continue
                if self._stopping.is_set():
                    return
                gives_way = service.run(self._is_renewed)
                self._was_ready = True

    def _open(self, stack: ExitStack) -> Service:
        """Open everything that the configuration needs, to be closed with the stack."""
        pipeline = deepcopy(self._unused)
        settings = pipeline.settings
        directory = state_directory(settings)
        memory = outbox = publisher = None
        self._await_disk()
        if directory is not None and not self._stopping.is_set():
            outbox = self._outbox = StoreOutbox(directory / FILE_NAME, settings.vehicle.id)
            stack.callback(outbox.close)  # a publisher that hangs must not number events beside the next one
            memory = self._memory = stack.enter_context(Memory(pipeline, directory))  # also of what fails below
            memory.resume()
        if settings.zenoh.enabled:
            publisher = Publisher(
                settings.zenoh, settings.vehicle.id, outbox=outbox, about=about(settings, time.time())
            )
        self._memory, self._publisher = memory, publisher
        self._service = service = Service(pipeline, publisher, memory)
        stack.callback(service.buses.finish)  # also where it never runs
        service.remark, self._remark = self._remark, ""
        if self._stopping.is_set():
            service.stop()
        self._open_buses(service)  # before Zenoh: a daemon that has no bus must not be seen alive
        if self._stopping.is_set():
            return service
        if memory is None:
            log.warning("there is no state directory: what is learned and worn is forgotten at the end")
        if publisher is not None:
            stack.enter_context(publisher)
            if settings.metrics.port:
                stack.enter_context(open_metrics(settings.metrics.port, lambda: publisher.health))
        return service

    def _await_disk(self) -> None:
        """Wait until memory and outbox of before have written their last; the watchdog limits how long."""
        while any(one is not None and one.is_writing for one in (self._memory, self._outbox)):
            notify("STATUS=waiting: the disk does not answer")
            if self._stopping.wait(WAIT_FOR_DISK_S):
                return

    def _open_buses(self, service: Service) -> None:
        """Open the buses; for a service that takes over, one that is down now has failed like any other."""
        if self._was_ready:
            service.buses.open(may_fail=True)
            return
        told: set[str] = set()
        while not self._stopping.is_set():
            try:
                service.buses.open()
            except BusError as error:
                if not self._waits_for_bus:
                    raise
                if str(error) not in told:
                    told.add(str(error))
                    log.warning("%s; waiting for it", error)
                    notify(f"STATUS=waiting: {error}")
                self._stopping.wait(WAIT_FOR_BUS_S)
            else:
                return

    def _is_renewed(self) -> bool:
        """Read the configuration again if that is wanted; whether there is a new one to go on with."""
        if not self._reloading.is_set():
            return False
        self._reloading.clear()
        notify("RELOADING=1", f"MONOTONIC_USEC={time.monotonic_ns() // 1000}")
        try:
            successor = self._successor()
        except BrakeMonitorError as error:
            log.warning("the new configuration is refused: %s; going on with the old one", error)
            assert self._service is not None
            self._service.remark = f"a new configuration was refused: {error}"
            notify("READY=1")
            return False
        log.info("the new configuration is good: taking it over")
        self._old, self._unused = self._unused, successor
        return True

    def _successor(self) -> Pipeline:
        """A pipeline of the present configuration file; InputError or WorkError when it cannot be taken over."""
        if self._memory is not None and self._memory.failing:
            raise WorkError(f"the memory cannot be written: {self._memory.failing}")  # ... and would be dropped
        successor = load(self._config)
        self._refuse_another_vehicle(successor.settings)
        self._try_directory(successor.settings)
        known = {_as_opened(bus) for bus in self._unused.settings.can}
        for bus in successor.settings.can:
            if _as_opened(bus) not in known:
                open_bus(bus, []).close()
        return successor

    def _try_directory(self, new: Settings) -> None:
        """A memory that cannot be kept anywhere would block every later configuration, also the right one."""
        directory = state_directory(new)
        if directory is None or directory == state_directory(self._unused.settings):
            return
        trial = MemoryDirectory(directory, new.vehicle.id, new.vehicle.wheelset_count)
        try:
            trial.lock()
        except OSError as error:
            raise WorkError(f"{directory}: no memory can be kept there: {error.strerror or error}") from None
        finally:
            trial.unlock()

    def _refuse_another_vehicle(self, new: Settings) -> None:
        """Its memory would set the present one aside; a way back to the old configuration would not bring that back."""
        old = self._unused.settings
        directory = state_directory(new)
        if directory is None or directory != state_directory(old):
            return
        vehicles = [(vehicle.id, vehicle.wheelset_count) for vehicle in (old.vehicle, new.vehicle)]
        if vehicles[0] != vehicles[1]:
            (name, count), (new_name, new_count) = vehicles
            raise InputError(
                f"the state directory holds the memory of another vehicle, {name} with {plural(count, 'wheelset')}; "
                f"restart the daemon for {new_name} with {new_count}"
            )
