"""What a brake application that goes on adds up to."""

from collections import deque
from collections.abc import Sequence
from math import hypot, inf, sqrt

from msgspec.structs import replace

from brake_monitor.estimation.estimate import MOTORS_ERR, Estimate, Status, WheelsetEstimate
from brake_monitor.estimation.model.wagon import GRAVITY_MPS2
from brake_monitor.monitoring.brake_units.application_record import ApplicationRecord
from brake_monitor.monitoring.brake_units.running_wheelset import RunningWheelset
from brake_monitor.monitoring.contact_stiffness import SOFTEST
from brake_monitor.monitoring.creep_meter import Creep

VALID, CONVERGING = Status.VALID, Status.CONVERGING
RELEASED_S = 2.0  # an application is over when no pad has pressed for this long; slide protection fills sooner
SHORTEST_S = 1.0  # what presses for less is no brake application
LONGEST_GAP_S = 5.0  # nobody knows what happened in a longer one
SETTLING_S = 2.0  # after a slide, what slide protection did before one came of it, or a motor
ALONE_J = 300e3  # of the brake that does most, without motors: less tells nothing of the torques where motors helped
SPAN_S = 1.0  # of the deceleration, and in which brakes fill one after the other
ROLLING_MPS = 3.0
GRADIENT_MPS2 = 0.1  # 10 per mille, by which it may have changed during a stop to standstill ...
KNOWN_GRADIENT_MPS2 = 0.02  # ... and 2 per mille where its signal says by how much
LEAST_DECELERATION_MPS2 = 0.05
SLIDING_DOUBT = 0.2  # of the doubt from a gradient, where wheelsets slide: how they slow down shows friction as well
JUMP_S = 0.15  # no air fills a cylinder within it ...
JUMP_SHARE = 0.5  # ... by as much of what has pressed another one for longer than they fill one after the other


