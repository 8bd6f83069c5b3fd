import re
from collections.abc import Callable
from math import isnan, pi, sqrt
from pathlib import Path

import can
import cantools
import pytest
from cantools.database.can import Message, Signal
from hypothesis import given
from hypothesis import strategies as st

from brake_monitor.decoding.j1939 import first_not_available, pgn_bits
from brake_monitor.decoding.rolling_counter import RollingCounter
from brake_monitor.decoding.signal_field import signal_field
from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.errors import InputError
from brake_monitor.frame import Frame, FrameKind
from brake_monitor.frame_block import FrameBlock
from brake_monitor.samples import TRAITS, Quality, Quantity, Sample
from brake_monitor.settings.config import Settings, Signals
from brake_monitor.settings.config_file import load_settings
from brake_monitor.settings.units import shown_unit

VEHICLES = Path(__file__).parents[2] / "dbc"
WAGON = load_settings(VEHICLES / "wagon.toml")
WAGON_DBC = cantools.database.load_file(VEHICLES / "wagon.dbc")


def wagon() -> SignalDecoder:
    return SignalDecoder.from_settings(WAGON)


def frame(time_s: float, name: str, **values: float) -> Frame:
    """A frame of the wagon with every signal at 0 but for the given ones (physical values)."""
    message = WAGON_DBC.get_message_by_name(name)
    signals = {signal.name: 0 for signal in message.signals} | values
    return Frame(time_s, "can0", message.frame_id, message.is_extended_frame, message.encode(signals, strict=False))


def by_quantity(samples: list[Sample], quantity: Quantity) -> list[Sample]:
    return [sample for sample in samples if sample.quantity is quantity]


def settings(tmp_path: Path, speed: str, messages: str = "") -> Settings:
    """One wheelset; `speed` is the mapping under test, the other two are there because they must be."""
    (tmp_path / "x.dbc").write_text(f"""VERSION ""\n\nNS_ :\n\nBS_:\n\nBU_: A\n
BO_ 100 Wheel: 8 A
 SG_ n : 0|16@1+ (0.1,0) [0|0] "" A
 SG_ F : 16|16@1+ (10,0) [0|0] "" A
{messages}
""")
    config = tmp_path / "x.toml"
    config.write_text(f"""
[vehicle]
id = "x"
mass_kg = 12000.0
axle_positions_m = [0.0]
cog_height_m = 0.0
wheelset_inertia_kgm2 = 130.0
wheel_radius_m = 0.5
brake_radius_m = 0.25
[can]
interface = "virtual"
channel = "can0"
dbc = ["x.dbc"]
[signals]
speed = {{ {speed} }}
axle_speed = [{{ message = "Wheel", signal = "n" }}]
pressing_force = [{{ message = "Wheel", signal = "F" }}]
""")
    return load_settings(config)


# --- values and units ---


def test_units_scale_offset_and_clamp_reach_si() -> None:
    decoder = wagon()
    samples = decoder.decode(frame(1.0, "WSP", n_A=72.0, n_B=36.0, wsp_B=1, WSP_counter=3))
    first, second = by_quantity(samples, Quantity.AXLE_SPEED)
    assert first.value == pytest.approx(20.0 / 0.445)  # 72 km/h on the circumference
    assert (second.wheelset, second.value) == (1, pytest.approx(10.0 / 0.445))
    assert [sample.value for sample in by_quantity(samples, Quantity.WSP_ACTIVE)] == [0.0, 1.0]
    force, released = decoder.decode(frame(1.0, "BCU", p_A=3.0, p_B=0.1))
    assert force.value == pytest.approx(18600.0 * 3.0 - 4650.0)
    assert released.value == 0.0  # the cylinder spring is stronger than 0.1 bar: clamped, not negative
    (speed,) = decoder.decode(frame(1.0, "GNSS", v_ground=30.0))
    assert speed == Sample(1.0, Quantity.SPEED, 0, pytest.approx(30.0), Quality.GOOD)
    latitude, longitude = decoder.decode(frame(1.0, "GNSS_Position", latitude=-33.9, longitude=151.2))
    assert (latitude.value, longitude.value) == (pytest.approx(-33.9), pytest.approx(151.2))


