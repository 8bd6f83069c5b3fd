"""The published contract: keys, fields, and JSON that every parser reads."""

import json
import math

import pytest
import zenoh
from hypothesis import given
from hypothesis import strategies as st

from brake_monitor.estimation.estimate import Status
from brake_monitor.monitoring.brake_units.brakes import Brakes, BrakeUnit
from brake_monitor.monitoring.brake_units.wear import PadUse
from brake_monitor.publishing.encoding import encode
from brake_monitor.publishing.payloads import (
    AdhesionMessage,
    AlarmMessage,
    AxleAdhesionMessage,
    FrictionMessage,
    WearMessage,
)
from brake_monitor.samples import Quantity
from brake_monitor.settings.key_space import KeySpace, fault_of
from brake_monitor.settings.wear_settings import WearSettings
from estimates import alarm, estimate, wheelset

NAN = math.nan


def refuse_constant(name: str) -> None:
    raise AssertionError(f"{name} is not JSON")


def decoded(message: AdhesionMessage | FrictionMessage | AxleAdhesionMessage | AlarmMessage) -> dict[str, object]:
    return json.loads(encode(message), parse_constant=refuse_constant)


def test_keys_are_those_of_the_contract() -> None:
    keys = KeySpace("brake/v1", "wagon-8127")
    assert keys.wagon == "brake/v1/wagon-8127"
    assert keys.adhesion == "brake/v1/wagon-8127/adhesion"
    assert keys.friction(1) == "brake/v1/wagon-8127/axle/1/friction"
    assert keys.alarm("low_adhesion", None) == "brake/v1/wagon-8127/alarm/low_adhesion"
    assert keys.alarm("locked_wheelset", 4) == "brake/v1/wagon-8127/alarm/locked_wheelset/4"


@pytest.mark.parametrize(
    "bad",
    [
        "", "a/b", "wagon*", "a$b", "a?b", "a#b", "a b", "a\tb", "@wagon", "w\x7f", "w\u202ey", "no\u00a0break",
        "Wa\u0308gen",  # a and two dots: looks like ä and does not match it
        "x" * 101,
    ],
)  # fmt: skip
def test_what_cannot_stand_in_a_key_is_told(bad: str) -> None:
    assert fault_of(bad)


@pytest.mark.parametrize("good", ["Wägen-7", "車両1", "80 80".replace(" ", "."), "a@b", "x" * 100, "-", "[1]"])
def test_other_names_stand_in_a_key_as_zenoh_takes_it(good: str) -> None:
    assert fault_of(good) is None
    assert str(zenoh.KeyExpr(KeySpace("depot/Süd/v1", good).adhesion)) == f"depot/Süd/v1/{good}/adhesion"


def test_adhesion_carries_the_contracts_fields() -> None:
    got = decoded(AdhesionMessage.of(estimate(), sequence=7, publish_time_s=1700000000.3))
    assert got["time_s"] == 1700000000.25
    assert (got["adhesion"], got["adhesion_std"], got["saturated"]) == (0.08, 0.003, True)
    assert (got["speed_mps"], got["status"], got["reasons"]) == (18.0, "valid", [])
    assert (got["deceleration_mps2"], got["sequence"], got["publish_time_s"]) == (0.01, 7, 1700000000.3)


def test_friction_belongs_to_the_wheelset_counted_from_one() -> None:
    first = decoded(FrictionMessage.of(estimate(), 1, sequence=7, publish_time_s=0.0))
    second = decoded(FrictionMessage.of(estimate(), 2, sequence=7, publish_time_s=0.0))
    assert (first["wheelset"], first["friction"], first["status"], first["wsp_active"]) == (1, 0.34, "valid", False)
    assert (second["wheelset"], second["friction"], second["status"], second["wsp_active"]) == (
        2,
        0.31,
        "held",
        True,
    )
    assert {"time_s", "friction_std", "slip", "omega_radps", "pressing_force_n"} <= first.keys()


