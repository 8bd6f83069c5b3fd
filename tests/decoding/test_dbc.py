import os
import re
import struct
from importlib.metadata import version
from pathlib import Path
from sys import float_info

import pytest
from cantools.database import DecodeError
from cantools.database.can import Message, Signal
from cantools.database.conversion import BaseConversion
from hypothesis import given
from hypothesis import strategies as st

from brake_monitor.decoding.dbc import load_bus
from brake_monitor.decoding.signal_field import Presence, cycle_time_s, signal_field
from brake_monitor.errors import InputError, brief

VEHICLES = Path(__file__).parents[2] / "dbc"


def dbc_start(byte_order: str, first: int) -> int:
    """The start bit as a DBC writes it, of a signal whose first bit is `first` along the bytes."""
    return first if byte_order == "little_endian" else 8 * (first // 8) + 7 - first % 8


@st.composite
def signals(draw: st.DrawFn, size: int) -> Signal:
    is_float = draw(st.booleans())
    length = draw(st.sampled_from([16, 32, 64]) if is_float else st.integers(1, 64))
    length = min(length, 8 * size) if not is_float else length
    byte_order = draw(st.sampled_from(["little_endian", "big_endian"]))
    first = draw(st.integers(0, max(0, 8 * size - length)))
    scale = draw(st.sampled_from([1, 0.01, -0.5, 1e-7, 2]))
    offset = draw(st.sampled_from([0, -40, 0.25]))
    return Signal(
        "s",
        dbc_start(byte_order, first),
        length,
        byte_order,
        is_signed=draw(st.booleans()),
        conversion=BaseConversion.factory(scale, offset, is_float=is_float),
    )


def message_of(signal_list: list[Signal], size: int) -> Message:
    return Message(0x123, "M", size, signal_list, strict=False)


@given(st.data(), st.sampled_from([8, 12, 64]))
def test_extraction_equals_cantools(data: st.DataObject, size: int) -> None:
    message = message_of([data.draw(signals(size))], size)
    payload = data.draw(st.binary(min_size=size, max_size=size))
    field = signal_field(message, "s")
    raw = field.raw_of(payload)
    assert raw is not None
    assert repr(raw) == repr(message.decode(payload, decode_choices=False, scaling=False)["s"])  # repr: NaN equals NaN
    expected = float(message.decode(payload, decode_choices=False)["s"])
    # Integers of more than 53 bits may be rounded twice.
    assert raw * field.scale + field.offset == pytest.approx(expected, rel=float_info.epsilon, abs=0.0, nan_ok=True)


@given(st.data())
def test_a_longer_frame_gives_the_same_and_a_cut_one_what_it_holds(data: st.DataObject) -> None:
    message = message_of([data.draw(signals(8))], 8)
    payload = data.draw(st.binary(min_size=8, max_size=8))
    field = signal_field(message, "s")
    whole = field.raw_of(payload)
    assert repr(field.raw_of(payload + data.draw(st.binary(max_size=56)))) == repr(whole)
    cut = payload[: data.draw(st.integers(0, 7))]
    got = field.raw_of(cut)
    expected = message.decode(cut, decode_choices=False, scaling=False, allow_truncated=True).get("s")
    assert repr(got) == repr(expected)


def test_every_signal_of_the_example_vehicles_equals_cantools() -> None:
    payloads = [bytes((37 * i + 11 * j) % 256 for j in range(8)) for i in range(64)]
    for name in ("rig", "wagon", "bogie"):
        database = load_bus("can0", [VEHICLES / f"{name}.dbc"])
        assert database.remarks == ()  # they load strictly
        for message in database.files[0][1].messages:
            assert message.comment
            assert cycle_time_s(message, signal_field(message, message.signals[0].name))
            for payload in (p[: message.length] for p in payloads):
                _compare_message(message, payload)


def _compare_message(message: Message, payload: bytes) -> None:
    fields = [signal_field(message, signal.name) for signal in message.signals]
    try:
        expected = message.decode(payload, decode_choices=False)
    except DecodeError:  # cantools loses the whole frame; we know which signals are meant
        assert any(field.presence(payload) is Presence.UNKNOWN_PAGE for field in fields)
        return
    got = {}
    for field in fields:
        if field.presence(payload) is Presence.THERE:
            raw = field.raw_of(payload)
            assert raw is not None
            got[field.name] = repr(float(raw * field.scale + field.offset))  # repr: NaN equals NaN
    assert got == {name: repr(float(value)) for name, value in expected.items()}


def write(tmp_path: Path, body: str) -> Path:
    path = tmp_path / "x.dbc"
    path.write_text(f'VERSION ""\n\nNS_ :\n\nBS_:\n\nBU_: A\n\n{body}\n')
    return path


EXTENDED_MULTIPLEXING = """\
BO_ 1 M: 8 A
 SG_ outer M : 0|4@1+ (1,0) [0|0] "" A
 SG_ inner m1M : 4|4@1+ (1,0) [0|0] "" A
 SG_ deep m2 : 8|8@1+ (1,0) [0|0] "" A
 SG_ other m3 : 8|8@1+ (1,0) [0|0] "" A

SG_MUL_VAL_ 1 inner outer 1-1;
SG_MUL_VAL_ 1 deep inner 2-2, 5-6;
SG_MUL_VAL_ 1 other outer 3-3;
"""


@pytest.mark.parametrize(
    ("first_byte", "presence"),
    [
        (0x21, Presence.THERE),  # outer 1, inner 2
        (0x61, Presence.THERE),
        (0x23, Presence.ON_OTHER_PAGE),
        (0x93, Presence.ON_OTHER_PAGE),  # outer 3: what would be the inner one is something else
        (0x31, Presence.UNKNOWN_PAGE),
        (0x29, Presence.UNKNOWN_PAGE),
    ],
)
def test_extended_multiplexing(tmp_path: Path, first_byte: int, presence: Presence) -> None:
    message = load_bus("b", [write(tmp_path, EXTENDED_MULTIPLEXING)]).message("M")
    payload = bytes([first_byte, 7, 0, 0, 0, 0, 0, 0])
    assert signal_field(message, "deep").presence(payload) is presence
    assert signal_field(message, "deep").presence(b"") is Presence.CUT_OFF


def test_a_lower_multiplexer_that_a_short_frame_does_not_reach_is_not_missed_on_another_page(tmp_path: Path) -> None:
    body = EXTENDED_MULTIPLEXING.replace("inner m1M : 4|4", "inner m1M : 32|4")
    deep = signal_field(load_bus("b", [write(tmp_path, body)]).message("M"), "deep")
    assert deep.presence(bytes([3, 7])) is Presence.ON_OTHER_PAGE
    assert deep.presence(bytes([1, 7])) is Presence.CUT_OFF


@pytest.mark.parametrize(
    ("label", "is_meant"),
    [
        ("not available", True),
        ("Signal_Not_Available", True),
        ("NotAvailable", True),
        ("SNA", True),
        ("Speed_SNA", True),
        ("N/A", True),
        ("sensor error", True),
        ("INVALID", True),
        ("no error", False),
        ("No_Error", False),
        ("errorfree", False),
        ("applied", False),
        ("snap", False),
        ("nicht verfügbar", True),
        ("Nicht_verfuegbar", True),
        ("Wert ungültig", True),
        ("Sensorfehler", True),
        ("Notbremsfehler", True),
        ("Not_Valid", True),
        ("Speed_Unavail", True),
        ("nicht gültig", True),
        ("kein Fehler", False),
        ("kein_Sammelfehler", False),
        ("kein_KD_Fehler", False),
        ("codiert_kein_Fehler", False),
        ("no CAN error detected", False),
        ("Brake_NoError", False),
        ("signal is not an error", False),
        ("fehlerfrei", False),
        ("gültig", False),
        ("non disponible", True),
        ("indisponible", True),
        ("mesure invalide", True),
        ("non valide", True),
        ("Erreur capteur", True),
        ("pas d'erreur", False),
        ("sans erreur", False),
        ("disponible", False),
    ],
)
def test_labels_that_say_not_available(tmp_path: Path, label: str, is_meant: bool) -> None:
    body = f'BO_ 1 M: 8 A\n SG_ s : 0|8@1+ (1,0) [0|0] "" A\n\nVAL_ 1 s 7 "{label}" ;'
    field = signal_field(load_bus("b", [write(tmp_path, body)]).message("M"), "s")
    assert field.not_available == (frozenset({7}) if is_meant else frozenset())


def test_range_allows_for_rounding_but_not_for_the_next_step(tmp_path: Path) -> None:
    body = 'BO_ 1 M: 8 A\n SG_ s : 0|8@1+ (0.1,0) [0.3|0.6] "" A\n SG_ free : 8|8@1+ (1,0) [0|0] "" A'
    message = load_bus("b", [write(tmp_path, body)]).message("M")
    field = signal_field(message, "s")
    assert [raw for raw in range(10) if field.minimum <= raw * field.scale <= field.maximum] == [3, 4, 5, 6]
    free = signal_field(message, "free")
    assert free.minimum == float("-inf")
    assert free.maximum == float("inf")


@pytest.mark.parametrize(("length", "number"), [(16, "e"), (32, "f"), (64, "d")])
@pytest.mark.parametrize("layout", ["(1,0) [-10.3|0.1]", "(0.1,3) [-10.3|0.1]", "(-0.7,-0.3) [0.1|10.3]"])
def test_a_range_includes_the_float_that_is_nearest_to_its_end(
    tmp_path: Path, length: int, number: str, layout: str
) -> None:
    kind = 1 if length == 32 else 2
    body = f'BO_ 1 M: 8 A\n SG_ s : 0|{length}@1- {layout} "" A\n\nSIG_VALTYPE_ 1 s : {kind};'
    message = load_bus("b", [write(tmp_path, body)]).message("M")
    field = signal_field(message, "s")
    assert field.is_float
    least, greatest = map(float, re.findall(r"[-.\d]+", layout)[2:])
    for end in (least, greatest):
        raw = field.raw_of(struct.pack(f"<{number}", (end - field.offset) / field.scale).ljust(8, b"\0"))
        assert raw is not None
        assert field.minimum <= raw * field.scale + field.offset <= field.maximum
    assert field.minimum > least - 0.01 * (greatest - least)
    assert field.maximum < greatest + 0.01 * (greatest - least)


def test_bad_files_are_refused_by_name(tmp_path: Path) -> None:
    garbage = tmp_path / "garbage.dbc"
    garbage.write_bytes(bytes(range(256)) * 10)
    empty = write(tmp_path, "")
    for path, part in [
        (tmp_path / "none.dbc", "No such file"),
        (tmp_path / f"{'x' * 300}.dbc", "cannot be read: File name too long"),
        (tmp_path, "Is a directory"),
        (garbage, "not a DBC file"),
        (empty, "describes no message"),
    ]:
        with pytest.raises(InputError, match=part) as caught:
            load_bus("can0", [path])
        assert str(caught.value).startswith(brief(f"{path}:"))
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize("kind", ["recording", "device without an end"])
def test_what_is_far_too_large_for_a_dbc_is_not_read(tmp_path: Path, kind: str) -> None:
    path = Path("/dev/zero")
    if kind == "recording":
        path = tmp_path / "trip.blf"
        with path.open("wb") as file:
            file.truncate(10**8)  # a hole: nothing on the disk
    with pytest.raises(InputError, match=f"{path}: expected a DBC file, this has more than 50 MB"):
        load_bus("can0", [path])


def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    path = tmp_path / "pipe.dbc"
    os.mkfifo(path)
    with pytest.raises(InputError, match=f"{path}: expected a DBC file, this is a pipe"):
        load_bus("can0", [path])


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "cp1252", "utf-16", "utf-16-le", "utf-16-be"])
def test_what_editors_save_text_as_is_read(tmp_path: Path, encoding: str) -> None:
    path = tmp_path / "unit.dbc"
    text = (VEHICLES / "wagon.dbc").read_text(encoding="utf-8").replace('"bar"', '"‰"', 1)
    mark = "\ufeff" if encoding in ("utf-16-le", "utf-16-be") else ""
    path.write_bytes((mark + text).encode(encoding))
    database = load_bus("can0", [path])
    assert not database.remarks
    assert "‰" in [signal.unit for message in database.files[0][1].messages for signal in message.signals]