class RunningApplication:
    """A brake application that goes on."""

    def __init__(self, begin: Estimate, contact_force_n: float, earlier: ApplicationRecord | None = None) -> None:
        """`earlier`: the part of it that an earlier run of the program saw."""
        self._contact_force_n = contact_force_n
        self._earlier = earlier
        self._begin = self._end = begin
        self._clock_ahead_s = begin.clock_ahead_s  # as of the last observation
        self._greatest_deceleration_mps2 = self._greatest_adhesion = 0.0
        self._braked_mps = 0.0  # what the brakes took from the speed, also where a gradient gave it back
        self._lately = deque([begin])  # of the last SPAN_S, and one before
        self._slid_s = self._driven_s = -inf
        self._wheelsets = [RunningWheelset() for _ in begin.wheelsets]
        self._took_part = [earlier is not None] * len(begin.wheelsets)
        self._presses = False  # more than half of those that took part, as far as is known
        self.is_unknown = False  # whether any of them presses
        self._is_told_whole = self._gradient_is_known = True  # throughout, as in `note_inputs`

    @property
    def duration_s(self) -> float:
        """So far, until a pad last pressed."""
        earlier_s = self._begin.clock_s - self._earlier.start_time_s if self._earlier else 0.0
        return earlier_s + self._end.time_s - self._begin.time_s

    def lasts_at(self, time_s: float) -> bool:
        """Whether it still goes on then."""
        return time_s - self._end.time_s < (LONGEST_GAP_S if self.is_unknown else RELEASED_S)

    def press(self, presses: Sequence[bool], known: Sequence[bool], motors_brake: Sequence[bool]) -> None:
        """Take which brakes press now, where that is known; before `add`. Those whose motors brake need not."""
        told = [i for i, is_known in enumerate(known) if is_known]
        for i in told:
            self._took_part[i] |= presses[i]
        part = [i for i in told if self._took_part[i]]
        awaited = [presses[i] for i in part if presses[i] or not motors_brake[i]]
        self._presses, self.is_unknown = 2 * sum(awaited) > len(awaited), not part

    def note_inputs(self, *, are_told: bool, gradient_is_known: bool) -> None:
        """Take whether all that presses is known and in step, and whether the gradient's signal is good."""
        self._is_told_whole &= are_told
        self._gradient_is_known &= gradient_is_known

    def add(
        self, last: Estimate, now: Estimate, creep: Sequence[Creep] | None, disc_temperature_c: Sequence[float]
    ) -> None:
        """Go on by one observation."""
        self._clock_ahead_s = now.clock_ahead_s
        if self._presses:
            self._end = now
        self._lately.append(now)
        while now.time_s - self._lately[1].time_s >= SPAN_S:
            self._lately.popleft()
        before = self._lately[0]
        if now.time_s - before.time_s >= SPAN_S:
            deceleration_mps2 = (before.speed_mps - now.speed_mps) / (now.time_s - before.time_s)
            self._greatest_deceleration_mps2 = max(self._greatest_deceleration_mps2, deceleration_mps2)
        self._greatest_adhesion = max(self._greatest_adhesion, now.adhesion)
        motors_n = sum(own.motor_force_n or 0.0 for own in now.wheelsets)
        pads_n = now.mass_kg * GRAVITY_MPS2 * now.adhesion - motors_n
        self._braked_mps += pads_n / now.mass_kg * (now.time_s - last.time_s)
        if now.saturated or _protection_acted(last, now):
            self._slid_s = now.time_s
        if now.a_motor_acts:
            self._driven_s = now.time_s
        slid = now.time_s - self._slid_s <= SETTLING_S
        unsettled = slid or now.time_s - self._driven_s <= SETTLING_S
        if not unsettled and now.time_s - last.time_s <= JUMP_S and self._jumped(last, now):
            self._is_told_whole = False
        together = all(_is_told(now, wheelset) for wheelset in now.wheelsets)
        settled_s = now.time_s - last.time_s if together and not unsettled else 0.0
        doubt = MOTORS_ERR * abs(motors_n) / max(pads_n, abs(motors_n) * MOTORS_ERR, 1.0)
        for i, own in enumerate(self._wheelsets):
            own.add(last.wheelsets[i], now.wheelsets[i], settled_s, creep[i] if creep else None, disc_temperature_c[i])
            if (together or slid) and _is_told(now, now.wheelsets[i]):
                own.rub(last.wheelsets[i], now.wheelsets[i], doubt, SLIDING_DOUBT if slid else 1.0)

    def _jumped(self, last: Estimate, now: Estimate) -> bool:
        """Whether a pressing force was not told while others pressed, and is now: its sensor stood still, or began."""
        pairs = [pair for pair in zip(last.forces_n, now.forces_n, strict=True) if pair[0] < self._contact_force_n]
        if not pairs:
            return False
        others_n = min([max(past.forces_n) for past in self._lately])
        rose_n = max([now_n - before_n for before_n, now_n in pairs])
        return others_n >= self._contact_force_n and rose_n > JUMP_SHARE * others_n

    def record(self, rolling: Estimate | None) -> ApplicationRecord:
        """What it was, until a pad last pressed; `rolling` is the estimate after it, None when the wagon stands.

        Beginning and end are told by the clock as it was set last.
        """
        begin, end, ahead_s = self._begin, self._end, self._clock_ahead_s
        earlier = _later(self._earlier, ahead_s - begin.clock_ahead_s) if self._earlier else None
        if earlier is not None and begin.time_s == end.time_s:  # it ended while the program did not run
            return earlier
        doubt = self._gradient_doubt(rolling)
        torque_tells = self._driven_s == -inf or max(own.settled_energy_j for own in self._wheelsets) >= ALONE_J
        creep_tells = torque_tells and self._creep_is_proportional()
        record = ApplicationRecord(
            start_time_s=begin.time_s + ahead_s,
            end_time_s=end.time_s + ahead_s,
            start_speed_mps=begin.speed_mps,
            end_speed_mps=end.speed_mps,
            distance_m=end.distance_m - begin.distance_m,
            greatest_deceleration_mps2=self._greatest_deceleration_mps2,
            greatest_adhesion=self._greatest_adhesion,
            mass_kg=end.mass_kg,
            latitude_deg=begin.latitude_deg,
            longitude_deg=begin.longitude_deg,
            wheelsets=tuple(
                (own if self._is_told_whole else own.heat_only()).record(
                    first.work, last.work, doubt, torque_tells=torque_tells, creep_tells=creep_tells
                )
                for own, first, last in zip(self._wheelsets, begin.wheelsets, end.wheelsets, strict=True)
            ),
        )
        return earlier.then(record) if earlier else record

    def _creep_is_proportional(self) -> bool:
        """Whether the rail gave as much as wheelsets crept: near the peak each slips as its own rail lets it.

        Where one slid, it had crept towards that peak for seconds before, the leading one on leaves most of all.
        """
        creep_sum = sum(own.creep_sum for own in self._wheelsets)
        has_slid = self._slid_s > -inf
        return not has_slid and SOFTEST * creep_sum < sum(own.adhesion_sum for own in self._wheelsets)

    def _gradient_doubt(self, rolling: Estimate | None) -> float:
        """Standard deviation of friction, relative to it, from a gradient that may have changed meanwhile.

        While the wheels roll under the brake it cannot be told from friction; rolling on shows by how much it did. What
        the two estimates of it are unsure of themselves is in friction's own deviation already.
        """
        begin = self._begin
        if rolling is not None and rolling.speed_mps > ROLLING_MPS:
            change_mps2 = rolling.deceleration_mps2 - begin.deceleration_mps2
            unsure_mps2 = hypot(rolling.deceleration_std_mps2, begin.deceleration_std_mps2)
            change_mps2 = sqrt(max(change_mps2**2 - unsure_mps2**2, 0.0))
        else:
            change_mps2 = KNOWN_GRADIENT_MPS2 if self._gradient_is_known else GRADIENT_MPS2
        return change_mps2 / max(self._braked_mps / max(self.duration_s, SHORTEST_S), LEAST_DECELERATION_MPS2)


def _is_told(now: Estimate, own: WheelsetEstimate) -> bool:
    """Whether friction is known as well as its deviation says, however wide that is."""
    return own.friction_status is VALID or (own.friction_status is CONVERGING and not now.reasons)


def _protection_acted(last: Estimate, now: Estimate) -> bool:
    """Whether the slide protection of any wheelset let its brake go; a good one does so before there is a slide."""
    return any(
        own.work.wsp_actions > before.work.wsp_actions
        for before, own in zip(last.wheelsets, now.wheelsets, strict=True)
    )


def _later(record: ApplicationRecord, by_s: float) -> ApplicationRecord:
    return replace(record, start_time_s=record.start_time_s + by_s, end_time_s=record.end_time_s + by_s)