def test_an_alarm_says_whether_it_is_open() -> None:
    raised = decoded(AlarmMessage.of(alarm(), sequence=1, publish_time_s=0.0))
    cleared = decoded(AlarmMessage.of(alarm(cleared_time_s=1700000009.0, updated_time_s=1700000009.0), 2, 0.0))
    assert (raised["state"], raised["severity"], raised["cleared_time_s"]) == ("open", "alarm", None)
    assert (cleared["state"], cleared["time_s"], cleared["cleared_time_s"]) == (
        "cleared",
        1700000009.0,
        1700000009.0,
    )
    assert raised["evidence"] == {"adhesion": 0.03, "place": "km 12", "temperature_c": None}


def test_what_is_not_a_number_becomes_null() -> None:
    broken = estimate(adhesion=NAN, speed_mps=math.inf, wheelsets=(wheelset(friction=-math.inf, slip=NAN),))
    wagon = decoded(AdhesionMessage.of(broken, 1, 0.0))
    axle = decoded(FrictionMessage.of(broken, 1, 1, 0.0))
    evidence = decoded(AlarmMessage.of(alarm(evidence={"adhesion": NAN}), 1, 0.0))["evidence"]
    assert (wagon["adhesion"], wagon["speed_mps"], wagon["adhesion_std"]) == (None, None, 0.003)
    assert (axle["friction"], axle["slip"], axle["omega_radps"]) == (None, None, 40.0)
    assert evidence == {"adhesion": None}


def test_what_was_never_told_is_null_and_not_0() -> None:
    unknown = {(Quantity.SPEED, 0), (Quantity.SANDING, 0)}
    unknown |= {(Quantity.AXLE_SPEED, 0), (Quantity.PRESSING_FORCE, 0), (Quantity.WSP_ACTIVE, 0)}
    started = estimate(speed_mps=0.0, unknown=frozenset(unknown))
    wagon = decoded(AdhesionMessage.of(started, 1, 0.0))
    assert (wagon["speed_mps"], wagon["sanding"]) == (None, None)
    for message in (FrictionMessage.of(started, 1, 1, 0.0), AxleAdhesionMessage.of(started, 1, 1, 0.0)):
        axle = decoded(message)
        told = {"slip", "omega_radps", "pressing_force_n", "wsp_active"} & axle.keys()
        assert {axle[name] for name in told} == {None}
        assert {"slip", "wsp_active"} <= told
    second = decoded(FrictionMessage.of(started, 2, 1, 0.0))
    assert (second["slip"], second["omega_radps"], second["pressing_force_n"]) == (None, 40.0, 41000.0)
    assert second["wsp_active"] is True


def test_wear_is_of_its_wheelset_and_valid_once_its_pads_were_measured() -> None:
    settings = WearSettings()
    new = Brakes.new(2, settings)
    installed = WearMessage.of(new, 2, settings, 7, 900.0)
    assert (installed.status, installed.quality) == (Status.CONVERGING, "uncertain")
    assert (installed.time_s, installed.publish_time_s, installed.sequence) == (900.0, 900.0, 7)  # nothing was observed
    first, second = new.units
    pads = second.pads.used(PadUse(2e6, 6e6, 3.0, 40.0, 5e3)).gauged(settings, 500.0, 20.0)
    measured = WearMessage.of(Brakes(800.0, (first, BrakeUnit(pads, 90.0)), ()), 2, settings, 8, 900.0)
    assert (measured.status, measured.quality) == (Status.VALID, "good")
    assert (measured.time_s, measured.gauged_time_s, measured.wheelset) == (800.0, 500.0, 2)
    assert (measured.thickness_mm, measured.archard_thickness_mm, measured.remaining_mm) == (20.0, 20.0, 15.0)
    assert (measured.pad_energy_j, measured.stops, measured.sliding_distance_m) == (2e6, 3.0, 40.0)
    assert (measured.distance_m, measured.disc_temperature_c) == (5e3, 90.0)


@given(value=st.floats(), text=st.text())
def test_any_value_and_any_text_make_valid_json_that_keeps_its_value(value: float, text: str) -> None:
    got = decoded(AdhesionMessage.of(estimate(adhesion=value, reasons=(text,)), 1, 0.0))
    assert got["adhesion"] == (value if math.isfinite(value) else None)
    assert got["reasons"] == [text]