def test_of_an_endless_line_that_cannot_be_read_the_place_is_told(tmp_path: Path) -> None:
    path = tmp_path / "x.dbc"
    path.write_text('VERSION "" ' + "{1, 2} " * 5000 + "\n")
    with pytest.raises(InputError) as refusal:
        load_bus("b", [path])
    assert str(refusal.value).startswith(
        f'{path}: not a DBC file that can be read: Invalid syntax at line 1, column 12: "'
    )
    assert "{1, 2} {1, 2}" in str(refusal.value)
    assert len(str(refusal.value)) < len(str(path)) + 300


@pytest.mark.parametrize(
    ("entry", "told"),
    [
        ('BA_ "GenMsgCycleTime" BO_ 672 "x";', "an attribute that it defines as a number (INT, HEX or FLOAT) is given"),
        (
            'BA_DEF_ BO_ "VFrameFormat" ENUM "a","b"; BA_ "VFrameFormat" BO_ 672 99;',
            "a number points beyond a list, as that of an attribute (ENUM) with fewer choices",
        ),
        ('VAL_ 672 v_ground 1.5 "x" ;', "expected a whole number, got '1.5'"),
    ],
)
def test_what_the_parser_tells_of_itself_is_told_of_the_file(entry: str, told: str, tmp_path: Path) -> None:
    path = tmp_path / "x.dbc"
    path.write_text(f"{(VEHICLES / 'wagon.dbc').read_text()}\n{entry}\n")
    with pytest.raises(InputError, match=re.escape(f"{path}: not a DBC file that can be read: {told}")):
        load_bus("b", [path])


