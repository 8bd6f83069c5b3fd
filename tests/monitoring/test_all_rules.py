"""Each table of [alarms] has its rule, and the simulator knows when its alarm is due."""

from brake_monitor.monitoring.creep_meter import CreepMeter
from brake_monitor.monitoring.rules.all_rules import all_rules
from brake_monitor.settings.alarm_settings import AlarmSettings
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.due.alarm import DELAY_S


def test_each_kind_of_alarm_has_one_rule_with_the_settings_of_its_name() -> None:
    settings = example_settings("wagon")
    rules = all_rules(settings, CreepMeter(settings.estimator.contact_force_n))
    assert sorted((rule.kind, rule.settings) for rule in rules) == sorted(settings.alarms.rules())


def test_the_simulator_says_how_soon_each_kind_must_come_but_that_of_the_daemon_s_disk() -> None:
    assert {*DELAY_S, "memory_failing"} == set(AlarmSettings.__struct_fields__)
