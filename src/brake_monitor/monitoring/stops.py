"""What one brake application did, from the first pressing pad until all are released or the wagon stands."""

from collections import deque
from collections.abc import Sequence
from math import inf

from msgspec import Struct

from brake_monitor.brake_work import WheelsetWork
from brake_monitor.estimator import Estimate, Status, WheelsetEstimate

STANDING_MPS = 0.5
RELEASED_S = 2.0  # no pad has pressed for as long: the application is over; wheel-slide protection is quicker
SHORTEST_S = 1.0  # what presses for less is no brake application
LONGEST_GAP_S = 5.0  # nobody knows what happened in a longer one
SETTLING_S = 2.0  # after a slide
DECELERATION_SPAN_S = 1.0


class WheelsetStop(Struct, frozen=True):
    """One wheelset's share of a brake application."""

    energy_j: float
    force_travel_nm: float
    friction: float | None  # mean mu_b weighted by energy, where it was valid; None: nowhere
    friction_std: float | None
    friction_energy_j: float  # the energy that this mean stands on
    pressing_force_n: float | None  # mean over the way on which no wheelset slid or was released by its WSP
    torque_nm: float | None  # the same mean of the brake torque
    sliding_distance_m: float
    wsp_actions: int
    greatest_slip: float
    peak_disc_temperature_c: float


class StopRecord(Struct, frozen=True):
    """One brake application; it need not end at standstill."""

    start_time_s: float
    end_time_s: float
    start_speed_mps: float
    end_speed_mps: float
    distance_m: float
    greatest_deceleration_mps2: float  # over a second
    greatest_adhesion: float  # utilised by the wagon
    mass_kg: float
    latitude_deg: float | None  # where it began
    longitude_deg: float | None
    wheelsets: tuple[WheelsetStop, ...]


class StopRecorder:
    """Follows one brake application after the other. Sees each estimate, in order of time."""

    def __init__(self, contact_force_n: float) -> None:
        self._contact_force_n = contact_force_n
        self._running: _Application | None = None
        self._last: Estimate | None = None

    def see(self, now: Estimate, known: Sequence[bool], disc_temperature_c: Sequence[float]) -> StopRecord | None:
        """Take an estimate, which pressing forces are known, and the disc temperatures; the record that it ended."""
        last, self._last = self._last, now
        if last is None:
            return None
        finished = None
        pressed = now.speed_mps > STANDING_MPS and any(
            known and wheelset.pressing_force_n >= self._contact_force_n
            for known, wheelset in zip(known, now.wheelsets, strict=True)
        )
        follows = 0.0 < now.time_s - last.time_s <= LONGEST_GAP_S
        if self._running is not None and not (
            follows and now.speed_mps > STANDING_MPS and self._running.pressed_within(RELEASED_S, now.time_s)
        ):
            finished = self._running.record() if self._running.duration_s >= SHORTEST_S else None
            self._running = None
        if pressed and self._running is None and follows:
            self._running = _Application(last)
        if self._running is not None:
            self._running.add(last, now, pressed, disc_temperature_c)
        return finished