@pytest.mark.parametrize(
    ("quantity", "unit", "si"),
    [
        ("speed", "", 1.0), ("speed", "km/h", 1 / 3.6), ("axle_speed", "", 1.0), ("axle_speed", "rpm", 2 * pi / 60),
        ("axle_speed", "m/s", 1 / 0.5), ("axle_speed", "km/h", 1 / 3.6 / 0.5), ("pressing_force", "kN", 1000.0),
    ],
)  # fmt: skip
def test_every_unit(tmp_path: Path, quantity: str, unit: str, si: float) -> None:
    made = settings(tmp_path, 'message = "Wheel", signal = "n"')
    path = made.path
    path.write_text(re.sub(rf"({quantity} = \[?{{ )", rf'\1unit = "{unit}", ', path.read_text()))
    decoder = SignalDecoder.from_settings(load_settings(path))
    samples = decoder.decode(Frame(0.0, "can0", 100, False, b"\x0a\x00\x0a\x00\x00\x00\x00\x00"))
    (sample,) = by_quantity(samples, Quantity(quantity))
    physical = 100.0 if quantity == "pressing_force" else 1.0
    assert sample.value == pytest.approx(physical * si)


@pytest.mark.parametrize(
    ("quantity", "unit", "si"),
    [
        ("load_force", "kN", 1000.0), ("wheel_torque", "Nm", 1.0), ("wheel_torque", "kN m", 1000.0),
        ("wheel_torque", "kNm", 1000.0), ("gradient", "%", 0.01), ("gradient", "‰", 0.001),
        ("gradient", "permille", 0.001),
    ],
)  # fmt: skip
def test_every_unit_of_what_need_not_be_mapped(tmp_path: Path, quantity: str, unit: str, si: float) -> None:
    path = settings(tmp_path, 'message = "Wheel", signal = "n"', 'BO_ 7 S: 1 A\n SG_ v : 0|8@1+ (1,0) [0|0] "" A').path
    entry = f'{{ message = "S", signal = "v", unit = "{unit}" }}'
    path.write_text(f"{path.read_text()}{quantity} = {entry if quantity == 'gradient' else f'[{entry}]'}\n")
    (sample,) = SignalDecoder.from_settings(load_settings(path)).decode(Frame(0.0, "can0", 7, False, b"\x03"))
    assert (sample.quantity, sample.value) == (quantity, pytest.approx(3.0 * si))


def test_clamps_are_in_the_unit_of_the_mapping(tmp_path: Path) -> None:
    path = settings(tmp_path, 'message = "Wheel", signal = "n"').path
    text = path.read_text().replace('signal = "n" }]', 'signal = "n", unit = "km/h", min = 3.6, max = 36.0 }]')
    path.write_text(text.replace('signal = "F"', 'signal = "F", unit = "kN", min = 0.5, max = 60.0'))
    decoder = SignalDecoder.from_settings(load_settings(path))
    low, high = (decoder.decode(Frame(0.0, "can0", 100, False, data + bytes(4))) for data in (bytes(4), b"\xff" * 4))
    for samples, speed_mps, force_n in ((low, 1.0, 500.0), (high, 10.0, 60_000.0)):
        (axle_speed,), (force,) = (by_quantity(samples, q) for q in (Quantity.AXLE_SPEED, Quantity.PRESSING_FORCE))
        assert axle_speed.value == pytest.approx(speed_mps / 0.5)
        assert force.value == pytest.approx(force_n)


def test_every_quantity_has_its_traits_and_its_key_in_the_configuration() -> None:
    assert list(TRAITS) == list(Quantity) == list(Signals.__struct_fields__)