def test_an_empty_file_is_told_as_empty(tmp_path: Path) -> None:
    path = tmp_path / "x.dbc"
    path.write_text("\n")
    with pytest.raises(InputError, match="expected a DBC file, this is empty"):
        load_bus("b", [path])


def test_a_file_that_was_cut_off_is_remarked(tmp_path: Path) -> None:
    path = tmp_path / "cut.dbc"
    path.write_text((VEHICLES / "wagon.dbc").read_text().partition("|2@1+")[0])
    database = load_bus("can0", [path])
    assert database.remarks == (f"{path}: 1 of 9 signals could not be read; is the file cut off?",)
    with pytest.raises(InputError, match='has no signal "wsp_A"'):
        signal_field(database.message("WSP"), "wsp_A")


def test_signals_that_belong_to_no_message_are_not_missed(tmp_path: Path) -> None:
    path = tmp_path / "edited.dbc"  # editors keep signals that no message has any more in one of this name
    homeless = """
BO_ 3221225472 VECTOR__INDEPENDENT_SIG_MSG: 0 Vector__XXX
 SG_ once : 0|8@1+ (1,0) [0|0] "" Vector__XXX
 SG_ used : 0|8@1+ (1,0) [0|0] "" Vector__XXX
"""
    path.write_text((VEHICLES / "wagon.dbc").read_text() + homeless)
    assert load_bus("can0", [path]).remarks == ()


