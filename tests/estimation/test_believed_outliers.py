"""What is left alone as readings that leave their prediction again and again have to be believed."""

import numpy as np

from brake_monitor.estimation.core.correction import BELIEFS_IN_A_ROW, DOUBTED_ADHESION_STD, OUTLIERS_BELIEVED
from test_doubted_friction import braking

GATE = 0.1
IN_ALL = OUTLIERS_BELIEVED * BELIEFS_IN_A_ROW


def test_a_vehicle_speed_that_jumps_and_jumps_tells_nothing_of_what_is_unmodelled_or_used() -> None:
    core = braking(2).core
    speed, variances = core.wheelset_count, np.diag(core.filter.covariance).copy()
    for k in range(IN_ALL):
        core.meet_outlier(speed, 20.0 + k, 0.02**2, 5.0, GATE)
    assert core.filter.x[speed] == 20.0 + IN_ALL - 1
    others = np.arange(len(variances)) != speed
    assert (np.diag(core.filter.covariance)[others] == variances[others]).all()


def test_a_wheel_speed_that_does_widens_the_adhesion_of_its_wheelset_and_no_others() -> None:
    core = braking(2).core
    variances = np.diag(core.filter.covariance).copy()
    for k in range(IN_ALL):
        core.meet_outlier(1, 30.0 + k, 0.02**2, 5.0, GATE)
    changed = np.flatnonzero(np.diag(core.filter.covariance) != variances)
    assert changed.tolist() == [1, core.adhesion_place + 1]
    place = core.adhesion_place + 1
    assert core.filter.covariance[place][place] == DOUBTED_ADHESION_STD**2