class _Application:
    """A brake application that goes on."""

    def __init__(self, begin: Estimate) -> None:
        self._begin = self._end = begin
        self._greatest_deceleration_mps2 = self._greatest_adhesion = 0.0
        self._speeds = deque([(begin.time_s, begin.speed_mps)])
        self._slid_s = -inf
        self._wheelsets = [_WheelsetApplication() for _ in begin.wheelsets]

    @property
    def duration_s(self) -> float:
        """So far, until a pad last pressed."""
        return self._end.time_s - self._begin.time_s

    def pressed_within(self, span_s: float, time_s: float) -> bool:
        """Whether a pad pressed less than `span_s` before `time_s`."""
        return time_s - self._end.time_s < span_s

    def add(self, last: Estimate, now: Estimate, pressed: bool, disc_temperature_c: Sequence[float]) -> None:
        """Go on by one observation."""
        if pressed:
            self._end = now
        self._speeds.append((now.time_s, now.speed_mps))
        while now.time_s - self._speeds[1][0] >= DECELERATION_SPAN_S:
            self._speeds.popleft()
        since_s, before_mps = self._speeds[0]
        if now.time_s - since_s >= DECELERATION_SPAN_S:
            deceleration_mps2 = (before_mps - now.speed_mps) / (now.time_s - since_s)
            self._greatest_deceleration_mps2 = max(self._greatest_deceleration_mps2, deceleration_mps2)
        self._greatest_adhesion = max(self._greatest_adhesion, now.adhesion)
        if now.saturated:
            self._slid_s = now.time_s
        settled = now.time_s - self._slid_s > SETTLING_S and all(
            wheelset.friction_status is Status.VALID for wheelset in now.wheelsets
        )
        step_s = now.time_s - last.time_s
        for own, before, wheelset, temperature_c in zip(
            self._wheelsets, last.wheelsets, now.wheelsets, disc_temperature_c, strict=True
        ):
            own.add(before, wheelset, wheelset.omega_radps * step_s * settled, temperature_c)

    def record(self) -> StopRecord:
        """What it was, until a pad last pressed."""
        begin, end = self._begin, self._end
        return StopRecord(
            start_time_s=begin.time_s,
            end_time_s=end.time_s,
            start_speed_mps=begin.speed_mps,
            end_speed_mps=end.speed_mps,
            distance_m=end.distance_m - begin.distance_m,
            greatest_deceleration_mps2=self._greatest_deceleration_mps2,
            greatest_adhesion=self._greatest_adhesion,
            mass_kg=end.mass_kg,
            latitude_deg=begin.latitude_deg,
            longitude_deg=begin.longitude_deg,
            wheelsets=tuple(
                own.stop(first.work, last.work)
                for own, first, last in zip(self._wheelsets, begin.wheelsets, end.wheelsets, strict=True)
            ),
        )


class _WheelsetApplication:
    """Sums of one wheelset."""

    def __init__(self) -> None:
        self._friction_energy_j = 0.0
        self._friction_sum_j = self._friction_std_sum_j = 0.0  # friction times energy
        self._turned_rad = 0.0  # while settled, as the next two
        self._force_sum_n = self._energy_j = 0.0
        self._greatest_slip = 0.0
        self._peak_disc_temperature_c = -inf

    def add(
        self, before: WheelsetEstimate, now: WheelsetEstimate, turned_rad: float, disc_temperature_c: float
    ) -> None:
        """Go on by one observation; `turned_rad` is 0 unless all wheelsets are settled."""
        energy_j = now.work.pad_energy_j - before.work.pad_energy_j
        if now.friction_status is Status.VALID:
            self._friction_energy_j += energy_j
            self._friction_sum_j += now.friction * energy_j
            self._friction_std_sum_j += now.friction_std * energy_j
        self._turned_rad += turned_rad
        self._force_sum_n += now.pressing_force_n * turned_rad
        self._energy_j += energy_j * (turned_rad > 0.0)
        self._greatest_slip = max(self._greatest_slip, now.slip)
        self._peak_disc_temperature_c = max(self._peak_disc_temperature_c, disc_temperature_c)

    def stop(self, first: WheelsetWork, last: WheelsetWork) -> WheelsetStop:
        """What it was, between these totals."""
        known, settled = self._friction_energy_j > 0.0, self._turned_rad > 0.0
        return WheelsetStop(
            energy_j=last.pad_energy_j - first.pad_energy_j,
            force_travel_nm=last.force_travel_nm - first.force_travel_nm,
            friction=self._friction_sum_j / self._friction_energy_j if known else None,
            friction_std=self._friction_std_sum_j / self._friction_energy_j if known else None,
            friction_energy_j=self._friction_energy_j,
            pressing_force_n=self._force_sum_n / self._turned_rad if settled else None,
            torque_nm=self._energy_j / self._turned_rad if settled else None,
            sliding_distance_m=last.sliding_distance_m - first.sliding_distance_m,
            wsp_actions=last.wsp_actions - first.wsp_actions,
            greatest_slip=self._greatest_slip,
            peak_disc_temperature_c=self._peak_disc_temperature_c,
        )
