"""When creep is believed that one brake bears less than the others."""

from collections.abc import Sequence
from statistics import fmean

import pytest
from msgspec.structs import replace
from scipy import stats

from brake_monitor.monitoring.brake_units.application_record import ApplicationRecord, WheelsetRecord
from brake_monitor.monitoring.rules.agreed_shares import SURE_T
from brake_monitor.monitoring.rules.told_apart import told_apart

NOMINAL = 0.35
CREEP = 12e-4


def stop(
    shares: Sequence[float],
    friction: float,
    std: float = 0.005,
    *,
    start_s: float = 0.0,
    forces_n: Sequence[float] | None = None,
    creep: float = CREEP,
    creep_std: float = 2e-5,
    creep_err: float = 0.0,
    adhesion: float | None = None,
) -> ApplicationRecord:
    """An application in which the wheelsets creep by these shares; the estimator tells the same friction of all.

    `creep_err`: so much less they seem to, by what the vehicle's speed errs by.
    """
    wheelsets = tuple(
        WheelsetRecord(
            energy_j=1.5e6,
            force_travel_nm=4.5e6,
            friction=friction,
            friction_std=std,
            friction_energy_j=1.4e6,
            pressing_force_n=force_n,
            torque_nm=friction * force_n * 0.247,
            sliding_distance_m=0.0,
            wsp_actions=0,
            greatest_slip=0.003,
            peak_disc_temperature_c=60.0,
            creep=share * creep - creep_err,
            adhesion=adhesion,
            creep_std=creep_std,
        )
        for share, force_n in zip(shares, forces_n or [40e3] * len(shares), strict=True)
    )
    return ApplicationRecord(start_s, start_s + 12.0, 25.0, 10.0, 220.0, 1.0, 0.1, 36e3, None, None, wheelsets)


def frictions(*stops: ApplicationRecord) -> list[float | None]:
    return [own.friction for own in told_apart(stops, NOMINAL).wheelsets]


@pytest.mark.parametrize(
    ("friction", "std", "is_told"),
    [
        (0.22, 0.005, True),
        (0.28, 0.005, True),  # a fifth below nominal
        (0.28, 0.012, False),  # ... or not: 95 % of what it may be reach into the weather
        (0.31, 0.005, False),  # weather does as much
        (0.45, 0.005, True),  # both bite too well, the one more so
    ],
)
def test_where_no_brake_is_as_it_should_be_the_friction_of_all_tells_that_something_is_wrong(
    friction: float, std: float, is_told: bool
) -> None:
    """By creep the one wheelset bears five eighths of what both do."""
    shared = [1.25 * friction, 0.75 * friction]
    assert frictions(stop((1.25, 0.75), friction, std)) == pytest.approx(shared if is_told else [friction] * 2)


@pytest.mark.parametrize(
    ("last", "creep_std", "is_told"),
    [
        ((1.30, 0.70), 2e-4, True),  # by itself it stands no more apart than its noise
        ((1.10, 0.90), 2e-4, False),  # it shows less than half of what stood apart
        ((1.00, 1.00), 2e-4, False),
        ((0.80, 1.20), 3e-4, False),
        ((1.12, 0.88), 2e-5, False),  # it is known better, and no longer apart
    ],
)
def test_what_stood_apart_before_goes_on_in_an_application_that_shows_it_less_clearly(
    last: tuple[float, float], creep_std: float, *, is_told: bool
) -> None:
    """Pads of one that rub half as much: in a light or short braking wheel speeds are too noisy to tell that anew."""
    clear, noisy = stop((1.36, 0.64), 0.26), stop(last, 0.26, start_s=70.0, creep_std=creep_std)
    assert frictions(clear) == pytest.approx([0.26 * 1.36, 0.26 * 0.64])
    assert frictions(clear, noisy) == pytest.approx([0.26 * 1.36, 0.26 * 0.64] if is_told else [0.26, 0.26])


