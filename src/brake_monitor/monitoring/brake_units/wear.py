"""What has become of the pads of one wheelset: use, thickness, and how long they still last."""

from math import hypot, sqrt
from typing import Self

from msgspec import Struct
from msgspec.structs import replace

from brake_monitor.estimation.estimate import INTERVAL_SIGMAS
from brake_monitor.settings.wear_settings import WearSettings

MM_PER_CM = 10.0
J_PER_MJ = 1e6
MM3_PER_CM3 = 1e3
LEAST_RELATIVE_STD = 0.05  # wear depends on weather and braking; no calibration makes it more certain
POSSIBLE_SIGMAS = 3.0  # of a loss: what is further from any rate that pads have is none of theirs
DISAGREED = 0.5  # of what readings disagree by stays in doubt: the rate has changed, or one of them is wrong
RECENT_STOPS = 50  # "recent use" forgets to 37 % within as many


class PadUse(Struct, frozen=True, gc=False):  # only numbers: nothing that could hold itself
    """What the pads of one wheelset went through, all together."""

    energy_j: float = 0.0
    force_travel_nm: float = 0.0  # ∫ F r_B |omega| dt, the F s of Archard's law
    stops: float = 0.0  # brake applications; whole but in averages
    sliding_distance_m: float = 0.0
    distance_m: float = 0.0

    def plus(self, more: "PadUse", share: float = 1.0) -> "PadUse":
        """This share of it, and more."""
        return PadUse(
            share * self.energy_j + more.energy_j,
            share * self.force_travel_nm + more.force_travel_nm,
            share * self.stops + more.stops,
            share * self.sliding_distance_m + more.sliding_distance_m,
            share * self.distance_m + more.distance_m,
        )


class Rate(Struct, frozen=True):
    """A wear rate and its standard deviation, in the same unit."""

    value: float
    std: float

    def calibrated(self, shown: "Rate | None", least: float, greatest: float, fleet_std: float) -> "Rate":
        """The rate, given also what a loss has shown, if anything: both weighted by their variances.

        No rate is learned where no pad loses as much or as little: the monitor was off, or a reading is wrong. One that
        contradicts what was known leaves it in doubt, at most as much as before anything was measured (`fleet_std`).
        """
        if shown is None:
            return self
        measured, measured_std = shown.value, shown.std
        if not least - POSSIBLE_SIGMAS * measured_std <= measured <= greatest + POSSIBLE_SIGMAS * measured_std:
            return self
        weight = self.std**2 / (self.std**2 + measured_std**2)
        value = min(max(self.value + weight * (measured - self.value), least), greatest)
        known_std = max(self.std * (1.0 - weight) ** 0.5, LEAST_RELATIVE_STD * value)
        disagreed = sqrt(max((measured - self.value) ** 2 - self.std**2 - measured_std**2, 0.0))
        return Rate(value, max(min(hypot(known_std, DISAGREED * disagreed), fleet_std), known_std))


class PadWear(Struct, frozen=True):
    """The pads of one wheelset as they are kept over restarts."""

    fitted_time_s: float | None  # when new pads were noted; None: since the monitor was installed
    gauged_time_s: float | None  # when their thickness was last measured; None: taken as new
    gauge_thickness_mm: float  # at the last measurement, or when new
    gauge_std_mm: float
    specific_wear_cm3_per_mj: Rate
    archard_mm3_per_nm: Rate
    since_fitted: PadUse = PadUse()
    since_gauge: PadUse = PadUse()
    recent: PadUse = PadUse()  # fading sums over the last stops
    before_entry: "PadWear | None" = None  # as they were when they were measured last, or fitted: to be taken back

    @classmethod
    def new(cls, settings: WearSettings, time_s: float | None = None) -> Self:
        """New pads, with the wear rates that the settings say."""
        relative_std = settings.specific_wear_std_cm3_per_mj / settings.specific_wear_cm3_per_mj
        return cls(
            fitted_time_s=time_s,
            gauged_time_s=None,
            gauge_thickness_mm=settings.new_pad_thickness_mm,
            gauge_std_mm=settings.new_pad_thickness_std_mm,
            specific_wear_cm3_per_mj=Rate(settings.specific_wear_cm3_per_mj, settings.specific_wear_std_cm3_per_mj),
            archard_mm3_per_nm=Rate(settings.archard_mm3_per_nm, settings.archard_mm3_per_nm * relative_std),
        )

    @property
    def is_noted(self) -> bool:
        """Whether anybody has measured them, or noted that they were new."""
        return self.fitted_time_s is not None or self.gauged_time_s is not None

    def as_configured(self, settings: WearSettings) -> "PadWear":
        """Pads of which nobody noted anything are what the settings say, which may have been put right since."""
        if self.is_noted:
            return self
        new = PadWear.new(settings)
        return replace(new, since_fitted=self.since_fitted, since_gauge=self.since_gauge, recent=self.recent)

    def used(self, use: PadUse) -> "PadWear":
        """After some more use."""
        return replace(
            self,
            since_fitted=self.since_fitted.plus(use),
            since_gauge=self.since_gauge.plus(use),
            recent=self.recent.plus(use, 1.0 - min(use.stops / RECENT_STOPS, 1.0)),
        )

    def gauged(
        self, settings: WearSettings, time_s: float, thickness_mm: float, gauge_std_mm: float | None = None
    ) -> "PadWear":
        """The thickness was measured: count from it, and learn the wear rates from what was lost since the last one.

        Pads of which nothing had been noted may have been worn as the monitor came: they teach nothing yet.
        """
        std_mm = settings.gauge_std_mm if gauge_std_mm is None else gauge_std_mm
        lost_mm, lost_std_mm = self.gauge_thickness_mm - thickness_mm, hypot(self.gauge_std_mm, std_mm)
        least = settings.least_specific_wear_cm3_per_mj
        greatest = settings.greatest_specific_wear_cm3_per_mj
        used = self.since_gauge if self.is_noted else PadUse()
        by_rates_of_1_mm = (
            energy_loss_mm(used.energy_j, 1.0, settings),
            archard_loss_mm(used.force_travel_nm, 1.0, settings),
        )
        by_energy, by_archard = [Rate(lost_mm / mm, lost_std_mm / mm) if mm > 0.0 else None for mm in by_rates_of_1_mm]
        archard_per_energy = settings.archard_mm3_per_nm / settings.specific_wear_cm3_per_mj
        fleet_std = settings.specific_wear_std_cm3_per_mj
        return replace(
            self,
            gauged_time_s=time_s,
            gauge_thickness_mm=thickness_mm,
            gauge_std_mm=std_mm,
            since_gauge=PadUse(),
            specific_wear_cm3_per_mj=self.specific_wear_cm3_per_mj.calibrated(by_energy, least, greatest, fleet_std),
            archard_mm3_per_nm=self.archard_mm3_per_nm.calibrated(
                by_archard, least * archard_per_energy, greatest * archard_per_energy, fleet_std * archard_per_energy
            ),
            before_entry=replace(self, before_entry=None),
        )

    def renewed(self, settings: WearSettings, time_s: float) -> "PadWear":
        """New pads were fitted; of the old ones only the wear rates and the recent use are of value."""
        return replace(
            PadWear.new(settings, time_s),
            specific_wear_cm3_per_mj=self.specific_wear_cm3_per_mj,
            archard_mm3_per_nm=self.archard_mm3_per_nm,
            recent=self.recent,
            before_entry=replace(self, before_entry=None),
        )

    def taken_back(self) -> "PadWear":
        """As if the last entry, a thickness or new pads, had not been made; what they did since counts."""
        if self.before_entry is None:
            return self
        return replace(
            self.before_entry,
            since_fitted=self.before_entry.since_fitted.plus(self.since_gauge),
            since_gauge=self.before_entry.since_gauge.plus(self.since_gauge),
            recent=self.recent,
        )


