"""What is driven: every trouble with each vehicle and many seeds, and hours of ordinary service."""

from collections.abc import Iterable, Sequence
from fnmatch import fnmatchcase

from msgspec import Struct
from msgspec.structs import replace

from brake_monitor.settings.config import OutputSettings, Preset, Settings
from brake_monitor.simulator.ordinary_service import SERVICE, ordinary_disturbances, ordinary_service
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.scenarios import SCENARIOS
from brake_monitor.simulator.simulate import TRUTH_STEP_S, Recording, run
from brake_monitor.simulator.troubles import TROUBLES, Trouble
from brake_monitor.validation.vehicles import WHEELSETS, campaign_settings

# A slippery rail is trouble enough.
DRIVEN = {name: Trouble(SCENARIOS[name], Modifiers()) for name in ("wsp", "leaf")} | TROUBLES
SERVICE_VEHICLES = ("wagon", "bogie")
TROUBLE_VEHICLES = ("single", "wagon", "bogie")
SERVICE_PART_S = 1800.0
SERVICE_PRESETS: tuple[Preset, ...] = ("train", "train", "wagon")  # in turn; in a train the coupler also brakes


class Drive(Struct, frozen=True, order=True):
    """One simulated drive with one vehicle."""

    vehicle: str  # one of validation.vehicles.WHEELSETS
    name: str  # one of DRIVEN, or SERVICE
    seed: int

    @property
    def path(self) -> str:
        """`vehicle/name/seed`, as patterns on the command line see it."""
        return f"{self.vehicle}/{self.name}/{self.seed}"

    @property
    def expected_s(self) -> float:
        """About how long it lasts."""
        return SERVICE_PART_S if self.name == SERVICE else DRIVEN[self.name].scenario.duration_s

    def simulate(self) -> Recording:
        """Drive it."""
        settings = replace(campaign_settings(self.vehicle), output=OutputSettings())
        if self.name == SERVICE:
            return self._service(settings)
        trouble = DRIVEN[self.name]
        return run(trouble.scenario, trouble.settings(settings), self.seed, trouble.modifiers, row_s=TRUTH_STEP_S)

    def _service(self, settings: Settings) -> Recording:
        preset = SERVICE_PRESETS[self.seed % len(SERVICE_PRESETS)]
        settings = replace(settings, estimator=replace(settings.estimator, preset=preset))
        count = WHEELSETS[self.vehicle]
        modifiers = ordinary_disturbances(self.seed, count, in_train=preset == "train")
        return run(ordinary_service(self.seed, SERVICE_PART_S), settings, self.seed, modifiers, row_s=TRUTH_STEP_S)


def trouble_drives(seeds: int) -> list[Drive]:
    """Every trouble with every vehicle on which it can be told."""
    return [
        Drive(vehicle, name, seed)
        for name, trouble in DRIVEN.items()
        for vehicle in TROUBLE_VEHICLES
        if WHEELSETS[vehicle] >= trouble.least_wheelsets
        for seed in range(seeds)
    ]


def service_drives(hours: float) -> list[Drive]:
    """So many hours of ordinary service, in parts, the vehicles in turn."""
    parts = round(hours * 3600.0 / SERVICE_PART_S)
    return [Drive(SERVICE_VEHICLES[seed % len(SERVICE_VEHICLES)], SERVICE, seed) for seed in range(parts)]


def chosen(drives: Iterable[Drive], patterns: Sequence[str]) -> list[Drive]:
    """The drives whose path matches one of the patterns, longest first so that no process idles at the end."""
    found = [drive for drive in drives if any(fnmatchcase(drive.path, pattern) for pattern in patterns)]
    return sorted(found, key=lambda drive: -drive.expected_s)