@pytest.mark.parametrize("creep_std", [2e-4, 2e-5])
def test_an_application_whose_creep_is_noise_does_not_tell_how_stiff_the_contact_is(creep_std: float) -> None:
    """It seems far stiffer, as if the others had been near the limit of the rail, so that they did not count."""
    clear, light = stop((1.36, 0.64), 0.26), stop((1.2, 0.8), 0.26, start_s=70.0, creep=4.5e-4, creep_std=creep_std)
    is_told = creep_std > 1e-4
    assert frictions(clear, light) == pytest.approx([0.26 * 1.36, 0.26 * 0.64] if is_told else [0.26, 0.26])


@pytest.mark.parametrize(("own", "last", "is_told"), [(0.65, 0.7, True), (0.65, 0.85, False), (1.4, 1.1, False)])
def test_one_of_four_that_stands_apart_each_time_is_told_by_four_applications_that_agree(
    own: float, last: float, is_told: bool
) -> None:
    """None of the others stands apart, nor is the friction of all off."""
    shares = [[share, *[(4.0 - share) / 3.0] * 3] for share in (own, own, own, last)]
    stops = [stop(of_all, 0.34, start_s=100.0 * k) for k, of_all in enumerate(shares)]
    assert frictions(*stops[:3]) == [0.34] * 4
    expected = [0.34 * (0.75 * all_but_last + 0.25 * lately) for all_but_last, lately in zip(*shares[-2:], strict=True)]
    assert frictions(*stops) == pytest.approx(expected if is_told else [0.34] * 4)


@pytest.mark.parametrize(
    ("own", "is_told"), [(0.55, True), (0.70, True), (0.75, False), (1.0, False), (1.3, False), (1.5, True)]
)
@pytest.mark.parametrize("count", [2, 4])
def test_one_that_bears_30_percent_less_or_the_others_than_it_each_time_is_told_of_two_as_of_four(
    count: int, own: float, is_told: bool
) -> None:
    """Less may be a wheelset under another load, or of another profile, that does as much as the others.

    Of two the one that bears 30 % less than the other bears 18 % less than an equal share.
    """
    whole = (count - 1.0 + own) / count
    shares = [own / whole, *[1.0 / whole] * (count - 1)]
    told = frictions(*[stop(shares, 0.34, start_s=100.0 * k) for k in range(4)])
    assert told == pytest.approx([0.34 * share for share in shares] if is_told else [0.34] * count)


@pytest.mark.parametrize(
    ("own", "last", "is_told"), [(0.7, 0.7, True), (0.7, 0.85, False), (0.7, 1.3, False), (1.4, 0.7, False)]
)
def test_what_many_stops_agree_on_is_not_told_any_more_once_the_last_one_does_not_show_it(
    own: float, last: float, is_told: bool
) -> None:
    shares = [[share, *[(4.0 - share) / 3.0] * 3] for share in [own] * 12 + [last]]
    stops = [stop(of_all, 0.34, start_s=100.0 * k) for k, of_all in enumerate(shares)]
    assert (frictions(*stops) != [0.34] * 4) is is_told


@pytest.mark.parametrize(("creep", "is_told"), [(3e-4, False), (5e-4, True)])
def test_creep_that_is_as_little_as_curves_make_tells_nothing(creep: float, is_told: bool) -> None:
    assert (frictions(stop((1.25, 0.75), 0.22, creep=creep)) != [0.22] * 2) is is_told


def test_where_one_wheelsets_creep_is_not_known_nobodys_share_is() -> None:
    known = stop((1.3, 0.7, 1.3, 0.7), 0.22)
    first, *others = known.wheelsets
    assert frictions(replace(known, wheelsets=(replace(first, creep=None), *others))) == [0.22] * 4


def test_applications_that_agree_are_as_sure_as_the_creep_of_each() -> None:
    """0.7 of a share in each of four, known to 0.25: together to an eighth. It lacks less than three of them."""
    stops = [stop((0.7, 1.1, 1.1, 1.1), 0.34, start_s=100.0 * k, creep_std=0.25 * CREEP) for k in range(4)]
    assert frictions(*stops) == [0.34] * 4


