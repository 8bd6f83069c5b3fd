"""An alarm about inputs says what is wrong now, and no more of what was."""

import pytest
from msgspec.structs import replace

from brake_monitor.monitoring.alarm import Alarm, Severity
from brake_monitor.monitoring.monitor import Monitor
from brake_monitor.monitoring.reports import GOOD, BusReport
from brake_monitor.monitoring.rule import FINE, UNKNOWN, Finding, Verdict
from brake_monitor.monitoring.rules.all_rules import wagon_rules
from brake_monitor.monitoring.rules.inputs import InputImplausible, InputLost
from brake_monitor.samples import InputCondition, Quantity
from brake_monitor.settings.alarm_settings import AlarmSettings
from estimates import estimate, observation, report
from estimates import wheelset as wheelset_that

LOST, FROZEN, OUT_OF_RANGE = InputCondition.LOST, InputCondition.FROZEN, InputCondition.OUT_OF_RANGE
AWAITED = InputCondition.AWAITED
BUS = BusReport("can0", 0.0, 0, False)


class Wagon:
    """Two signals of its own, one of which estimates need, and what is thought of them."""

    def __init__(self) -> None:
        self.monitor, self.time_s = Monitor(wagon_rules(AlarmSettings(), 2)), 1000.0

    def told(self, speed: InputCondition, latitude: InputCondition, lasting_s: float) -> list[Alarm]:
        """What is given out while it is so."""
        inputs = (
            report(Quantity.SPEED, 0, "GNSS.v", speed, bus=BUS.name),
            report(Quantity.LATITUDE, 0, "GNSS.lat", latitude, bus=BUS.name),
        )
        given: list[Alarm] = []
        for _ in range(round(lasting_s * 10)):
            self.time_s += 0.1
            given += self.monitor.see(observation(estimate(time_s=self.time_s), inputs, (BUS,)))
        return given


@pytest.mark.parametrize("wrong", [LOST, FROZEN])
def test_what_is_cured_is_named_no_more_though_it_was_the_graver(wrong: InputCondition) -> None:
    wagon = Wagon()
    (raised,) = wagon.told(wrong, wrong, 5.0)
    assert (raised.severity, raised.evidence["inputs"]) == (Severity.WARNING, "speed, latitude")
    (told,) = wagon.told(GOOD, wrong, 15.0)
    assert told.id == raised.id
    assert told.evidence["inputs"] == "latitude"
    assert "speed" not in told.message
    assert told.severity is Severity.WARNING  # the gravest it has been
    (cleared,) = wagon.told(GOOD, GOOD, 15.0)
    assert cleared.cleared_time_s is not None


def test_an_alarm_about_one_signal_is_not_kept_up_by_another_that_is_lost() -> None:
    wagon = Wagon()
    (raised,) = wagon.told(OUT_OF_RANGE, GOOD, 5.0)
    given = wagon.told(GOOD, LOST, 20.0)
    assert [(alarm.kind, alarm.cleared_time_s is None) for alarm in given] == [
        ("input_lost", True),
        (raised.kind, False),
    ]


@pytest.mark.parametrize(
    ("quantity", "at_zero", "works"),
    [
        (Quantity.AXLE_SPEED, {"omega_radps": 0.0}, {"omega_radps": 20.0}),
        (Quantity.PRESSING_FORCE, {"pressing_force_n": 0.0}, {"pressing_force_n": 9e3}),
    ],
)
def test_a_sensor_that_was_dead_is_not_known_to_be_cured_while_it_says_0(
    quantity: Quantity, at_zero: dict[str, float], works: dict[str, float]
) -> None:
    """As it does at each standstill and release; and on the morning after a night without the program."""
    rule = InputImplausible(AlarmSettings().input_implausible, 1)
    own, other = report(quantity, 0, "A.own", GOOD), report(Quantity.LOAD_FORCE, 0, "A.load", GOOD)

    def verdict(own_is: InputCondition, other_is: InputCondition, wheelset: dict[str, float]) -> Verdict:
        inputs = (replace(own, condition=own_is), replace(other, condition=other_is))
        return rule.judge(observation(estimate(wheelsets=(wheelset_that(**wheelset),)), inputs, ()))[1]

    assert verdict(GOOD, GOOD, at_zero) is FINE  # it stands, and nothing was wrong
    assert isinstance(verdict(InputCondition.CONTRADICTED, GOOD, at_zero), Finding)
    for other_is in (GOOD, LOST, GOOD):
        assert verdict(GOOD, other_is, at_zero) is UNKNOWN
    assert verdict(GOOD, GOOD, works) is FINE
    assert verdict(GOOD, GOOD, at_zero) is FINE
    rule.resume(1, {"signals": "A.own"})
    assert verdict(GOOD, GOOD, at_zero) is UNKNOWN
    assert verdict(GOOD, GOOD, works) is FINE


