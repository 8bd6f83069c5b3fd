"""Truth → what the vehicle's sensors say about each quantity, in SI units and before any noise."""

import numpy as np

from brake_monitor.arrays import Floats
from brake_monitor.samples import FLAGS
from brake_monitor.simulator.physics.pneumatics import BrakeGear
from brake_monitor.simulator.plant import GRAVITY_MPS2
from brake_monitor.simulator.trace import Trace

ORIGIN_LATITUDE_DEG = 52.0
ORIGIN_LONGITUDE_DEG = 10.0
METRES_PER_DEGREE = 111_320.0  # the track runs due north


class Sensors:
    """Reads a trace at any time; `mass_kg` is the true one.

    `run_out` is the eccentricity of pole wheels over the radius on which they are read.
    """

    def __init__(self, trace: Trace, gears: tuple[BrakeGear, ...], mass_kg: float, run_out: float = 0.0) -> None:
        self._trace = trace
        self._run_out = run_out
        self._gears = gears
        self._weight_n = mass_kg * GRAVITY_MPS2

    def read(self, quantity: str, place: int, places: int, times_s: Floats) -> Floats:
        """True values of `quantity` (a key of [signals]) at `times_s`, for entry `place` of `places` in its list."""
        column = self._column(quantity, place, places)
        values: Floats = np.interp(times_s, np.arange(len(column)) * self._trace.step_s, column)
        return np.round(values) if quantity in FLAGS else values

    def _column(self, quantity: str, place: int, places: int) -> Floats:
        """The quantity at every step of the trace."""
        trace = self._trace
        match quantity:
            case "speed":
                column = trace.wagon("speed_mps")
            case "axle_speed":
                column = self._by_pole_wheel(place, trace.wheelset(place, "omega_radps"))
            case "pressing_force":
                column = self._force(place)
            case "wsp_active":
                column = self._wsp_active(place, places)
            case "sanding" | "gradient":
                column = trace.wagon(quantity)
            case "load_force":
                column = np.full(len(trace.values), self._weight_n / places)
            case "wheel_torque":
                column = trace.wheelset(place, "motor_torque_nm")
            case "latitude":
                column = ORIGIN_LATITUDE_DEG + trace.wagon("position_m") / METRES_PER_DEGREE
            case "longitude":
                column = np.full(len(trace.values), ORIGIN_LONGITUDE_DEG)
            case _:
                raise ValueError(f"no sensor of the plant tells {quantity}")
        return column

    def _by_pole_wheel(self, wheelset: int, speed_radps: Floats) -> Floats:
        """Teeth that are farther out pass more quickly, once a revolution; each pole wheel stands as it happens to."""
        angle_rad = wheelset + np.cumsum(speed_radps) * self._trace.step_s
        told: Floats = speed_radps * (1.0 + self._run_out * np.cos(angle_rad))
        return told

    def _force(self, wheelset: int) -> Floats:
        """What the cylinder pressure stands for: below the spring's force it is negative and the pad does not press."""
        gear = self._gears[wheelset]
        return self._trace.wheelset(wheelset, "pressure_bar") * gear.force_per_bar_n + gear.offset_n

    def _wsp_active(self, place: int, places: int) -> Floats:
        """The flag of one wheelset, or of all together where there is only one signal."""
        trace = self._trace
        if places > 1:
            return trace.wheelset(place, "wsp")
        active: Floats = trace.wheelsets("wsp").max(axis=0)
        return active