class Thickness(Struct, frozen=True):
    """A pad's thickness and the interval that holds it with 95 %."""

    value_mm: float
    std_mm: float
    low_mm: float
    high_mm: float


class PadLife(Struct, frozen=True):
    """What a maintenance engineer wants to know of the pads of one wheelset."""

    by_energy: Thickness
    by_archard: Thickness
    remaining_mm: float  # to the limit, by energy, from the expected thickness; 0 at or below the limit
    remaining_stops: float | None  # None: too little recent use to tell
    remaining_km: float | None


def pad_life(pads: PadWear, settings: WearSettings) -> PadLife:
    """Thickness now and what is left of it."""
    rate, k = pads.specific_wear_cm3_per_mj, pads.archard_mm3_per_nm
    by_energy = _thickness(pads, energy_loss_mm(pads.since_gauge.energy_j, rate.value, settings), rate)
    by_archard = _thickness(pads, archard_loss_mm(pads.since_gauge.force_travel_nm, k.value, settings), k)
    remaining_mm = max(by_energy.value_mm - settings.pad_limit_mm, 0.0)
    recent_mm = energy_loss_mm(pads.recent.energy_j, rate.value, settings)
    known = recent_mm > 0.0 and pads.recent.stops >= 1.0
    return PadLife(
        by_energy,
        by_archard,
        remaining_mm,
        remaining_mm / recent_mm * pads.recent.stops if known else None,
        remaining_mm / recent_mm * pads.recent.distance_m / 1000.0 if known else None,
    )


def expected_thickness_mm(pads: PadWear, settings: WearSettings) -> float:
    """Thickness now by energy, as in `pad_life`."""
    lost_mm = energy_loss_mm(pads.since_gauge.energy_j, pads.specific_wear_cm3_per_mj.value, settings)
    return max(pads.gauge_thickness_mm - lost_mm, 0.0)


def energy_loss_mm(energy_j: float, specific_wear_cm3_per_mj: float, settings: WearSettings) -> float:
    """Thickness w E_pad / A_pad of each pad when all pads of the wheelset took `energy_j`."""
    pad_energy_mj = energy_j / J_PER_MJ / settings.pads_per_wheelset
    return specific_wear_cm3_per_mj * pad_energy_mj / settings.pad_area_cm2 * MM_PER_CM


def archard_loss_mm(force_travel_nm: float, archard_mm3_per_nm: float, settings: WearSettings) -> float:
    """Thickness k F s / A_pad (Archard) of each pad, F s being that of all pads of the wheelset."""
    pad_volume_cm3 = archard_mm3_per_nm * force_travel_nm / settings.pads_per_wheelset / MM3_PER_CM3
    return pad_volume_cm3 / settings.pad_area_cm2 * MM_PER_CM


def _thickness(pads: PadWear, lost_mm: float, rate: Rate) -> Thickness:
    """The measured thickness less what was lost since; both are uncertain, the wear rate more so."""
    value_mm = max(pads.gauge_thickness_mm - lost_mm, 0.0)
    std_mm = hypot(pads.gauge_std_mm, lost_mm * rate.std / rate.value)
    doubt_mm = INTERVAL_SIGMAS * std_mm
    return Thickness(
        value_mm,
        std_mm,
        max(value_mm - doubt_mm, 0.0),
        min(value_mm + doubt_mm, pads.gauge_thickness_mm + INTERVAL_SIGMAS * pads.gauge_std_mm),
    )