@pytest.mark.parametrize(
    "about", ['VAL_ 3221225472 once 1 "on; or \\"so\\"" 0 "off" ;', "SIG_VALTYPE_ 3221225472 once : 1;"]
)
def test_nor_is_what_is_said_of_them_a_fault(tmp_path: Path, about: str) -> None:
    path = tmp_path / "edited.dbc"
    homeless = 'BO_ 3221225472 VECTOR__INDEPENDENT_SIG_MSG: 0 A\n SG_ once : 0|32@1- (1,0) [0|0] "" A'
    path.write_text(f'{(VEHICLES / "wagon.dbc").read_text()}\n{homeless}\n\n{about}\nVAL_ 416 a_A -120 "none" ;\n')
    database = load_bus("can0", [path])
    assert database.remarks == ()
    assert database.message("WSP").get_signal_by_name("a_A").choices == {-120: "none"}


@pytest.mark.skipif(version("cantools").split(".") < ["45", "1"], reason="cantools before 45.1 leaves it out by itself")
def test_what_is_said_of_a_signal_that_its_message_does_not_have_is_left_out(tmp_path: Path) -> None:
    path = tmp_path / "renamed.dbc"
    more = 'VAL_ 672 v_grund 65535 "not available" ;\nSIG_VALTYPE_ 673 lat : 1;\nVAL_ 416 a_A -120 "none" ;\n'
    path.write_text((VEHICLES / "wagon.dbc").read_text() + more)
    database = load_bus("can0", [path])
    assert database.remarks == (
        f"{path}: VAL_ 672 v_grund is left out: no message has such a signal",
        f"{path}: SIG_VALTYPE_ 673 lat is left out: no message has such a signal",
    )
    assert database.message("WSP").get_signal_by_name("a_A").choices == {-120: "none"}


