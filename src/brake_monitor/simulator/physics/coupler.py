"""What the rest of a train does to this wagon: a force that is given, or a spring to a mass with brakes of its own."""

import math
import random

COUPLER_MPS2 = 20e3 / 36e3  # mean retardation by the rest of the train: 20 kN on a wagon of 36 t ...
COUPLER_SWING_MPS2 = 10e3 / 36e3  # ... swinging by 10 kN within seconds
COUPLER_RISE_S = 1.0
COUPLER_PERIODS_S = (2.3, 4.1, 7.9)
LEAST_COUPLER_SHARE = 1e-6  # the train has let go
TRAIN_MPS2 = 0.5  # retardation of the train by a full brake
TRAIN_RISE_S = 2.0  # its brakes come one after the other
SPRING_PER_KG = 1e6 / 36e3  # N/m for each kg of the wagon; draw gear with its preload overcome
DAMPING = 0.3  # of the wagon's swinging on it


class GivenPull:
    """Holds back while the train brakes, whatever this wagon does, and lets go as it stands."""

    def __init__(self, rng: random.Random) -> None:
        self._phases = [rng.uniform(0.0, 2.0 * math.pi) for _ in COUPLER_PERIODS_S]
        self._share = 0.0

    def retardation_mps2(self, time_s: float, step_s: float, demand: float, speed_mps: float) -> float:
        """The force that holds the wagon back over the next step, by its mass."""
        if demand == 0.0 and self._share < LEAST_COUPLER_SHARE:
            return 0.0
        share = 1.0 if demand > 0.0 else 0.0
        self._share += (share - self._share) * -math.expm1(-step_s / COUPLER_RISE_S)
        swing = sum(
            math.sin(2.0 * math.pi * time_s / period_s + phase)
            for period_s, phase in zip(COUPLER_PERIODS_S, self._phases, strict=True)
        ) / len(COUPLER_PERIODS_S)
        return self._share * (COUPLER_MPS2 + COUPLER_SWING_MPS2 * swing) * min(max(speed_mps, 0.0), 1.0)


class SpringToTrain:
    """A spring and a damper to a train that is far heavier: it takes up what this wagon brakes more or less."""

    def __init__(self, speed_mps: float) -> None:
        self._train_mps = speed_mps
        self._braking_mps2 = 0.0
        self._run_up_m = 0.0  # by how much the wagon has come nearer to the train

    def retardation_mps2(self, _time_s: float, step_s: float, demand: float, speed_mps: float) -> float:
        """The force that holds the wagon back over the next step, by its mass; negative when it pulls."""
        self._braking_mps2 += (TRAIN_MPS2 * demand - self._braking_mps2) * -math.expm1(-step_s / TRAIN_RISE_S)
        self._train_mps = max(self._train_mps - self._braking_mps2 * step_s, 0.0)
        faster_mps = speed_mps - self._train_mps
        self._run_up_m += faster_mps * step_s
        return SPRING_PER_KG * self._run_up_m + 2.0 * DAMPING * math.sqrt(SPRING_PER_KG) * faster_mps