def test_the_unit_that_is_shown_is_that_of_the_samples_and_flags_and_ratios_have_none() -> None:
    shown = {quantity: shown_unit(quantity) for quantity in Quantity}
    without = {quantity for quantity, unit in shown.items() if not unit}
    assert without == {Quantity.WSP_ACTIVE, Quantity.SANDING, Quantity.GRADIENT}
    assert all(TRAITS[quantity].units[unit] == 1.0 for quantity, unit in shown.items() if unit)


def test_noise_joins_sigma_and_quantisation_in_si() -> None:
    noise = {(c.quantity, c.wheelset): c.noise_std for c in wagon().channels}
    lsb = 0.01 / 3.6 / 0.445  # rad/s
    assert noise[Quantity.AXLE_SPEED, 0] == pytest.approx(sqrt((0.01 / 0.445) ** 2 + lsb**2 / 12))
    assert noise[Quantity.PRESSING_FORCE, 1] == pytest.approx(sqrt(100.0**2 + (0.002 * 18600.0) ** 2 / 12))


def test_channels_list_what_is_mapped_in_the_order_of_the_quantities() -> None:
    places = [(list(Quantity).index(c.quantity), c.wheelset) for c in wagon().channels]
    assert places == sorted(places)
    timeouts = {c.message: c.timeout_s for c in wagon().channels}
    assert timeouts["WSP"] == pytest.approx(0.1)  # five cycles
    assert timeouts["BCU_Status"] == pytest.approx(1.5)  # five cycles of three pages


def test_what_changes_slowly_may_come_seldom_where_the_dbc_has_no_cycle_time(tmp_path: Path) -> None:
    path = settings(tmp_path, 'message = "Wheel", signal = "n"').path
    entry = '{ message = "Wheel", signal = "F", scale = 0.1 }'
    slow = (Quantity.LOAD_FORCE, Quantity.GRADIENT, Quantity.LATITUDE, Quantity.LONGITUDE)
    more = [f"{name} = {f'[{entry}]' if name is Quantity.LOAD_FORCE else entry}\n" for name in (*slow, "sanding")]
    path.write_text(path.read_text() + "".join(more))
    timeouts = {c.quantity: c.timeout_s for c in SignalDecoder.from_settings(load_settings(path)).channels}
    fast = (Quantity.SPEED, Quantity.AXLE_SPEED, Quantity.PRESSING_FORCE, Quantity.SANDING)
    assert timeouts == dict.fromkeys(fast, 1.0) | dict.fromkeys(slow, 5.0)


# --- quality ---


def test_quality_of_values() -> None:
    decoder = wagon()
    good, out_of_range = by_quantity(decoder.decode(frame(1.0, "WSP", n_A=400.0, n_B=400.01)), Quantity.AXLE_SPEED)
    assert (good.quality, out_of_range.quality) == (Quality.GOOD, Quality.OUT_OF_RANGE)
    broken, absent = decoder.decode(frame(1.0, "BCU", p_A=65534 * 0.002, p_B=65535 * 0.002))
    assert broken.quality is absent.quality is Quality.NOT_AVAILABLE
    assert (decoder.counts.out_of_range, decoder.counts.not_available) == (1, 2)


@pytest.mark.parametrize("span", ["[-1000|60000]", "[0|0]"], ids=["a range", "no range"])
def test_floats_that_are_no_numbers_are_not_available(tmp_path: Path, span: str) -> None:
    for name in ("rig.toml", "rig.dbc"):
        text = (VEHICLES / name).read_text(encoding="utf-8")
        (tmp_path / name).write_text(text.replace("[-1000|60000]", span), encoding="utf-8")
    settings = load_settings(tmp_path / "rig.toml")
    for raw, quality in [
        ("0000c07f", Quality.NOT_AVAILABLE),
        ("0000807f", Quality.OUT_OF_RANGE),
        ("00401c46", Quality.GOOD),
    ]:
        decoder = SignalDecoder.from_settings(settings)  # a fresh counter
        (sample,) = decoder.decode(Frame(1.0, "can0", 257, False, bytes.fromhex(raw) + b"\0\0\0\0"))
        assert sample.quality is quality
    assert sample.value == 10000.0


