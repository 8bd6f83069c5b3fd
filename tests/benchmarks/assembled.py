"""What one would put together oneself: python-can reads, cantools decodes, filterpy's extended Kalman filter estimates.

Run: python tests/benchmarks/assembled.py CONFIG LOG OUT.csv. The paper's model with one adhesion for the wagon and
constant noise: x = (ω_1 … ω_N, v, mu_w, mu_b,1 … mu_b,N), 2 N + 2 states. A frame with speeds is predicted to and fused
as one vector, pressing forces are the input; a row goes out ten times a second. No alarms, no doubt about inputs, no
wear: nothing but what such a script has, and none of our code. Foreign frames are passed over before they are decoded.
"""

import csv
import sys
import tomllib
from collections.abc import Iterable, Iterator
from math import pi
from pathlib import Path
from typing import Any, NamedTuple

import can
import cantools
import numpy as np
from filterpy.kalman import ExtendedKalmanFilter

GRAVITY_MPS2 = 9.80665
ROW_S = 0.1
LONGEST_STEP_S = 1.0
CIRCUMFERENTIAL_MPS = {"km/h": 1 / 3.6, "m/s": 1.0}
UNITS = {"rpm": pi / 30} | CIRCUMFERENTIAL_MPS  # in rad/s, m/s
SPEED_STD_MPS, OMEGA_STD_RADPS = 0.02, 0.025
PRIOR_STD = {"omega": 1.0, "speed": 1.0, "adhesion": 0.1, "friction": 0.05}
DENSITY = {"omega": 1e-3, "speed": 1e-4, "adhesion": 1e-3, "friction": 1e-5}  # variance per second
NOMINAL_FRICTION = 0.35


class WagonFilter(ExtendedKalmanFilter):  # type: ignore[misc]
    """filterpy's filter with the wagon's model."""

    def __init__(self, vehicle: dict[str, Any]) -> None:
        n = len(vehicle["axle_positions_m"])
        super().__init__(dim_x=2 * n + 2, dim_z=n)
        self.wheels, self.speed, self.adhesion, self.frictions = slice(n), n, n + 1, slice(n + 2, None)
        self.vehicle = vehicle
        self.inertia_kgm2, self.wheel_radius_m, self.brake_radius_m = (
            np.broadcast_to(vehicle[name], n) for name in ("wheelset_inertia_kgm2", "wheel_radius_m", "brake_radius_m")
        )
        self.load_nm = vehicle["mass_kg"] * GRAVITY_MPS2 / n * self.wheel_radius_m  # for all of the load
        self.force_n = np.zeros(n)
        self.density = np.diag(self._each(DENSITY))
        self.P = np.diag(np.square(self._each(PRIOR_STD)))
        self.x = np.zeros(self.dim_x)
        self.x[self.frictions] = NOMINAL_FRICTION
        self.step_s = 0.0

    def _each(self, values: dict[str, float]) -> list[float]:
        n = len(self.load_nm)
        return [values["omega"]] * n + [values["speed"], values["adhesion"]] + [values["friction"]] * n

    def go(self, step_s: float) -> None:
        """Predict: the state by Euler's step of (1), (5), (6), (7) and (10), the covariance by its Jacobian."""
        self.step_s = step_s
        vehicle, wheels = self.vehicle, range(len(self.load_nm))
        jacobian = np.zeros((self.dim_x, self.dim_x))
        jacobian[self.wheels, self.adhesion] = self.load_nm / self.inertia_kgm2
        jacobian[wheels, [self.adhesion + 1 + i for i in wheels]] = self._spin_per_friction()
        jacobian[self.speed, self.speed] = -2.0 * vehicle["drag_n_per_mps2"] * self.x[self.speed] / vehicle["mass_kg"]
        jacobian[self.speed, self.adhesion] = -GRAVITY_MPS2
        self.F = np.eye(self.dim_x) + jacobian * step_s
        self.Q = self.density * step_s
        self.predict()

    def predict_x(self, u: Any = 0) -> None:
        rate = np.zeros(self.dim_x)
        adhesion, vehicle = self.x[self.adhesion], self.vehicle
        rate[self.wheels] = adhesion * self.load_nm / self.inertia_kgm2
        rate[self.wheels] += self.x[self.frictions] * self._spin_per_friction()
        resistance_n = vehicle["track_resistance_n"] + vehicle["drag_n_per_mps2"] * self.x[self.speed] ** 2
        rate[self.speed] = -adhesion * GRAVITY_MPS2 - resistance_n / vehicle["mass_kg"]
        self.x = self.x + rate * self.step_s

    def _spin_per_friction(self) -> Any:
        return -self.force_n * self.brake_radius_m / self.inertia_kgm2


