"""Filters of like wagons share their straight lines, and no others do."""

from dataclasses import replace

import pytest
from msgspec import structs

from brake_monitor.estimation.filter.filter_lines import (
    CorrectionFlags,
    Equations,
    StepFlags,
    correction_line,
    loads_line,
    step_line,
)
from brake_monitor.estimation.model.regime import FixedDensities
from brake_monitor.estimation.model.wagon import FrictionRelaxation, Wagon
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.validation.variants import PrintedWagon

VEHICLE = example_settings("wagon").vehicle
WAGON = Wagon.from_vehicle(VEHICLE)
FIRST, SECOND = WAGON.wheelsets
DENSITIES = FixedDensities(*[1e-4] * len(FixedDensities._fields))
BRAKED = StepFlags(braked=True, driven=False, all_roll=False, has_slid=False, lag_observable=False, is_taped=False)
RUBBING = CorrectionFlags(near_standstill=False, any_friction_observable=True, has_slid=False, lag_observable=False)


def equations(wagon: Wagon | None = None) -> Equations:
    """Of a wagon that is made anew, as each filter does."""
    return Equations(wagon or Wagon.from_vehicle(VEHICLE), DENSITIES, literal=False)


def test_those_of_like_wagons_are_the_same() -> None:
    one, other = equations(), equations()
    assert step_line(one, BRAKED) is step_line(other, BRAKED)
    assert loads_line(one.wagon) is loads_line(other.wagon)
    first, second = (correction_line(each.wagon.layout, 0, RUBBING) for each in (one, other))
    assert first is second


OTHERS = {
    "more drag": equations(replace(WAGON, vehicle=structs.replace(VEHICLE, drag_n_per_mps2=3.0))),
    "a worn wheel": equations(replace(WAGON, wheelsets=(FIRST._replace(wheel_radius_m=0.44), SECOND))),
    "another brake": equations(replace(WAGON, wheelsets=(FIRST, SECOND._replace(brake_radius_m=0.24)))),
    "another load": equations(replace(WAGON, wheelsets=(FIRST._replace(load_share=0.52), SECOND))),
    "friction that relaxes": equations(Wagon.from_vehicle(VEHICLE, FrictionRelaxation(nominal=0.35, time_s=5.0))),
    "the printed model": equations(PrintedWagon.from_vehicle(VEHICLE)),
    "a motor": equations(Wagon.from_vehicle(VEHICLE, has_motors=True)),
    "restless friction": equations()._replace(densities=DENSITIES._replace(friction=1e-3)),
    "equations to the letter": equations()._replace(literal=True),
}


@pytest.mark.parametrize("other", OTHERS.values(), ids=OTHERS)
def test_those_of_others_are_not(other: Equations) -> None:
    assert step_line(other, BRAKED) is not step_line(equations(), BRAKED)
