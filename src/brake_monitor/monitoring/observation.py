"""What the rules see: an estimate, and the state of the inputs and buses that it was made from."""

from dataclasses import dataclass, field

from brake_monitor.estimation.estimate import Estimate
from brake_monitor.monitoring.brake_units.brakes import Brakes
from brake_monitor.monitoring.inputs.wheel_state import WheelState
from brake_monitor.monitoring.misled import MisledBy
from brake_monitor.monitoring.reports import BusReport, InputReports

ROLLING = WheelState.ROLLING
OBSERVATION_PERIOD_S = 0.1  # how often rules see the wagon, whatever rate estimates are given out at


@dataclass(slots=True)
class Observation:
    """What is known of the wagon at one instant, and what several rules ask of it. Nobody changes it."""

    estimate: Estimate
    inputs: InputReports
    buses: tuple[BusReport, ...]
    brakes: Brakes
    wheels: tuple[WheelState, ...]  # one per wheelset
    memory_failure: str  # why what is to outlive the program cannot be written
    misled_by: frozenset[MisledBy] = frozenset()  # why the estimate errs, by its inputs beside each other
    time_s: float = field(init=False)  # the estimate's, which runs on though a clock is set
    forces_n: tuple[float, ...] = field(init=False)
    motors_brake: list[bool] = field(init=False)
    all_good: bool = field(init=False)  # every signal that the estimate stands on is
    all_roll: bool = field(init=False)

    def __post_init__(self) -> None:
        now = self.estimate
        self.time_s, self.forces_n, self.motors_brake = now.time_s, now.forces_n, now.motors_brake
        self.all_good = self.inputs.all_good
        self.all_roll = self.wheels.count(ROLLING) == len(self.wheels)


def position(estimate: Estimate) -> dict[str, float | str | None]:
    """The place on earth; empty when it is not known."""
    if estimate.latitude_deg is None or estimate.longitude_deg is None:
        return {}
    return {"latitude_deg": estimate.latitude_deg, "longitude_deg": estimate.longitude_deg}