FLAG = "BO_ 200 State: 8 A\n SG_ {}\n"
TWO_BITS, PERCENT = 'acts : 0|2@1+ (1,0) [0|3] "" A', 'acts : 0|8@1+ (0.5,0) [0|0] "%" A'


@pytest.mark.parametrize(
    ("signal", "mapping", "values"),
    [
        (TWO_BITS, "", {0: 0.0, 1: 1.0, 2: None, 3: None}),
        (TWO_BITS, ", scale = -1.0, offset = 1.0", {0: 1.0, 1: 0.0, 2: None, 3: None}),
        (TWO_BITS, ", min = 0.0, max = 1.0", {0: 0.0, 1: 1.0, 2: None, 3: None}),  # no clamp makes a 1 of an error
        (PERCENT, ", scale = 0.01", {0: 0.0, 200: 1.0, 1: None, 100: None, 201: None, 255: None}),
    ],
)
@pytest.mark.parametrize("quantity", ["wsp_active", "sanding"])
def test_a_flag_is_0_or_1(
    tmp_path: Path, quantity: str, signal: str, mapping: str, values: dict[int, float | None]
) -> None:
    """Two bits may also say "error" or "not available", and a DBC need not tell. `values` by raw ones."""
    path = settings(tmp_path, 'message = "Wheel", signal = "n"', FLAG.format(signal)).path
    flag = f'{{ message = "State", signal = "acts"{mapping} }}'
    path.write_text(f"{path.read_text()}{quantity} = {flag if quantity == 'sanding' else f'[{flag}]'}\n")
    frames = [Frame(float(k), "can0", 200, False, bytes([raw, *bytes(7)])) for k, raw in enumerate(values)]
    alone, together = (SignalDecoder.from_settings(load_settings(path)) for _ in range(2))
    samples = [sample for frame in frames for sample in alone.decode(frame)]
    assert [sample.value if sample.quality is Quality.GOOD else None for sample in samples] == list(values.values())
    assert {sample.quality for sample in samples} == {Quality.GOOD, Quality.OUT_OF_RANGE}
    assert together.decode_block(FrameBlock.of(frames)).samples == samples
    assert together.counts == alone.counts
    assert alone.counts.out_of_range == list(values.values()).count(None)


# --- frames that are not as they should be ---


def test_frames_that_carry_nothing_are_counted() -> None:
    decoder = wagon()
    good = frame(1.0, "WSP")
    for bad in [
        good._replace(kind=FrameKind.ERROR),
        good._replace(kind=FrameKind.REMOTE),
        good._replace(bus="other"),
        good._replace(can_id=0x7FF),
        good._replace(extended=True),
        good._replace(data=b""),
    ]:
        assert decoder.decode(bad) == []
    counts = decoder.counts
    assert (counts.frames, counts.error_frames, counts.remote_frames, counts.unmapped) == (6, 1, 1, 3)
    assert (counts.other_width, counts.mapped, counts.short_frames) == (1, 1, 1)


def test_short_and_long_frames() -> None:
    decoder = wagon()
    whole = frame(1.0, "GNSS_Position", latitude=50.0, longitude=8.0)
    (latitude,) = decoder.decode(whole._replace(data=whole.data[:5]))
    assert latitude.value == pytest.approx(50.0)
    assert decoder.counts.short_frames == 1
    longer = decoder.decode(whole._replace(data=whole.data + bytes(56)))  # CAN FD
    assert [sample.value for sample in longer] == [pytest.approx(50.0), pytest.approx(8.0)]


def test_multiplexed_pages() -> None:
    decoder = wagon()
    load = Frame(1.0, "can0", 800, False, bytes([0, 0, 44, 1, 0, 0, 0, 0]))
    (sample,) = decoder.decode(load)
    assert sample.value == pytest.approx(3.0 * 100e3 + 53160.0)  # 300 steps of 0.01 bar
    assert decoder.decode(load._replace(data=bytes([1]) + load.data[1:])) == []
    assert decoder.counts.unknown_multiplexer == 0
    assert decoder.decode(load._replace(data=bytes([9]) + load.data[1:])) == []
    assert decoder.counts.unknown_multiplexer == 1