@pytest.mark.parametrize(
    ("multiplexers", "more", "is_told"),
    [
        ((), "", True),
        (("x", "y"), "", True),  # which of them?
        (("x",), "", False),
        (("x", "y"), "\nSG_MUL_VAL_ 1 b y 1-1;\nSG_MUL_VAL_ 1 c x 2-2;", False),
    ],
)
def test_a_signal_on_a_page_of_no_multiplexer_is_remarked(
    tmp_path: Path, multiplexers: tuple[str, ...], more: str, is_told: bool
) -> None:
    lines = [f' SG_ {name} M : {8 * k}|8@1+ (1,0) [0|0] "" A' for k, name in enumerate(multiplexers)]
    lines += [
        f' SG_ {name} {page} : {8 * k}|8@1+ (1,0) [0|0] "" A' for k, name, page in ((4, "b", "m1"), (5, "c", "m2"))
    ]
    path = write(tmp_path, "\n".join(["BO_ 1 M: 8 A", *lines]) + f"\n{more}")
    told = f'{path}: message "M" has no multiplexer, or several, for the page of "b" and "c": taken from every frame'
    assert load_bus("b", [path]).remarks == ((told,) if is_told else ())


def test_what_stands_in_a_comment_is_no_signal(tmp_path: Path) -> None:
    path = tmp_path / "commented.dbc"
    path.write_text((VEHICLES / "wagon.dbc").read_text() + '\nCM_ "Earlier, with a \\"unit\\":\n SG_ gone : 0|8@1+";\n')
    assert load_bus("can0", [path]).remarks == ()


def test_a_file_with_faults_elsewhere_serves_what_is_sound_in_it(tmp_path: Path) -> None:
    body = 'BO_ 1 M: 2 A\n SG_ good : 0|8@1+ (1,0) [0|0] "" A\n SG_ wide : 8|16@1+ (1,0) [0|0] "" A'
    database = load_bus("b", [write(tmp_path, body)])
    assert len(database.remarks) == 1
    assert "wide" in database.remarks[0]
    assert signal_field(database.message("M"), "good").raw_of(b"\x05\x00") == 5
    with pytest.raises(InputError, match='"wide" of message "M" does not fit'):
        signal_field(database.message("M"), "wide")


@pytest.mark.parametrize("first", ["a", "below"])
@pytest.mark.parametrize("selections", [("a",), ("b", "a"), ("b", "c", "a")])
def test_multiplexers_that_select_each_other_are_refused(
    tmp_path: Path, first: str, selections: tuple[str, ...]
) -> None:
    names = "abc"[: len(selections)]
    signals = ' SG_ other M : 56|8@1+ (1,0) [0|0] "" A\n'
    signals += "".join(f' SG_ {name} m0M : {8 * k}|8@1+ (1,0) [0|0] "" A\n' for k, name in enumerate(names))
    values = "".join(f"SG_MUL_VAL_ 1 {name} {by} 0-0;\n" for name, by in zip(names, selections, strict=True))
    body = f'BO_ 1 M: 8 A\n{signals} SG_ below m0 : 48|8@1+ (1,0) [0|0] "" A\n\n{values}SG_MUL_VAL_ 1 below a 0-0;'
    message = load_bus("b", [write(tmp_path, body)]).message("M")
    with pytest.raises(InputError, match='signal "a" of message "M" is a multiplexer that selects itself'):
        signal_field(message, first)


def test_what_hangs_on_a_multiplexer_that_does_not_fit_is_refused(tmp_path: Path) -> None:
    body = 'BO_ 1 M: 8 A\n SG_ page M : 60|8@1+ (1,0) [0|0] "" A\n SG_ s m0 : 0|8@1+ (1,0) [0|0] "" A'
    message = load_bus("b", [write(tmp_path, body)]).message("M")
    with pytest.raises(InputError, match='"page" of message "M" does not fit: it ends at bit 68'):
        signal_field(message, "s")


