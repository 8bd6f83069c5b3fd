"""What is kept of a brake application, from the first pressing pad until all are released or the wagon stands."""

from math import sqrt

from msgspec import Struct
from msgspec.structs import replace

TOLD_SHARE = 0.5  # of the energy; wet or icy pads rub little at first, and while they recover nothing is told of them


class WheelsetRecord(Struct, frozen=True):
    """One wheelset's share of a brake application."""

    energy_j: float
    force_travel_nm: float
    friction: float | None  # mean mu_b weighted by energy where it was valid; None: it never was
    friction_std: float | None  # including the doubt from a gradient that may have changed meanwhile
    friction_energy_j: float  # the energy behind this mean
    pressing_force_n: float | None  # mean over the way on which pads alone braked, and no wheelset slid
    torque_nm: float | None  # the same mean of the brake torque
    sliding_distance_m: float
    wsp_actions: int
    greatest_slip: float
    peak_disc_temperature_c: float
    creep: float | None = None  # mean of slip against free rolling before, if it goes with adhesion; at mean wheel load
    creep_std: float | None = None  # by the noise of its speed; older memories have none
    friction_gradient_std: float | None = None  # the gradient's part of friction_std; older memories have none
    adhesion: float | None = None  # mean while creep was told; older memories have none
    friction_prior_std: float | None = None  # of friction as it was first told in it; older memories have none

    @property
    def own_friction_std(self) -> float:
        """The deviation of the friction itself, without the gradient's part, which differs between applications.

        What is learned of it goes from one application to the next, and so does its error: in a train, where it hardly
        shows, it may wander as far without any scatter.
        """
        std, gradient_std = self.friction_std or 0.0, self.friction_gradient_std or 0.0
        return sqrt(max(std * std - gradient_std * gradient_std, 0.0))

    def then(self, later: "WheelsetRecord") -> "WheelsetRecord":
        """Both parts of an interrupted application; means over the whole of it are not known."""
        return WheelsetRecord(
            energy_j=self.energy_j + later.energy_j,
            force_travel_nm=self.force_travel_nm + later.force_travel_nm,
            friction=None,
            friction_std=None,
            friction_energy_j=0.0,
            pressing_force_n=None,
            torque_nm=None,
            sliding_distance_m=self.sliding_distance_m + later.sliding_distance_m,
            wsp_actions=self.wsp_actions + later.wsp_actions,
            greatest_slip=max(self.greatest_slip, later.greatest_slip),
            peak_disc_temperature_c=max(self.peak_disc_temperature_c, later.peak_disc_temperature_c),
        )

    def tells_friction(self, least_energy_j: float) -> bool:
        """Whether friction was told for so much of the energy, and for most of it: else it is the mean of a part."""
        told_j = self.friction_energy_j
        return self.friction is not None and told_j >= max(least_energy_j, TOLD_SHARE * self.energy_j)


class ApplicationRecord(Struct, frozen=True):
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
    wheelsets: tuple[WheelsetRecord, ...]
    calibration: int | None = None  # of its friction, `Settings.calibration`; older memories have none

    def then(self, later: "ApplicationRecord") -> "ApplicationRecord":
        """Both parts of an application that the program did not see all of: its start and end, and what adds up."""
        return replace(
            later,
            start_time_s=self.start_time_s,
            start_speed_mps=self.start_speed_mps,
            distance_m=self.distance_m + later.distance_m,
            greatest_deceleration_mps2=max(self.greatest_deceleration_mps2, later.greatest_deceleration_mps2),
            greatest_adhesion=max(self.greatest_adhesion, later.greatest_adhesion),
            latitude_deg=self.latitude_deg,
            longitude_deg=self.longitude_deg,
            wheelsets=tuple(own.then(more) for own, more in zip(self.wheelsets, later.wheelsets, strict=True)),
        )