class Signal(NamedTuple):
    """Where a quantity is in its message, and how it becomes m/s, rad/s or N."""

    name: str
    place: int  # in the state, or of the wheelset
    scale: float
    offset: float
    least: float

    def of(self, values: dict[str, Any]) -> float:
        return max(float(values[self.name]) * self.scale + self.offset, self.least)


class Reading(NamedTuple):
    """The speeds in a message, as a measurement."""

    signals: list[Signal]
    places: list[int]
    jacobian: Any
    covariance: Any


class Assembled:
    """Decoder and filter; takes messages in order of time."""

    def __init__(self, config: Path) -> None:
        told = tomllib.loads(config.read_text())
        mapped = told["signals"]
        self.filter = WagonFilter(told["vehicle"])
        self._database: Any = cantools.database.load_file(config.parent / told["can"]["dbc"][0])
        mappings = [one for each in mapped.values() for one in (each if isinstance(each, list) else [each])]
        self._mapped = {self._id(one["message"]) for one in mappings}
        self._forces = self._signals(mapped["pressing_force"])
        speeds = self._signals([mapped["speed"]], self.filter.speed)
        for can_id, signals in self._signals(mapped["axle_speed"]).items():
            of_wheels = mapped["axle_speed"][0].get("unit") in CIRCUMFERENTIAL_MPS
            radii_m = self.filter.wheel_radius_m if of_wheels else np.ones(len(self.filter.wheel_radius_m))
            speeds.setdefault(can_id, []).extend(one._replace(scale=one.scale / radii_m[one.place]) for one in signals)
        self._readings = {can_id: self._reading(signals) for can_id, signals in speeds.items()}
        self._time_s: float | None = None

    def _id(self, message: str) -> int:
        return int(self._database.get_message_by_name(message).frame_id)

    def _signals(self, mappings: list[dict[str, Any]], first: int = 0) -> dict[int, list[Signal]]:
        """By the identifier of the message."""
        found: dict[int, list[Signal]] = {}
        for place, told in enumerate(mappings, first):
            scale = told.get("scale", 1.0) * UNITS.get(told.get("unit", ""), 1.0)
            signal = Signal(told["signal"], place, scale, told.get("offset", 0.0), told.get("min", -np.inf))
            found.setdefault(self._id(told["message"]), []).append(signal)
        return found

    def _reading(self, signals: list[Signal]) -> Reading:
        places = [signal.place for signal in signals]
        stds = [SPEED_STD_MPS if place == self.filter.speed else OMEGA_STD_RADPS for place in places]
        return Reading(signals, places, np.eye(self.filter.dim_x)[places], np.diag(np.square(stds)))

    def take(self, message: can.Message) -> bool:
        """Decode a message and fuse its speeds; True when it had some."""
        can_id = message.arbitration_id
        if can_id not in self._mapped:
            return False
        values = self._database.decode_message(can_id, message.data, decode_choices=False)
        for signal in self._forces.get(can_id, ()):
            self.filter.force_n[signal.place] = signal.of(values)
        reading = self._readings.get(can_id)
        if reading is None:
            return False
        before_s = message.timestamp if self._time_s is None else self._time_s
        self._time_s = message.timestamp
        self.filter.go(min(max(message.timestamp - before_s, 0.0), LONGEST_STEP_S))
        seen = np.array([signal.of(values) for signal in reading.signals])
        self.filter.update(seen, lambda _: reading.jacobian, lambda x: x[reading.places], R=reading.covariance)
        return True

    def rows(self, messages: Iterable[can.Message]) -> Iterator[list[float]]:
        """Time, state and standard deviations, ten times a second."""
        turn = -1
        for message in messages:
            if self.take(message) and (now := int(message.timestamp / ROW_S)) != turn:
                turn = now
                yield [message.timestamp, *self.filter.x, *np.sqrt(np.diag(self.filter.P))]


def main(config: Path, log: Path, out: Path) -> None:
    assembled = Assembled(config)
    wheels = range(1, len(assembled.filter.load_nm) + 1)
    names = [*(f"omega_{i}" for i in wheels), "speed", "adhesion", *(f"friction_{i}" for i in wheels)]
    with can.LogReader(log) as reader, out.open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["time_s", *names, *(f"{name}_std" for name in names)])
        for time_s, *values in assembled.rows(reader):
            writer.writerow([f"{time_s:.3f}", *(f"{value:.7g}" for value in values)])


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
