"""Follows brake applications by the estimates: when one begins and when it is over."""

from collections.abc import Sequence
from operator import gt

from brake_monitor.estimation.doubts.consistency import Doubt
from brake_monitor.estimation.estimate import Estimate, Status
from brake_monitor.monitoring.brake_units.application_record import ApplicationRecord
from brake_monitor.monitoring.brake_units.running_application import LONGEST_GAP_S, SHORTEST_S, RunningApplication
from brake_monitor.monitoring.creep_meter import CreepMeter
from brake_monitor.monitoring.reports import InputReports
from brake_monitor.samples import Quantity

STANDING_MPS = 0.5


class ApplicationRecorder:
    """Follows one brake application after the other. Sees each estimate, in order of time.

    One begins as a pad comes to press, and ends as no more than half of the brakes that pressed still do: these drag.
    A pressing force that is not known ends nothing, unless it is that of all of them and for too long.
    """

    def __init__(self, contact_force_n: float, creep: CreepMeter) -> None:
        self._contact_force_n = contact_force_n
        self._creep = creep
        self._running: RunningApplication | None = None
        self._earlier: ApplicationRecord | None = None  # that went on when the program ended: it may go on still
        self._last: Estimate | None = None
        self._pressed: list[bool] = []  # whether each brake did when its force was last known

    @property
    def running(self) -> ApplicationRecord | None:
        """The application that goes on, as far as it has come."""
        if self._running is None or self._running.duration_s < SHORTEST_S:
            return self._earlier
        return self._running.record(None)

    def resume(self, running: ApplicationRecord) -> None:
        """Go on with the application that went on when the program ended, if it does still."""
        self._earlier = running

    def see(
        self,
        now: Estimate,
        inputs: InputReports,
        disc_temperature_c: Sequence[float],
        *,
        a_brake_drags: bool = False,
    ) -> ApplicationRecord | None:
        """Take an estimate, what is thought of the inputs, and the disc temperatures; the record that it ended.

        With a brake that drags unseen it tells no friction.
        """
        known = inputs.are_good(Quantity.PRESSING_FORCE, len(now.wheelsets))
        self._creep.note(now, known)
        last = self._last
        if last is not None and -LONGEST_GAP_S <= now.time_s - last.time_s <= 0.0:
            return None  # the clock was set back a little: nothing new until its time comes
        self._last = now
        presses = [force_n >= self._contact_force_n for force_n in now.forces_n]
        before = self._pressed or presses
        self._pressed = [presses[i] if is_known else before[i] for i, is_known in enumerate(known)]
        finished = None
        if self._earlier is not None and self._running is None:
            finished = self._go_on(self._earlier, now, known)
            if self._earlier is not None:  # too little is known yet: of a force that is told first, too
                self._pressed = before
                return None
        if last is None or (self._running is None and self._pressed == before):
            return finished
        goes_on = 0.0 < now.time_s - last.time_s <= LONGEST_GAP_S
        moves = goes_on and now.speed_mps > STANDING_MPS
        if self._running is not None and not (moves and self._running.lasts_at(now.time_s)):
            finished = self._running.record(now if moves else None) if self._running.duration_s >= SHORTEST_S else None
            if not goes_on or self._running.is_unknown:  # what presses after it is told as another one
                self._pressed = [False] * len(presses)
            self._running = None
        if self._running is None and moves and any(map(gt, self._pressed, before)):
            self._running = RunningApplication(last, self._contact_force_n)
        if self._running is not None:
            self._running.press(presses, known, now.motors_brake)
            are_told = all(known) and not a_brake_drags and Doubt.OUT_OF_STEP not in now.reasons
            self._running.note_inputs(are_told=are_told, gradient_is_known=inputs.gradient_is_known)
            self._running.add(last, now, self._creep.creep(now), disc_temperature_c)
        return finished

    def _go_on(self, earlier: ApplicationRecord, now: Estimate, known: Sequence[bool]) -> ApplicationRecord | None:
        """Go on with an application that an earlier run has told of; its record if it has ended meanwhile."""
        in_time = 0.0 <= now.clock_s - earlier.end_time_s <= LONGEST_GAP_S
        if in_time and (now.status is Status.INVALID or not any(known)):
            return None
        self._earlier = None
        if not in_time or now.speed_mps <= STANDING_MPS:
            return earlier
        self._running = RunningApplication(now, self._contact_force_n, earlier)
        self._running.press(self._pressed, known, now.motors_brake)
        return None