@pytest.mark.parametrize(
    ("numbers", "what"),
    [
        ("({},0) [0|0]", "scale"),
        ("(1,{}) [0|0]", "offset"),
        ("(1,0) [0|{}]", "maximum"),
        ("(1,0) [-{}|0]", "minimum"),
    ],
)
def test_a_number_beyond_all_that_can_be_calculated_with_is_refused(tmp_path: Path, numbers: str, what: str) -> None:
    body = f'BO_ 1 M: 8 A\n SG_ s : 0|8@1+ {numbers.format("9" * 400)} "" A'
    message = load_bus("b", [write(tmp_path, body)]).message("M")
    with pytest.raises(InputError, match=f'signal "s" of message "M" has a {what} of 400 digits, expected 308'):
        signal_field(message, "s")


@pytest.mark.parametrize(
    ("body", "what"),
    [
        ("BO_ 1 M: 65535 A", 'message "M" is written to have 65535 bytes, expected 4095 at the most'),
        ("BO_ 1 M: 8 A\n SG_ s : 0|400000000@1+ {}", 'signal "s" is written to be at bits 0|400000000, expected 32760'),
        ("BO_ 1 M: 8 A\n SG_ s m0 : 400000000|8@0+ {}", 'signal "s" is written to be at bits 400000000|8'),
        (f"BO_ 1 M: 8 A\n SG_ s : {'9' * 5000}|8@1+ {{}}", f'signal "s" is written to be at bits {"9" * 20}|8'),
        (
            "BO_ 1 M: 8 A\n SG_ p M : 0|8@1+ {}\n SG_ s m0 : 8|8@1+ {}\n\nSG_MUL_VAL_ 1 s p 0-7, 8-3000000000;",
            'signal "s" is written to be on more than 65536 pages',
        ),
        (
            "BO_ 1 M: 8 A\n SG_ p M : 0|8@1+ {}\n SG_ s m0 : 8|8@1+ {}\n\nSG_MUL_VAL_ 1 s p 99999999-0, 8-90000000;",
            'signal "s" is written to be on more than 65536 pages',
        ),
    ],
    ids=["message", "length", "place", "digits", "pages", "pages from last to first"],
)
def test_sizes_that_no_message_has_are_refused_at_once(tmp_path: Path, body: str, what: str) -> None:
    """cantools takes half a minute of time, or gigabytes of memory, for these."""
    with pytest.raises(InputError, match=re.escape(what)):
        load_bus("b", [write(tmp_path, body.replace("{}", '(1,0) [0|0] "" A'))])


def test_messages_of_transport_protocols_are_longer_than_frames(tmp_path: Path) -> None:
    body = 'BO_ 1 M: 1785 A\n SG_ s : 14272|8@1+ (1,0) [0|0] "" A'
    assert signal_field(load_bus("b", [write(tmp_path, body)]).message("M"), "s").end == 14280


@pytest.mark.parametrize(
    ("sign", "codes"),
    [("+", {7, 255}), ("-", {7, -128})],
)
def test_a_code_that_the_signal_cannot_have_is_none(tmp_path: Path, sign: str, codes: set[int]) -> None:
    values = " ".join(f'{code} "not available"' for code in (7, 255, 256, -128, int("9" * 400)))
    body = f'BO_ 1 M: 8 A\n SG_ s : 0|8@1{sign} (1,0) [0|0] "" A\n\nVAL_ 1 s {values} ;'
    field = signal_field(load_bus("b", [write(tmp_path, body)]).message("M"), "s")
    assert field.not_available == codes


def test_a_code_that_no_float_can_have_is_none(tmp_path: Path) -> None:
    values = " ".join(f'{code} "not available"' for code in (-1, int("9" * 400)))
    body = f'BO_ 1 M: 8 A\n SG_ s : 0|32@1- (1,0) [0|0] "" A\n\nVAL_ 1 s {values} ;\nSIG_VALTYPE_ 1 s : 1;'
    field = signal_field(load_bus("b", [write(tmp_path, body)]).message("M"), "s")
    assert (field.is_float, field.not_available) == (True, {-1})