def test_a_wheel_speed_is_not_known_to_be_cured_where_the_vehicles_says_nothing() -> None:
    """As at the end of the day, when one message ceases before the other."""
    rule = InputImplausible(AlarmSettings().input_implausible, 1)
    verdicts = []
    for own_is, speed_is in ((InputCondition.CONTRADICTED, GOOD), (GOOD, LOST), (GOOD, GOOD)):
        inputs = (report(Quantity.SPEED, 0, "GNSS.v", speed_is), report(Quantity.AXLE_SPEED, 0, "WSP.n", own_is))
        now = estimate(wheelsets=(wheelset_that(omega_radps=20.0),))
        verdicts.append(rule.judge(observation(now, inputs, ()))[1])
    assert isinstance(verdicts[0], Finding)
    assert verdicts[1:] == [UNKNOWN, FINE]


def test_a_signal_that_is_lost_is_not_known_to_be_cured() -> None:
    wagon = Wagon()
    (raised,) = wagon.told(OUT_OF_RANGE, GOOD, 5.0)
    given = wagon.told(LOST, GOOD, 60.0)
    assert {alarm.kind for alarm in given} == {"input_lost"}
    assert raised.id in {alarm.id for alarm in wagon.monitor.open_alarms()}


def test_a_bus_that_is_up_again_is_told_of_its_error_frames_alone() -> None:
    monitor, told = Monitor(wagon_rules(AlarmSettings(), 2)), []
    for second in range(30):
        bus = BusReport("can0", 0.0, 20 * second, is_off=second < 5)
        told += monitor.see(observation(estimate(time_s=1000.0 + second), (), (bus,)))
    assert (told[0].evidence["bus_off"], told[-1].evidence["bus_off"]) == ("yes", "no")
    assert "off" not in told[-1].message


@pytest.mark.parametrize(
    ("quantity", "condition", "to_check"),
    [
        (Quantity.AXLE_SPEED, InputCondition.CONTRADICTED, ", and that the wheelset turns"),
        (Quantity.PRESSING_FORCE, InputCondition.CONTRADICTED, ", and that it measures what reaches the cylinder"),
        (Quantity.AXLE_SPEED, InputCondition.REPEATED, ", and the gateway that may tell again what it was told last"),
        (Quantity.PRESSING_FORCE, FROZEN, ""),
    ],
)
def test_what_is_wrong_with_a_wheelsets_signal_is_told_of_it_with_what_to_check(
    quantity: Quantity, condition: InputCondition, to_check: str
) -> None:
    """Another one of the same wheelset is out of its range, which says nothing of the first."""
    inputs = (report(quantity, 1, "A.b", condition), report(Quantity.WHEEL_TORQUE, 1, "A.c", OUT_OF_RANGE))
    wagon, first, second = InputImplausible(AlarmSettings().input_implausible, 2).judge(observation(estimate(), inputs))
    assert (wagon, first) == (FINE, FINE)
    assert isinstance(second, Finding)
    assert second.message.endswith(f"check sensor and wiring{to_check}.")


@pytest.mark.parametrize("condition", [InputCondition.NOT_AVAILABLE, InputCondition.OUT_OF_RANGE])
def test_a_vehicle_speed_that_is_not_available_may_be_a_receivers_without_a_sky(condition: InputCondition) -> None:
    inputs = (report(Quantity.SPEED, 0, "GNSS.v", condition),)
    wagon, *_ = InputImplausible(AlarmSettings().input_implausible, 2).judge(observation(estimate(), inputs))
    assert isinstance(wagon, Finding)
    assert ("in a tunnel" in wagon.message) is (condition is InputCondition.NOT_AVAILABLE)


@pytest.mark.parametrize(("flags", "told_of"), [(1, 0), (2, 1)])
def test_a_flag_that_there_is_but_one_of_is_the_wagons(flags: int, told_of: int) -> None:
    inputs = tuple(report(Quantity.WSP_ACTIVE, i, f"WSP.{i}", GOOD if i else FROZEN) for i in range(flags))
    inputs += (report(Quantity.SPEED, 0, "GNSS.v", GOOD),)
    verdicts = InputImplausible(AlarmSettings().input_implausible, 2).judge(observation(estimate(), inputs))
    assert [isinstance(verdict, Finding) for verdict in verdicts] == [k == told_of for k in range(3)]