@given(st.lists(st.tuples(st.integers(0, 0x7FF), st.binary(max_size=64), st.sampled_from(FrameKind)), max_size=30))
def test_no_traffic_harms_the_decoder(traffic: list[tuple[int, bytes, FrameKind]]) -> None:
    decoder = DECODER
    before = decoder.counts.frames
    for place, (can_id, data, kind) in enumerate(traffic):
        known = (288, 416, 672, 673, 800)[can_id % 5] if can_id % 2 else can_id
        for sample in decoder.decode(Frame(float(place), "can0", known, False, data, kind)):
            assert isinstance(sample.value, float)
    assert decoder.counts.frames == before + len(traffic)


DECODER = wagon()


# --- rolling counter ---


def counter() -> RollingCounter:
    message = Message(1, "M", 1, [Signal("count", 0, 8, minimum=0, maximum=15)])
    return RollingCounter(signal_field(message, "count"), timeout_s=0.1)


def feed(times_and_counts: list[tuple[float, int]]) -> list[tuple[bool, int]]:
    rolling = counter()
    return [rolling.check(time_s, bytes([count])) for time_s, count in times_and_counts]


@given(st.integers(0, 15), st.integers(2, 40))
def test_an_advancing_counter_is_good(start: int, frames: int) -> None:
    assert set(feed([(0.01 * i, (start + i) % 16) for i in range(frames)])) == {(True, 0)}


def test_counter_judgements() -> None:
    assert feed([(0.0, 4), (0.01, 4), (0.02, 5)]) == [(True, 0), (False, 0), (True, 0)]  # frozen once
    assert feed([(0.0, 14), (0.03, 1)]) == [(True, 0), (True, 2)]  # two frames lost over the turn
    assert feed([(0.0, 4), (0.08, 12)]) == [(True, 0), (True, 7)]  # half the range
    assert feed([(0.0, 4), (0.08, 13)]) == [(True, 0), (False, 0)]  # more: rather seven back
    assert feed([(0.0, 4), (0.01, 3), (0.02, 4)]) == [(True, 0), (False, 0), (True, 0)]  # a step back
    assert feed([(0.0, 4), (0.2, 4)]) == [(True, 0), (True, 0)]  # after a silence nothing can be compared
    assert feed([(5.0, 4), (1.0, 4)]) == [(True, 0), (True, 0)]  # the clock was set back
    assert counter().check(0.0, bytes([16])) == (False, 0)


def test_a_frozen_sender_spoils_the_samples_that_name_its_counter() -> None:
    decoder = wagon()
    qualities = [
        {sample.quality for sample in decoder.decode(frame(0.02 * i, "WSP", n_A=50.0, WSP_counter=count))}
        for i, count in enumerate([7, 8, 8, 9, 12])
    ]
    assert qualities == [{Quality.GOOD}, {Quality.GOOD}, {Quality.BAD_COUNTER}, {Quality.GOOD}, {Quality.GOOD}]
    assert (decoder.counts.bad_counter, decoder.counts.lost_frames) == (4, 2)


def test_a_counter_is_compared_for_as_long_as_any_of_its_values_may_be_used(tmp_path: Path) -> None:
    signals = [f' SG_ {name} : {8 * k}|8@1+ (1,0) [0|0] "" A' for k, name in enumerate("cvw")]
    path = settings(
        tmp_path, 'message = "S", signal = "v", counter = "c", timeout_s = 0.1', "\n".join(["BO_ 7 S: 3 A", *signals])
    ).path
    path.write_text(f'{path.read_text()}gradient = {{ message = "S", signal = "w", counter = "c", timeout_s = 1.0 }}\n')
    decoder = SignalDecoder.from_settings(load_settings(path))
    seen = [decoder.decode(Frame(time_s, "can0", 7, False, bytes([4, 0, 0]))) for time_s in (0.0, 0.9, 2.0)]
    assert [{sample.quality for sample in samples} for samples in seen] == [
        {Quality.GOOD}, {Quality.BAD_COUNTER}, {Quality.GOOD},
    ]  # fmt: skip