def test_so_many_applications_are_to_agree_as_chance_needs() -> None:
    """Student's t, two-sided at 99.9 %, by what is free in the scatter of 4, 5, … applications."""
    assert pytest.approx([stats.t.ppf(0.9995, 3 + k) for k in range(len(SURE_T))], abs=0.006) == SURE_T


@pytest.mark.parametrize(
    ("force_n", "own", "creep_std", "is_told"),
    [
        (40e3, [0.9] * 12 + [0.7], 2e-5, False),  # a tenth less than the others, but for the last time
        (20e3, [0.9] * 12 + [0.7], 2e-5, False),  # ... which is more than its force says
        (28e3, [0.68] * 4, 2e-5, False),  # of what its force says 0.9
        (28e3, [0.45] * 4, 2e-5, True),
        (28e3, [0.45] * 4, 3e-4, False),  # not surely less than its force says
        (60e3, [0.70] * 4, 2e-5, True),
        (60e3, [0.70] * 4, 3e-4, False),  # not surely less than the others
        (40e3, [0.65, 0.79] * 2, 2e-5, False),  # by so much it scatters too much for four applications
    ],
)
def test_it_bears_less_than_the_others_and_than_its_force_says_beyond_doubt(
    force_n: float, own: Sequence[float], creep_std: float, is_told: bool
) -> None:
    forces_n = [force_n, *[40e3] * 3]
    stops = [
        stop([share, *[(4.0 - share) / 3.0] * 3], 0.34, start_s=100.0 * k, forces_n=forces_n, creep_std=creep_std)
        for k, share in enumerate(own)
    ]
    assert (frictions(*stops) != [0.34] * 4) is is_told


CURVES = [[1.17, 0.88, 1.17, 0.77], [1.49, 0.51, 1.49, 0.51], [1.34, 0.61, 1.44, 0.61], [1.72, 0.27, 1.72, 0.29]]


def test_curves_that_by_chance_turn_the_same_way_four_times_scatter_too_much() -> None:
    """No brake does half of the others' work here, three quarters there, and a quarter elsewhere."""
    stops = [stop(shares, 0.34, start_s=100.0 * k) for k, shares in enumerate(reversed(CURVES))]
    assert frictions(*stops) == [0.34] * 4


@pytest.mark.parametrize(("between", "is_told"), [((0.7, 1.1, 1.1, 1.1), True), ((3.9, -2.0, 4.0, -1.9), False)])
def test_a_wheelset_that_ran_ahead_in_between_shows_how_much_curves_do(between: Sequence[float], is_told: bool) -> None:
    weak = (0.7, 1.1, 1.1, 1.1)
    stops = [stop(shares, 0.34, start_s=100.0 * k) for k, shares in enumerate([weak, between, weak, weak, weak])]
    assert (frictions(*stops) != [0.34] * 4) is is_told


@pytest.mark.parametrize(("own", "is_told"), [(0.4, True), (0.1, True), (-0.125, True), (-0.25, False), (-0.4, False)])
def test_a_wheelset_that_runs_ahead_shows_a_curve_and_no_share(own: float, is_told: bool) -> None:
    """By 1.5e-4 a wheel speed may err, too."""
    assert (frictions(stop((own, *[(4.0 - own) / 3.0] * 3), 0.28)) != [0.28] * 4) is is_told


def test_where_curves_scatter_more_stops_tell_of_a_weak_brake() -> None:
    """It does half of what the others do, each time give or take a fifth."""
    own = [0.5 + 0.2 * (-1) ** k for k in range(13)]
    stops = [stop([share, *[(4.0 - share) / 3.0] * 3], 0.34, start_s=100.0 * k) for k, share in enumerate(own)]
    assert frictions(*stops[:4]) == [0.34] * 4
    assert frictions(*stops)[0] == pytest.approx(0.34 * 0.5, abs=0.02)


