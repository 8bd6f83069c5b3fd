"""What one wheelset does in a brake application that goes on: sums over it."""

from math import hypot, inf, sqrt

from brake_monitor.estimation.brake_work import WheelsetWork
from brake_monitor.estimation.estimate import WheelsetEstimate
from brake_monitor.monitoring.brake_units.application_record import WheelsetRecord
from brake_monitor.monitoring.creep_meter import Creep


class RunningWheelset:
    """Sees one wheelset at each observation."""

    def __init__(self) -> None:
        self._friction_energy_j = 0.0
        self._friction_sum_j = self._friction_std_sum_j = 0.0  # friction times energy
        self._friction_prior_std: float | None = None
        self._doubted_energy_j = 0.0  # as far as a gradient that may have changed leaves friction in doubt
        self._earlier_line_std = inf  # of friction, for a line that had changed before this application
        self._crept_rad = self.creep_sum = self.adhesion_sum = 0.0  # while settled and creep was known
        self._crept_s = 0.0
        self._last_creep: Creep | None = None
        self._turned_rad = 0.0  # while settled, as the next two
        self._force_sum_n = self.settled_energy_j = 0.0
        self._greatest_slip = 0.0
        self._peak_disc_temperature_c = -inf

    def rub(self, before: WheelsetEstimate, now: WheelsetEstimate, motors_doubt: float, gradient_share: float) -> None:
        """Go on by one observation while friction is told and all brakes press, or slide protection keeps some from it.

        A brake that does not, or a sensor that does not say so, would be made up for by the others' friction. What of
        the deviation stands for a line that has changed meanwhile is known better once the brake has let go, see
        `_gradient_doubt`, of which `gradient_share` counts. What motors err by is the pads' (`motors_doubt`, of
        friction).
        """
        energy_j = now.work.pad_energy_j - before.work.pad_energy_j
        self._friction_energy_j += energy_j
        self._doubted_energy_j += gradient_share * energy_j
        self._friction_sum_j += now.friction * energy_j
        own_std = sqrt(max(now.friction_std**2 - now.line_friction_std**2 + self._earlier_line_std**2, 0.0))
        std = hypot(own_std, motors_doubt * now.friction)
        self._friction_std_sum_j += std * energy_j
        self._friction_prior_std = self._friction_prior_std or std

    def add(
        self,
        before: WheelsetEstimate,
        now: WheelsetEstimate,
        settled_s: float,
        creep: Creep | None,
        disc_temperature_c: float,
    ) -> None:
        """Go on by one observation, which lasted `settled_s`, 0 unless all wheelsets are settled.

        A wheelset creeps as its adhesion asks: under the same torque the more, the less load it bears.
        """
        self._earlier_line_std = min(self._earlier_line_std, now.line_friction_std)
        energy_j = now.work.pad_energy_j - before.work.pad_energy_j
        turned_rad = now.omega_radps * settled_s
        if creep is not None and turned_rad > 0.0:
            self._crept_rad += turned_rad
            self.creep_sum += creep.value * now.relative_load * turned_rad
            self.adhesion_sum += now.adhesion * turned_rad
            self._crept_s += settled_s
            self._last_creep = creep
        self._turned_rad += turned_rad
        self._force_sum_n += now.pressing_force_n * turned_rad
        self.settled_energy_j += energy_j * (turned_rad > 0.0)
        self._greatest_slip = max(self._greatest_slip, now.slip)
        self._peak_disc_temperature_c = max(self._peak_disc_temperature_c, disc_temperature_c)

    def heat_only(self) -> "RunningWheelset":
        """Without what stands on pressing forces: one of them was not as it said, perhaps from the beginning."""
        other = RunningWheelset()
        other._greatest_slip = self._greatest_slip
        other._peak_disc_temperature_c = self._peak_disc_temperature_c
        return other

    def record(
        self,
        first: WheelsetWork,
        last: WheelsetWork,
        gradient_doubt: float,
        *,
        torque_tells: bool,
        creep_tells: bool,
    ) -> WheelsetRecord:
        """What it was, between these totals; `gradient_doubt` is relative to friction."""
        settled = torque_tells and self._turned_rad > 0.0
        friction = friction_std = gradient_std = None
        if self._friction_energy_j > 0.0:
            friction = self._friction_sum_j / self._friction_energy_j
            gradient_std = friction * gradient_doubt * self._doubted_energy_j / self._friction_energy_j
            friction_std = hypot(self._friction_std_sum_j / self._friction_energy_j, gradient_std)
        return WheelsetRecord(
            energy_j=last.pad_energy_j - first.pad_energy_j,
            force_travel_nm=last.force_travel_nm - first.force_travel_nm,
            friction=friction,
            friction_std=friction_std,
            friction_gradient_std=gradient_std,
            friction_energy_j=self._friction_energy_j,
            friction_prior_std=self._friction_prior_std,
            pressing_force_n=self._force_sum_n / self._turned_rad if settled else None,
            torque_nm=self.settled_energy_j / self._turned_rad if settled else None,
            creep=self.creep_sum / self._crept_rad if creep_tells and self._crept_rad > 0.0 else None,
            adhesion=self.adhesion_sum / self._crept_rad if creep_tells and self._crept_rad > 0.0 else None,
            creep_std=None if self._last_creep is None else self._last_creep.std(self._crept_s),
            sliding_distance_m=last.sliding_distance_m - first.sliding_distance_m,
            wsp_actions=last.wsp_actions - first.wsp_actions,
            greatest_slip=self._greatest_slip,
            peak_disc_temperature_c=self._peak_disc_temperature_c,
        )