# --- time-outs ---


def stale(decoder: SignalDecoder, time_s: float) -> set[tuple[Quantity, int]]:
    samples = decoder.expire(time_s)
    assert all(sample.quality is Quality.STALE and isnan(sample.value) for sample in samples)
    return {(sample.quantity, sample.wheelset) for sample in samples}


def test_each_lapse_is_told_once() -> None:
    decoder = wagon()
    speed = (Quantity.SPEED, 0)  # times out after 0.25 s
    assert stale(decoder, 0.0) == set()
    decoder.decode(frame(0.1, "GNSS", v_ground=10.0))
    assert speed not in stale(decoder, 0.34)
    assert speed in stale(decoder, 0.36)
    assert speed not in stale(decoder, 5.0)
    decoder.decode(frame(6.0, "GNSS", v_ground=10.0))
    assert speed not in stale(decoder, 6.24)
    assert speed in stale(decoder, 6.26)


def test_a_channel_that_never_spoke_lapses_too() -> None:
    decoder = wagon()
    stale(decoder, 100.0)
    assert stale(decoder, 200.0) == {(c.quantity, c.wheelset) for c in decoder.channels}


def test_only_good_samples_keep_a_channel_alive() -> None:
    decoder = wagon()
    stale(decoder, 0.0)
    for step in range(40):
        decoder.decode(frame(0.01 * step, "BCU", p_A=65535 * 0.002, BCU_counter=step % 16))
    lapsed = stale(decoder, 0.4)
    assert (Quantity.PRESSING_FORCE, 0) in lapsed
    assert (Quantity.PRESSING_FORCE, 1) not in lapsed


def test_a_clock_that_is_set_back_does_not_silence_the_watch() -> None:
    decoder = wagon()
    stale(decoder, 5000.0)
    decoder.decode(frame(5000.0, "GNSS", v_ground=10.0))
    stale(decoder, 10.0)
    assert (Quantity.SPEED, 0) in stale(decoder, 10.3)


def test_a_frame_that_is_overtaken_does_not_lengthen_a_time_out() -> None:
    decoder = wagon()
    speed = (Quantity.SPEED, 0)  # times out after 0.25 s
    stale(decoder, 10.0)
    assert speed not in stale(decoder, 10.24)
    assert speed not in stale(decoder, 10.1)
    assert speed in stale(decoder, 10.26)


# --- J1939 ---


def bogie() -> SignalDecoder:
    return SignalDecoder.from_settings(load_settings(VEHICLES / "bogie.toml"))


@pytest.mark.parametrize("can_id", [0x0CFF200B, 0x18FF2000, 0x00FF20FE])
def test_a_pgn_is_known_whatever_priority_and_source(can_id: int) -> None:
    samples = bogie().decode(Frame(1.0, "can0", can_id, True, bytes.fromhex("102700fe00ff1027")))
    assert [sample.quality for sample in samples] == [
        Quality.GOOD, Quality.NOT_AVAILABLE, Quality.NOT_AVAILABLE, Quality.GOOD,
    ]  # fmt: skip
    assert samples[0].value == pytest.approx(100.0 / 3.6 / 0.460)


@pytest.mark.parametrize("can_id", [0x0CFF240A, 0x0DFF200B, 0x0CFE200B, 0x08FF3020])
def test_other_pgns_and_other_ids_are_not(can_id: int) -> None:
    assert bogie().decode(Frame(1.0, "can0", can_id, True, bytes(8))) == []


def test_pgn_of_both_formats() -> None:
    assert pgn_bits(0x18FEF100) == pgn_bits(0x0CFEF133)  # PDU2: the low byte is the source
    assert pgn_bits(0x18FEF100) != pgn_bits(0x18FEF200)
    assert pgn_bits(0x18EA0B33) == pgn_bits(0x18EAFF00)  # PDU1: the byte below is a destination
    assert pgn_bits(0x18EA0B33) != pgn_bits(0x18EB0B33)
    for page in (0x01000000, 0x02000000):  # data page, extended data page
        assert pgn_bits(0x18FEF100 | page) != pgn_bits(0x18FEF100)
        assert pgn_bits(0x18EA0B33 | page) != pgn_bits(0x18EA0B33)