@pytest.mark.parametrize(
    ("force_n", "share", "is_told"),
    [
        (4e3, 0.06, False),  # it does a tenth of the others' work; a little noise makes half of that of it
        (20e3, 0.50, False),  # of what its force says 0.57
        (20e3, 0.20, True),
        (20e3, 1.00, False),  # as much as the others, by whatever: nobody stands apart
        (40e3, 0.50, True),
    ],
)
def test_creep_adds_nothing_to_what_pressing_forces_tell_already(force_n: float, share: float, is_told: bool) -> None:
    """A brake that presses less than the others does less: its pads are not to blame."""
    shares = [share, *[(4.0 - share) / 3.0] * 3]
    forces_n = [force_n, *[40e3] * 3]
    found = frictions(stop(shares, 0.28, forces_n=forces_n))
    assert (found != [0.28] * 4) is is_told
    sound = [stop(shares, 0.34, start_s=100.0 * k, forces_n=forces_n) for k in range(4)]  # of all, were it so by chance
    assert (frictions(*sound) != [0.34] * 4) is is_told


def test_brakings_in_which_nothing_creeps_at_all_tell_nothing() -> None:
    """As coarse wheel speeds may say, exactly."""
    still = [stop([0.0] * 4, 0.34, start_s=100.0 * k) for k in range(1, 6)]
    assert frictions(stop([0.7, 1.1, 1.1, 1.1], 0.34), *still) == [0.34] * 4


def test_near_the_peak_a_wheelset_that_bears_no_more_than_the_others_creeps_ever_more() -> None:
    """It is the first one on a damp rail: where that gives ample it creeps by a tenth more than the mean."""
    ample = [stop((1.1, 0.95, 1.0, 0.95), 0.36, start_s=200.0 * k) for k in range(4)]
    little = [stop((1.6, 0.7, 1.0, 0.7), 0.36, start_s=200.0 * k + 100.0, creep=2.5 * CREEP) for k in range(4)]
    for last in (ample, little):
        mixed = sorted([*ample, *little], key=lambda record: record.start_time_s)
        assert frictions(*[record for record in mixed if record.start_time_s <= last[-1].start_time_s]) == [0.36] * 4
    assert frictions(*[replace(one, start_time_s=100.0 * k) for k, one in enumerate(little)]) != [0.36] * 4


def test_a_weak_brake_is_told_by_the_applications_in_which_the_rail_gives_ample() -> None:
    weak = [stop((0.5, 1.1, 1.2, 1.2), 0.34, start_s=200.0 * k) for k in range(4)]
    near_the_peak = [stop((0.2, 1.9, 1.0, 0.9), 0.34, start_s=200.0 * k + 50.0, creep=3.0 * CREEP) for k in range(4)]
    mixed = sorted([*weak, *near_the_peak], key=lambda record: record.start_time_s)
    assert frictions(*mixed) == pytest.approx([0.34 * share for share in (0.5, 1.1, 1.2, 1.2)])


TOO_SLOW = 20e-4  # that a vehicle speed reads while the wagon brakes, relative to it: more than wheelsets creep


def lagging_stops(bears: float, stiffness: float, times: int = 5, force_n: float = 40e3) -> list[ApplicationRecord]:
    """Of four wheelsets, of which the first bears so much of what each of the others does."""
    whole = (3.0 + bears) / 4.0
    return [
        stop(
            (bears / whole, *[1.0 / whole] * 3),
            0.34,
            start_s=100.0 * k,
            forces_n=(force_n, *[40e3] * 3),
            creep=0.06 / stiffness,
            creep_err=TOO_SLOW,
            adhesion=0.06,
        )
        for k in range(times)
    ]


def lagging(bears: float, stiffness: float, times: int = 5, force_n: float = 40e3) -> float:
    """The friction told of the one that lags, over that of each of the others."""
    first, second, *_ = frictions(*lagging_stops(bears, stiffness, times, force_n))
    assert first is not None
    assert second is not None
    return first / second


@pytest.mark.parametrize(("bears", "stiffness"), [(0.0, 60.0), (0.0, 100.0), (0.3, 60.0)])
def test_one_that_bears_little_lags_behind_the_others_though_the_vehicles_speed_hides_how_much_they_creep(
    bears: float, stiffness: float
) -> None:
    """It bears no more than is told of it."""
    assert bears < lagging(bears, stiffness) < 0.8


