"""Which frames are taken for a message when the configuration says nothing of it: what the DBC says."""

from pathlib import Path

import pytest
from msgspec.structs import replace

from brake_monitor.decoding.dbc import load_bus
from brake_monitor.decoding.matching import Matching, matching_of
from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.errors import InputError
from brake_monitor.settings.config_file import load_settings

VEHICLES = Path(__file__).parents[2] / "dbc"
DATA = Path(__file__).parents[1] / "data"

FORMATS = (
    'BA_DEF_ BO_ "VFrameFormat" ENUM "StandardCAN","ExtendedCAN","StandardCAN_FD","ExtendedCAN_FD","J1939PG";\n'
    'BA_DEF_DEF_ "VFrameFormat" "StandardCAN";\n'
)
J1939_NETWORK = 'BA_DEF_ "ProtocolType" STRING;\nBA_DEF_DEF_ "ProtocolType" "";\nBA_ "ProtocolType" "J1939";\n'
SPN = 'BA_DEF_ SG_ "SPN" INT 0 524287;\nBA_DEF_DEF_ "SPN" 0;\n'
STANDARD, SPEED, WHEELS = 0x2A0, 0x98FE6C0B, 0x98FEBF0B  # as a DBC writes them: the top bit marks 29 bits


def matching(tmp_path: Path, can_id: int, attributes: str = "", others: tuple[int, ...] = (WHEELS,)) -> Matching:
    path = tmp_path / "x.dbc"
    messages = "\n".join(
        f'BO_ {number} M{place}: 8 A\n SG_ v : 0|16@1+ (1,0) [0|0] "" A\n'
        for place, number in enumerate((can_id, *others))
    )
    path.write_text(f'VERSION ""\n\nNS_ :\n\nBS_:\n\nBU_: A\n\n{messages}\n{attributes}')
    database = load_bus("can0", [path])
    return matching_of(database, database.message("M0"), None)


@pytest.mark.parametrize(
    ("attributes", "because"),
    [
        (FORMATS + f'BA_ "VFrameFormat" BO_ {SPEED} 4;\n', 'its VFrameFormat is "J1939PG"'),
        (FORMATS.replace('"StandardCAN";', '"J1939PG";'), 'its VFrameFormat is "J1939PG"'),
        (J1939_NETWORK, 'the ProtocolType of x.dbc is "J1939"'),
        (SPN + f'BA_ "SPN" SG_ {SPEED} v 1624;\n', "its signals have SPNs"),
    ],
)
def test_a_message_that_its_dbc_calls_j1939_is_matched_by_pgn(tmp_path: Path, attributes: str, because: str) -> None:
    found = matching(tmp_path, SPEED, attributes)
    assert (found.by, found.is_j1939, str(found)) == ("pgn", True, f"PGN 0xFE6C, J1939: {because}")


def test_a_file_of_null_addresses_is_j1939(tmp_path: Path) -> None:
    found = matching(tmp_path, 0x98FE6CFE, others=(0x98FEBFFE, STANDARD))
    assert str(found) == "PGN 0xFE6C, J1939: all extended ids of x.dbc end in the null address 0xFE"
    assert matching(tmp_path, 0x98FE6CFE, others=(0x98FEBFFE, WHEELS)).by == "id"


@pytest.mark.parametrize(
    ("can_id", "attributes", "text"),
    [
        (SPEED, "", "id 0x18FE6C0B"),
        (SPEED, FORMATS, "id 0x18FE6C0B"),
        (SPEED, J1939_NETWORK + FORMATS + f'BA_ "VFrameFormat" BO_ {SPEED} 1;\n', "id 0x18FE6C0B"),
        (SPEED, SPN, "id 0x18FE6C0B"),
        (STANDARD, "", "id 0x2A0"),
        (STANDARD, J1939_NETWORK, "id 0x2A0"),
        (STANDARD, FORMATS + f'BA_ "VFrameFormat" BO_ {STANDARD} 4;\n', "id 0x2A0"),
    ],
)
def test_every_other_message_is_matched_by_its_whole_id(
    tmp_path: Path, can_id: int, attributes: str, text: str
) -> None:
    found = matching(tmp_path, can_id, attributes)
    assert (found.by, found.is_j1939, str(found)) == ("id", False, text)


def test_senders_that_the_dbc_tells_apart_are_told_apart(tmp_path: Path) -> None:
    """Two messages of one PGN: by PGN each would be taken for the other."""
    found = matching(tmp_path, SPEED, J1939_NETWORK, others=(0x98FE6C21,))
    assert (found.by, found.is_j1939) == ("id", True)
    assert str(found) == "id 0x18FE6C0B, J1939, but M1 has the same PGN"


def test_no_message_of_11_bits_has_the_pgn_0(tmp_path: Path) -> None:
    """As TSC1 has, torque and speed control."""
    found = matching(tmp_path, 0x8C000003, J1939_NETWORK, others=(STANDARD,))
    assert (found.by, found.reason) == ("pgn", 'J1939: the ProtocolType of x.dbc is "J1939"')


@pytest.mark.parametrize("wanted", ["id", "pgn"])
def test_the_configuration_has_the_last_word(wanted: str) -> None:
    for folder, name, message in [(DATA, "mini_j1939", "VehicleSpeed"), (VEHICLES, "wagon", "Sander")]:
        database = load_bus("can0", [folder / f"{name}.dbc"])
        found = matching_of(database, database.message(message), wanted)  # type: ignore[arg-type]
        assert found.by == wanted
        assert found.is_j1939 == (name == "mini_j1939" or wanted == "pgn")
        assert str(found).endswith("as configured")


@pytest.mark.parametrize(("key", "first", "second"), [("counter", "WSP_counter", "valve_A"), ("match", "id", "pgn")])
def test_entries_that_say_different_things_of_one_message_are_refused(key: str, first: str, second: str) -> None:
    settings = load_settings(VEHICLES / "wagon.toml")

    def decoder(*told: str) -> SignalDecoder:
        wheels = tuple(
            replace(own, **{"counter": "", key: value})
            for own, value in zip(settings.signals.axle_speed, told, strict=True)
        )
        return SignalDecoder.from_settings(
            replace(settings, signals=replace(settings.signals, axle_speed=wheels, wsp_active=()))
        )

    assert decoder(first, "" if key == "counter" else first)  # one that says nothing agrees with all
    refused = rf'axle_speed\[2\]\.{key}: "{second}", but signals\.axle_speed\[1\] says "{first}" of the same message'
    with pytest.raises(InputError, match=refused):
        decoder(first, second)


def test_what_has_no_pgn_is_refused() -> None:
    database = load_bus("can0", [VEHICLES / "wagon.dbc"])
    with pytest.raises(InputError, match='"WSP" has an 11-bit id, which has no PGN'):
        matching_of(database, database.message("WSP"), "pgn")