def lost_on_a_bus(silent_s: float, expected_s: float = 0.1, *, is_off: bool = False) -> tuple[Verdict, ...]:
    """The first wheel speed is lost at 10 s, the second one has never come; it is 13 s, and their bus is like this."""
    rule = InputLost(AlarmSettings().input_lost, 2)
    for time_s in (9.0, 10.0, 13.0):
        inputs = (
            report(Quantity.SPEED, 0, "GNSS.v", GOOD, bus="front"),
            report(Quantity.AXLE_SPEED, 0, "WSP.n_A", LOST if time_s >= 10.0 else GOOD, bus="rear"),
            report(Quantity.AXLE_SPEED, 1, "WSP.n_B", AWAITED, bus="rear"),
        )
        buses = (
            BusReport("front", 0.0, 0, False),
            BusReport("rear", silent_s if time_s == 13.0 else 0.1, 0, is_off, expected_s),
        )
        verdicts = rule.judge(observation(estimate(time_s=time_s), inputs, buses))
    return verdicts


def test_what_is_lost_on_a_bus_that_goes_on_is_told_of_and_what_has_yet_to_come_is_not() -> None:
    wagon, first, second = lost_on_a_bus(0.1)
    assert (wagon, second) == (FINE, FINE)
    assert isinstance(first, Finding)
    assert first.message == "Nothing arrives any more of the wheel speed (WSP.n_A) of wheelset 1."
    assert isinstance(lost_on_a_bus(2.0, expected_s=2.5)[1], Finding)  # it is never quicker


@pytest.mark.parametrize("silent_s", [0.7, 2.0, 3.5])
def test_what_is_lost_on_a_bus_that_is_silent_now_is_not_told_of(silent_s: float) -> None:
    """Before it fell silent the bus may have gone on without the signal for a while: that is not judged any more."""
    assert not any(isinstance(verdict, Finding) for verdict in lost_on_a_bus(silent_s))
    assert not any(isinstance(verdict, Finding) for verdict in lost_on_a_bus(0.1, is_off=True))