def test_what_one_that_lags_does_not_bear_the_others_do() -> None:
    """All four together retard the wagon as much as before, whoever of them does it."""
    told = told_apart(lagging_stops(0.0, 60.0), NOMINAL).wheelsets
    assert len({own.friction for own in told}) == 2
    assert fmean(own.friction or 0.0 for own in told) == pytest.approx(0.34)
    assert sum(own.torque_nm or 0.0 for own in told) == pytest.approx(4 * 0.34 * 40e3 * 0.247)


@pytest.mark.parametrize(
    ("bears", "stiffness"),
    [
        (0.8, 30.0),  # unlike wheelsets creep so on the softest contact
        (0.5, 120.0),  # a stiff contact shows no more
        (0.0, 180.0),
    ],
)
def test_what_may_be_unlike_wheelsets_on_a_soft_contact_is_none_of_the_brake(bears: float, stiffness: float) -> None:
    assert lagging(bears, stiffness) == 1.0


def test_it_lags_time_and_again_and_not_as_its_force_says() -> None:
    assert lagging(0.0, 60.0, times=3) == 1.0
    assert lagging(0.0, 60.0, force_n=30e3) == 1.0


@pytest.mark.parametrize(
    ("bears", "creep_std", "is_told"),
    [
        ([0.0] * 6, 2e-5, True),
        ([0.0] * 6, 2e-3, False),  # wheel speeds in coarse steps
        ([0.0, 1.0, 0.0, 1.0, 0.0, 0.0], 2e-5, False),  # curves
        ([0.0] * 20 + [1.0], 2e-5, False),  # it has been mended
        ([0.7] * 20 + [0.4], 2e-5, False),  # it lags as unlike wheelsets may, and more in a curve
    ],
)
def test_it_lags_for_sure_and_in_the_last_application_as_well(
    bears: list[float], creep_std: float, is_told: bool
) -> None:
    stops = [
        stop(
            (share / (3.0 + share) * 4.0, *[4.0 / (3.0 + share)] * 3),
            0.34,
            start_s=100.0 * k,
            creep=1e-3,
            creep_std=creep_std,
            creep_err=TOO_SLOW,
            adhesion=0.06,
        )
        for k, share in enumerate(bears)
    ]
    assert (frictions(*stops) != [0.34] * 4) is is_told


@pytest.mark.parametrize(("creep", "is_told"), [(3.0 * CREEP, False), (0.1 * CREEP, True)])
def test_near_the_rails_limit_it_is_the_others_that_creep(creep: float, is_told: bool) -> None:
    """Where the rail gives ample all creep alike. It is as far behind where hardly any creep is to be seen."""
    ample = [stop((1.0, 1.0, 1.0, 1.0), 0.34, start_s=100.0 * k, adhesion=0.06) for k in range(4)]
    behind = 2.5e-3 / creep
    shares = (1.0 - 0.75 * behind, *[1.0 + 0.25 * behind] * 3)
    then = [stop(shares, 0.34, start_s=400.0 + 100.0 * k, creep=creep, adhesion=0.06) for k in range(6)]
    assert (frictions(*ample, *then) != [0.34] * 4) is is_told


@pytest.mark.parametrize("adhesion", [0.0, -0.01, 0.008])
def test_brakings_that_hardly_use_the_rail_do_not_say_that_one_lags(adhesion: float) -> None:
    """On the softest contact they would make less creep than curves do."""
    shares = (-2.0, 2.0, 2.0, 2.0)
    light = [stop(shares, 0.34, start_s=100.0 * k, creep=1e-4, creep_err=TOO_SLOW, adhesion=adhesion) for k in range(6)]
    assert frictions(*light) == [0.34] * 4


def test_a_stop_whose_adhesion_is_not_known_does_not_say_that_one_lags() -> None:
    """As of a memory from before that was kept."""
    stops = [stop((0.0, 4 / 3, 4 / 3, 4 / 3), 0.34, start_s=100.0 * k, creep_err=TOO_SLOW) for k in range(5)]
    assert frictions(*stops) == [0.34] * 4