@pytest.mark.parametrize(
    ("layout", "numbers"),
    [
        ("8@1+ (1,0) [0|0]", (0, 255)),
        ("8@1- (1,0) [0|0]", (-128, 127)),
        ("8@1+ (1,0) [14|0]", (0, 255)),
        ("8@1+ (1,0) [0|14]", (0, 14)),
        ("4@1+ (1,1) [1|15]", (0, 14)),
        ("8@1- (0.5,10) [0|50]", (-20, 80)),
        ("8@1- (-1,0) [-200|3]", (-3, 127)),
        ("8@1+ (0.5,0) [300|400]", (255, 255)),
    ],
)
def test_raw_numbers_are_those_of_the_range_that_fit(tmp_path: Path, layout: str, numbers: tuple[int, int]) -> None:
    message = load_bus("b", [write(tmp_path, f'BO_ 1 M: 8 A\n SG_ s : 0|{layout} "" A')]).message("M")
    assert signal_field(message, "s").raw_range() == numbers


def test_names_that_are_not_there_or_not_unique(tmp_path: Path) -> None:
    path = write(tmp_path, 'BO_ 1 Speed: 8 A\n SG_ v : 0|8@1+ (1,0) [0|0] "" A')
    database = load_bus("b", [path])
    with pytest.raises(InputError, match='no message is named "Sped", did you mean "Speed"'):
        database.message("Sped")
    with pytest.raises(InputError, match='has no signal "w", there is "v"'):
        signal_field(database.message("Speed"), "w")
    with pytest.raises(InputError, match="is ambiguous on bus"):
        load_bus("b", [path, path]).message("Speed")


def test_names_and_ids_that_several_messages_have_are_remarked(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = write(tmp_path, "\n".join(f"BO_ {head}: 8 A\n" for head in ("1 M", "2 M", "1 N", "2147483649 Extended")))
    assert load_bus("b", [path]).remarks == (
        f'{path}: 2 messages are named "M": 0x1 and 0x2',
        f'{path}: 2 messages have the id 0x1: "M" and "N"',
    )
    assert caplog.messages == []  # nor does cantools say so


@pytest.mark.parametrize(("kind", "cycle"), [("STRING", '"soon"'), ("FLOAT 0 0", "1E-9"), ("INT 0 0", "9" * 400)])
def test_a_cycle_time_that_is_no_number_or_that_of_no_bus_is_none(tmp_path: Path, kind: str, cycle: str) -> None:
    path = tmp_path / "odd.dbc"
    path.write_text(
        'VERSION ""\nBU_: A\nBO_ 256 M: 8 A\n SG_ s : 0|8@1+ (1,0) [0|255] "" A\n'
        f'BA_DEF_ BO_ "GenMsgCycleTime" {kind} ;\n'
        f'BA_ "GenMsgCycleTime" BO_ 256 {cycle};\n'
    )
    message = load_bus("a", (path,)).message("M")
    assert cycle_time_s(message, signal_field(message, "s")) is None


def test_only_what_is_on_a_page_comes_as_seldom_as_its_page(tmp_path: Path) -> None:
    path = tmp_path / "paged.dbc"
    pages = "".join(f' SG_ diagnosis{k} m{k} : 8|8@1+ (1,0) [0|255] "" A\n' for k in range(12))
    path.write_text(
        f'VERSION ""\nBU_: A\nBO_ 256 M: 8 A\n SG_ page M : 0|8@1+ (1,0) [0|255] "" A\n{pages}'
        ' SG_ speed : 16|16@1+ (1,0) [0|255] "" A\n'
        'BA_DEF_ BO_ "GenMsgCycleTime" INT 0 10000;\nBA_DEF_DEF_ "GenMsgCycleTime" 0;\n'
        'BA_ "GenMsgCycleTime" BO_ 256 20;\n'
    )
    message = load_bus("a", (path,)).message("M")
    assert cycle_time_s(message, signal_field(message, "speed")) == 0.02
    assert cycle_time_s(message, signal_field(message, "diagnosis3")) == pytest.approx(12 * 0.02)
