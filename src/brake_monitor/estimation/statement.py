"""Readout → Estimate: what is known at an instant, in words."""

from collections.abc import Mapping, Sequence
from math import isnan

from brake_monitor.estimation.brake_work import WheelsetWork
from brake_monitor.estimation.core.core import Core
from brake_monitor.estimation.core.readout import (
    DOUBTED,
    LOST,
    OF_WAGON,
    OF_WHEELSET,
    SETTLING,
    UNCERTAIN,
    UNOBSERVABLE,
    VALID,
    WagonReadout,
    WheelsetReadout,
)
from brake_monitor.estimation.doubts.consistency import in_words
from brake_monitor.estimation.estimate import BEGINS, Estimate, Status, WheelsetEstimate
from brake_monitor.estimation.input_trust import InputTrust
from brake_monitor.estimation.known_inputs import KnownInputs
from brake_monitor.samples import Measurand, Quantity

STATUS: Mapping[float, Status] = {
    VALID: Status.VALID,
    LOST: Status.INVALID,
    UNOBSERVABLE: Status.HELD,
    SETTLING: Status.CONVERGING,
    UNCERTAIN: Status.CONVERGING,
    DOUBTED: Status.CONVERGING,
}
REASONS: Mapping[float, tuple[str, ...]] = {
    VALID: (),
    UNOBSERVABLE: ("standstill",),
    SETTLING: (BEGINS,),
    UNCERTAIN: ("adhesion uncertain",),
    DOUBTED: (),
}


class Statement:
    """Says what the readout of one estimator means."""

    def __init__(self, trust: InputTrust, known: KnownInputs, core: Core) -> None:
        self._trust = trust
        self._known = known
        self._signals = _signals_of(core.wheelset_count, one_flag=core.one_wsp_signal)
        self._trusted = trust.known
        self._unknown = frozenset(self._signals)

    def estimate(
        self, readout: Sequence[float], time_s: float | None, reset_count: int, clock_ahead_s: float
    ) -> Estimate:
        """Say what is known at time_s, when nothing came since; None: as of the last fused sample."""
        wagon = WagonReadout._make(readout[:OF_WAGON])
        begins = range(OF_WAGON, len(readout), OF_WHEELSET)
        found = [WheelsetReadout._make(readout[begin : begin + OF_WHEELSET]) for begin in begins]
        status = STATUS[wagon.trust]
        return Estimate(
            time_s=wagon.time_s if time_s is None else time_s,
            speed_mps=wagon.speed_mps,
            distance_m=wagon.distance_m,
            adhesion=wagon.adhesion,
            adhesion_std=wagon.adhesion_std,
            saturated=wagon.saturated != 0.0,
            deceleration_mps2=wagon.deceleration_mps2,
            deceleration_std_mps2=wagon.deceleration_std_mps2,
            wheelsets=tuple([_wheelset(each, status) for each in found]),
            mass_kg=wagon.mass_kg,
            sanding=self._known.sanding,
            latitude_deg=self._known.position_deg.get(Quantity.LATITUDE),
            longitude_deg=self._known.position_deg.get(Quantity.LONGITUDE),
            status=status,
            reasons=self._reasons(wagon),
            nis=wagon.nis,
            reset_count=reset_count,
            speed_scatters=wagon.speed_scatters != 0.0,
            unknown=self._unknown_now(),
            clock_ahead_s=clock_ahead_s,
        )

    def _unknown_now(self) -> frozenset[Measurand]:
        if self._trust.known is not self._trusted:  # which is seldom
            self._trusted = self._trust.known
            self._unknown = frozenset(what for what, by in self._signals.items() if by not in self._trusted)
        return self._unknown

    def _reasons(self, wagon: WagonReadout) -> tuple[str, ...]:
        """Why an estimate is not valid."""
        doubts = in_words(int(wagon.doubts)) if wagon.trust in (LOST, UNCERTAIN, DOUBTED) else ()
        if wagon.trust == LOST:
            return (*self._trust.reasons(), *doubts)
        return (*REASONS[wagon.trust], *doubts)


def _signals_of(wheelset_count: int, *, one_flag: bool) -> dict[Measurand, Measurand]:
    """The signal of each input that an estimate repeats; `one_flag`: that of the first wheelset is for all."""
    signals = {(quantity, 0): (quantity, 0) for quantity in (Quantity.SPEED, Quantity.SANDING)}
    for i in range(wheelset_count):
        signals |= {(quantity, i): (quantity, i) for quantity in (Quantity.AXLE_SPEED, Quantity.PRESSING_FORCE)}
        signals[Quantity.WSP_ACTIVE, i] = (Quantity.WSP_ACTIVE, 0 if one_flag else i)
    return signals


def _wheelset(found: WheelsetReadout, status: Status) -> WheelsetEstimate:
    return WheelsetEstimate(
        omega_radps=found.omega_radps,
        omega_noise=found.omega_noise,
        slip=found.slip,
        friction=found.friction,
        friction_std=found.friction_std,
        line_friction_std=found.line_friction_std,
        friction_status=STATUS[found.friction_trust],
        adhesion=found.adhesion,
        adhesion_std=found.adhesion_std,
        adhesion_status=status,
        pressing_force_n=found.pressing_force_n,
        renewed_slides=int(found.renewed_slides),
        speed_scatters=found.speed_scatters != 0.0,
        wsp_active=found.wsp_active != 0.0,
        is_protected=found.is_protected != 0.0,
        motor_force_n=None if isnan(found.motor_force_n) else found.motor_force_n + 0.0,
        relative_load=found.relative_load,
        work=WheelsetWork(found.pad_energy_j, found.force_travel_nm, found.sliding_distance_m, int(found.wsp_actions)),
    )