@pytest.mark.parametrize("period_s", [0.6, 1.0, 2.0])
def test_what_is_lost_is_told_of_though_one_slow_sender_is_all_that_is_left_on_the_bus(period_s: float) -> None:
    """All that is sent often is gone; a load goes on. And then it is gone, too: the bus is to blame from then on."""
    rule = InputLost(AlarmSettings().input_lost, 1)
    told = []
    for k in range(301):
        time_s = 0.1 * k
        ends_s = min(time_s, 20.0)  # of the load
        heard_s = time_s if time_s <= 5.0 else 5.0 + period_s * ((ends_s - 5.0 + 1e-9) // period_s)
        inputs = (
            report(Quantity.SPEED, 0, "GNSS.v", LOST if time_s > 5.2 else GOOD, bus=BUS.name),
            report(Quantity.LOAD_FORCE, 0, "BCU.load", LOST if time_s > 20.0 + 3.0 * period_s else GOOD, bus=BUS.name),
        )
        buses = (BusReport(BUS.name, time_s - heard_s, 0, False, 0.2),)
        told.append(rule.judge(observation(estimate(time_s=time_s), inputs, buses))[0])
    found = [isinstance(verdict, Finding) for verdict in told]
    assert not any(found[:54])
    assert all(found[round(10.0 * (5.0 + 2.2 * period_s)) : 200])
    assert all(verdict is UNKNOWN for verdict in told[round(10.0 * (20.2 + 2.5 * period_s)) :])


def verdict_beside_a_silent_bus(speed: InputCondition, force: InputCondition) -> Verdict:
    """The speed of a wheelset was lost while its bus went on; now this is so, and nothing comes from either bus."""
    rule = InputLost(AlarmSettings().input_lost, 1)
    for time_s, speed_is, force_is, silent_s in (
        (10.0, LOST, GOOD, 0.0),
        (11.0, LOST, GOOD, 0.0),
        (20.0, speed, force, 5.0),
    ):
        inputs = (
            report(Quantity.AXLE_SPEED, 0, "WSP.n_A", speed_is, bus="front"),
            report(Quantity.PRESSING_FORCE, 0, "BCU.p_A", force_is, bus="rear"),
        )
        buses = (BusReport("front", silent_s, 0, False), BusReport("rear", silent_s, 0, False))
        _, verdict = rule.judge(observation(estimate(time_s=time_s), inputs, buses))
        assert time_s != 11.0 or isinstance(verdict, Finding)
    return verdict


def test_a_signal_that_comes_again_is_known_to_be_cured_though_another_one_is_lost_with_its_bus() -> None:
    assert verdict_beside_a_silent_bus(GOOD, LOST) is FINE
    assert verdict_beside_a_silent_bus(OUT_OF_RANGE, LOST) is FINE  # it comes
    assert verdict_beside_a_silent_bus(LOST, GOOD) is UNKNOWN
    assert verdict_beside_a_silent_bus(LOST, LOST) is UNKNOWN


def test_one_that_never_came_is_told_of_as_such() -> None:
    wagon = Wagon()
    (raised,) = wagon.told(GOOD, LOST, 5.0)
    assert raised.message == "Nothing has arrived yet of the latitude (GNSS.lat)."
    assert raised.severity is Severity.INFO


def test_that_a_signal_was_lost_earlier_does_not_blame_it_for_a_slow_bus_that_falls_silent() -> None:
    rule = InputLost(AlarmSettings().input_lost, 1)
    verdicts = []
    for time_s, condition, silent_s in ((10.0, LOST, 0.0), (20.0, GOOD, 0.0), (31.0, LOST, 1.1), (32.0, LOST, 2.1)):
        inputs = (report(Quantity.SPEED, 0, "GNSS.v", condition, bus=BUS.name),)
        buses = (BusReport(BUS.name, silent_s, 0, False, 3.0),)
        verdicts.append(rule.judge(observation(estimate(time_s=time_s), inputs, buses))[0])
    assert not any(isinstance(verdict, Finding) for verdict in verdicts[2:])


@pytest.mark.parametrize("latitude", [GOOD, LOST])
def test_a_signal_that_has_been_good_since_is_known_to_be_cured_though_it_is_lost_now(latitude: InputCondition) -> None:
    wagon = Wagon()
    (raised, *_) = wagon.told(OUT_OF_RANGE, latitude, 5.0)
    wagon.told(GOOD, latitude, 0.5)
    wagon.told(LOST, latitude, 20.0)
    assert raised.kind == "input_implausible"
    assert raised.id not in {alarm.id for alarm in wagon.monitor.open_alarms()}


def test_a_signal_that_never_came_does_not_keep_an_alarm_about_another_one_open() -> None:
    wagon = Wagon()
    wagon.told(AWAITED, AWAITED, 0.5)
    (raised,) = wagon.told(OUT_OF_RANGE, AWAITED, 2.0)
    wagon.told(GOOD, LOST, 20.0)
    assert raised.id not in {alarm.id for alarm in wagon.monitor.open_alarms()}


@pytest.mark.parametrize("signal", ["speed", "latitude"])
def test_a_signal_that_was_wrong_before_a_restart_and_has_not_come_since_is_not_known_to_be_cured(signal: str) -> None:
    before, wagon = Wagon(), Wagon()
    wrong = {"speed": (OUT_OF_RANGE, GOOD), "latitude": (GOOD, OUT_OF_RANGE)}[signal]
    (raised,) = before.told(*wrong, 5.0)
    wagon.monitor.resume([raised])
    wagon.told(AWAITED, AWAITED, 0.5)
    lost = {"speed": (LOST, GOOD), "latitude": (GOOD, LOST)}[signal]
    wagon.told(*lost, 60.0)
    assert raised.id in {alarm.id for alarm in wagon.monitor.open_alarms()}
    wagon.told(GOOD, GOOD, 0.5)
    wagon.told(*lost, 20.0)  # it has been good in between
    assert raised.id not in {alarm.id for alarm in wagon.monitor.open_alarms()}


@pytest.mark.parametrize("wrong", [LOST, OUT_OF_RANGE])
def test_a_signal_that_may_come_in_hours_does_not_keep_an_alarm_about_another_one_open(wrong: InputCondition) -> None:
    """One that is sent only when it changes has a time-out as long."""
    wagon = Wagon()
    wagon.told(GOOD, AWAITED, 0.5)
    (raised,) = wagon.told(wrong, AWAITED, 5.0)
    wagon.told(GOOD, AWAITED, 20.0)
    assert raised.id not in {alarm.id for alarm in wagon.monitor.open_alarms()}


def test_a_signal_that_was_lost_before_a_restart_is_not_found_again_before_it_comes() -> None:
    before, wagon = Wagon(), Wagon()
    (raised,) = before.told(GOOD, LOST, 5.0)
    wagon.monitor.resume([raised])
    wagon.told(GOOD, AWAITED, 20.0)
    assert raised.id in {alarm.id for alarm in wagon.monitor.open_alarms()}
    wagon.told(GOOD, GOOD, 20.0)
    assert raised.id not in {alarm.id for alarm in wagon.monitor.open_alarms()}