def test_where_the_formats_of_pgns_meet() -> None:
    """PDU2 begins at F0: F004 is an engine's speed, from F003 its pedal; EF, PDU1's last, goes to one node."""
    assert pgn_bits(0x0CF00400) != pgn_bits(0x0CF00300)
    assert pgn_bits(0x18EF0033) == pgn_bits(0x18EFFF0B)


def test_codes_of_j1939() -> None:
    assert [first_not_available(bits) for bits in (1, 2, 4, 8, 16, 32)] == [None, 2, 14, 0xFE, 0xFE00, 0xFE000000]
    assert [first_not_available(bits) for bits in (3, 7)] == [0b111, 0b1111111]  # all ones, and nothing else


def test_a_range_of_two_bytes_has_no_such_codes_by_id() -> None:
    """Only J1939 reserves the top of the range; another sender may mean 0xFE00 as a number."""
    decoder = wagon()
    (speed,) = decoder.decode(Frame(1.0, "can0", 672, False, bytes.fromhex("00fe000000000000")))
    assert speed.quality is Quality.OUT_OF_RANGE


# --- mapping that does not fit ---


PGN_TWIN = """
BO_ 2566844672 Twin: 8 A
 SG_ v : 0|8@1+ (1,0) [0|0] "" A
BO_ 2365518080 Other: 8 A
 SG_ v : 0|8@1+ (1,0) [0|0] "" A
"""


@pytest.mark.parametrize(
    ("speed", "messages", "sentence"),
    [
        ('message = "Whel", signal = "n"', "", 'no message is named "Whel", did you mean "Wheel"?'),
        ('message = "Wheel", signal = "m"', "", 'message "Wheel" has no signal "m", there is "n", "F"'),
        ('message = "Wheel", signal = "n", counter = "c"', "", 'signals.speed.counter: message "Wheel" has no sig'),
        ('message = "P", signal = "v", match = "pgn", counter = "v"', PGN_TWIN, 'no message is named "P"'),
        ('message = "S", signal = "v", match = "pgn"', 'BO_ 7 S: 8 A\n SG_ v : 0|8@1+ (1,0) [0|0] "" A',
         "has an 11-bit id, which has no PGN"),
        ('message = "S", signal = "v"', 'BO_ 100 S: 8 A\n SG_ v : 0|8@1+ (1,0) [0|0] "" A',
         'by id it cannot be told from "Wheel"'),
        ('message = "Twin", signal = "v", match = "pgn"', PGN_TWIN, 'by pgn it cannot be told from "Other"'),
        ('message = "S", signal = "v"', 'BO_ 7 S: 8 A\n SG_ v : 0|8@1+ (1e300,0) [0|0] "" A',
         'one step of signal "v" in the DBC is 1e+300 in SI'),
        ('message = "S", signal = "v"', 'BO_ 7 S: 8 A\n SG_ v : 0|8@1+ (-1e300,0) [0|0] "" A',
         'one step of signal "v" in the DBC is 1e+300 in SI'),
    ],
)  # fmt: skip
def test_a_mapping_that_does_not_fit_is_refused_by_name(
    tmp_path: Path, speed: str, messages: str, sentence: str
) -> None:
    made = settings(tmp_path, speed, messages)
    with pytest.raises(InputError) as caught:
        SignalDecoder.from_settings(made)
    assert sentence in str(caught.value)
    assert str(caught.value).startswith(f"{made.path}:15: signals.speed")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("layout", "reason"),
    [
        ("c : 8|8@1- (1,0) [0|0]", "it has a sign"),
        ("c : 8|8@1+ (0.5,0) [0|0]", "it has steps of 0.5"),
        ("c : 8|1@1+ (1,0) [0|0]", "it has only 2 numbers"),
        ("c : 8|8@1+ (1,0) [0|1]", "it has only 2 numbers"),
        ("c : 8|32@1- (1,0) [0|0]", "it is a floating-point number"),
        ("c m0 : 8|8@1+ (1,0) [0|0]", "it is on one page of several"),
    ],
)
def test_what_is_plainly_no_counter_is_refused_as_one(tmp_path: Path, layout: str, reason: str) -> None:
    value_types = "SIG_VALTYPE_ 7 c : 1;" if "floating" in reason else ""
    others = [f'SG_ {signal}@1+ (1,0) [0|0] "" A' for signal in ("v : 0|8", "page M : 48|8")]
    message = f'BO_ 7 S: 8 A\n {others[0]}\n SG_ {layout} "" A\n {others[1]}'
    made = settings(tmp_path, 'message = "S", signal = "v", counter = "c"', f"{message}\n{value_types}")
    with pytest.raises(InputError) as caught:
        SignalDecoder.from_settings(made)
    assert str(caught.value) == (
        f'{made.path}:15: signals.speed.counter: signal "c" cannot be a rolling counter: {reason}, expected a whole '
        "number of two bits or more, without sign, in every frame"
    )


