"""Moments at which more changes than a reading tells: a brake is put on, readings were wrong, time does not go on."""

from collections.abc import Collection
from math import inf, isfinite

from brake_monitor.estimation.core.core import Core
from brake_monitor.estimation.model.friction_pause import COMMON_SHARE, OWN_SHARE, onset_variance
from brake_monitor.estimation.model.wagon import GRAVITY_MPS2
from brake_monitor.estimation.moment import SNAPSHOTS

UNKNOWN_SPEED_STD_MPS = 30.0  # after a gap: of any speed of a wagon


class TurningPoints:
    """Widens, restores or forgets what a core knows, as such a moment comes."""

    def __init__(self, core: Core) -> None:
        self._core, self._now, self._filter = core, core.now, core.filter
        self.reset_count = 0

    def begin_application(self, pause_s: float, idle_brakes: Collection[int]) -> None:
        """Widen what may have changed since the last brake application: friction, d (a train that pulls), L."""
        now, brakes, grown = self._now, self._filter, onset_variance(pause_s)
        self.forget_snapshots()
        brakes.infer_idle_friction(idle_brakes)
        brakes.renew_friction(COMMON_SHARE * grown, OWN_SHARE * grown)
        brakes.admit_deceleration_jump()
        now.application.began_s, now.application.pull_variance = now.time_s, brakes.pull_variance(now.coasting_mps2)
        for wheel in self._core.wheels:
            wheel.contact.begin_application()
        if self._core.learns_lag:
            brakes.doubt_lag()
        self._core.note_beginning()

    def hand_over_gradient(self, before: float) -> None:
        """Let d take over a gradient that is lost, or give back one that is told again: the track has not changed."""
        if self._filter.tuning.deceleration_std:
            handed_over_mps2, place = GRAVITY_MPS2 * (before - self._now.gradient), self._core.deceleration_place
            for known in (self._filter.x, *self._filter.saved):
                known[place] += handed_over_mps2
            self._now.hand_over(handed_over_mps2)

    def distrust(self, since_s: float = -inf) -> None:
        """Restart with the parameters of a snapshot from before readings turned wrong, or else with the prior ones."""
        now, brakes = self._now, self._filter
        brakes.forget_parameters()
        known = [(saved_s, place) for place, saved_s in enumerate(now.saved_s) if -inf < saved_s <= since_s]
        if known:
            _, newest = max(known)
            brakes.restore_parameters(newest)
            if not now.has_slid:  # as it may have then
                self._core.end_slides()
        now.application.line_mps2 = brakes.x[self._core.deceleration_place]
        now.consistency.bias.restart()
        self.restart(now.time_s)

    def forget_snapshots(self) -> None:
        """Drop all snapshots: x and P until now are not to be restored."""
        self._now.saved_s = [-inf] * SNAPSHOTS

    def restart(self, time_s: float) -> None:
        """Restart speeds, adhesions and inputs, keep what was learned: the next readings are taken as they come."""
        core, now, brakes = self._core, self._now, self._filter
        if isfinite(now.time_s):
            self.reset_count += 1
            if time_s < now.time_s:
                self._set_back(now.time_s - time_s)
        now.time_s = now.started_s = time_s
        for readings in core.readings:
            readings.fused_s, readings.rejected_in_a_row = -inf, 0
        for wheel in core.wheels:  # the next step begins with the values told last
            wheel.force.restart(time_s)
            wheel.torque.restart(time_s)
            wheel.contact.restart(time_s)
        now.pitching_mps2 = 0.0
        now.line.forget_look()
        core.note_beginning()
        brakes.forget_all(brakes.layout.adhesion, 0.0, brakes.tuning.adhesion_std)
        if now.speed_lost:  # then wheelsets tell v, whatever it was before
            brakes.forget(brakes.speed_place, core.speed_mps(), UNKNOWN_SPEED_STD_MPS)

    def _set_back(self, by_s: float) -> None:
        """Set all times back with the clock: what happened is still as long ago."""
        for wheel in self._core.wheels:
            wheel.slid_s -= by_s
            wheel.locked_s -= by_s
        self._now.pressed_s -= by_s
        self._now.application.began_s -= by_s
        self._now.saved_s = [saved_s - by_s for saved_s in self._now.saved_s]
        self._now.consistency.set_back(by_s)
