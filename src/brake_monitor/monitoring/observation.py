"""What the rules see: an estimate, and the state of the inputs and buses that it was made from."""

from brake_monitor.estimation.estimate import Estimate
from brake_monitor.monitoring.brake_units.brakes import Brakes
from brake_monitor.monitoring.inputs.wheel_state import WheelState
from brake_monitor.monitoring.reports import BusReport, InputReport, all_good, not_good

ROLLING = WheelState.ROLLING
OBSERVATION_PERIOD_S = 0.1  # how often rules see the wagon, whatever rate estimates are given out at


class Observation:
    """What is known of the wagon at one instant, and what several rules ask of it. Nobody changes it."""

    __slots__ = (
        "all_good",
        "all_roll",
        "brakes",
        "buses",
        "estimate",
        "forces_n",
        "inputs",
        "memory_failure",
        "motors_brake",
        "not_good",
        "time_s",
        "wheels",
    )

    def __init__(
        self,
        estimate: Estimate,
        inputs: tuple[InputReport, ...],
        buses: tuple[BusReport, ...],
        brakes: Brakes,
        wheels: tuple[WheelState, ...],
        *,
        memory_failure: str,
    ) -> None:
        """`wheels`: one per wheelset; `memory_failure`: why what is to outlive the program cannot be written."""
        self.estimate = estimate
        self.time_s = estimate.time_s  # as there, which runs on though a clock is set
        self.forces_n, self.motors_brake = estimate.forces_n, estimate.motors_brake
        self.inputs = inputs
        self.not_good = not_good(inputs)
        self.all_good = all_good(self.not_good)  # every signal that the estimate stands on is
        self.buses = buses
        self.brakes = brakes
        self.wheels = wheels
        self.all_roll = wheels.count(ROLLING) == len(wheels)
        self.memory_failure = memory_failure


def position(estimate: Estimate) -> dict[str, float | str | None]:
    """The place on earth; empty when it is not known."""
    if estimate.latitude_deg is None or estimate.longitude_deg is None:
        return {}
    return {"latitude_deg": estimate.latitude_deg, "longitude_deg": estimate.longitude_deg}