@pytest.mark.parametrize(
    "layout", ["8|2@1+ (1,0) [0|2]", "8|2@1+ (1,0) [0|0]", "8|4@1+ (1,0) [0|14]", "8|8@1+ (1,1) [1|16]"]
)
def test_what_may_count_is_taken_for_a_counter(tmp_path: Path, layout: str) -> None:
    message = f'BO_ 7 S: 8 A\n SG_ v : 0|8@1+ (1,0) [0|0] "" A\n SG_ c : {layout} "" A'
    SignalDecoder.from_settings(settings(tmp_path, 'message = "S", signal = "v", counter = "c"', message))


def test_an_id_is_told_by_its_width(tmp_path: Path) -> None:
    """A 29-bit twin of an 11-bit id is another message."""
    twin = f'BO_ {0x80000000 | 100} Twin: 8 A\n SG_ v : 0|8@1+ (1,0) [0|0] "" A'
    decoder = SignalDecoder.from_settings(settings(tmp_path, 'message = "Twin", signal = "v"', twin))
    assert {s.quantity for s in decoder.decode(Frame(0.0, "can0", 100, True, bytes(8)))} == {Quantity.SPEED}
    assert Quantity.SPEED not in {s.quantity for s in decoder.decode(Frame(0.0, "can0", 100, False, bytes(8)))}


# --- kernel filters ---


@pytest.mark.parametrize("name", ["rig", "wagon", "bogie"])
def test_kernel_filters_pass_what_is_mapped_and_little_else(name: str) -> None:
    decoder = SignalDecoder.from_settings(load_settings(VEHICLES / f"{name}.toml"))
    passes = _filter(decoder)
    for message in cantools.database.load_file(VEHICLES / f"{name}.dbc").messages:
        arrived = can.Message(arbitration_id=message.frame_id, is_extended_id=message.is_extended_frame)
        mapped = message.name in {channel.message for channel in decoder.channels}
        assert passes(arrived) == mapped
    assert not passes(can.Message(arbitration_id=0x7FE, is_extended_id=False))
    assert decoder.can_filters("other") == []


def _filter(decoder: SignalDecoder) -> Callable[[can.Message], bool]:
    def passes(message: can.Message) -> bool:
        return any(
            one["extended"] == message.is_extended_id
            and message.arbitration_id & one["can_mask"] == one["can_id"] & one["can_mask"]
            for one in decoder.can_filters("can0")
        )

    return passes


def test_samples_come_in_frame_order() -> None:
    decoder = wagon()
    samples = [s for i in range(5) for s in decoder.decode(frame(0.1 * i, "GNSS", v_ground=1.0))]
    assert [sample.time_s for sample in samples] == [0.1 * i for i in range(5)]
