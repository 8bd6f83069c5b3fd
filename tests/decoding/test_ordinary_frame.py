"""The short cut gives what the long way gives, or nothing."""

from dataclasses import replace
from math import inf, nan

from cantools.database.can import Message, Signal
from cantools.database.conversion import BaseConversion
from hypothesis import given
from hypothesis import strategies as st

from brake_monitor.decoding.mapped_signal import MappedSignal
from brake_monitor.decoding.ordinary_frame import ordinary_frame
from brake_monitor.decoding.qualifier import Qualifier
from brake_monitor.decoding.signal_field import signal_field
from brake_monitor.samples import Channel, Quality, Quantity, Sample

LENGTH = 8
quantities = st.sampled_from([Quantity.SPEED, Quantity.WSP_ACTIVE])  # a flag is 0 or 1


@st.composite
def entries(draw: st.DrawFn) -> MappedSignal:
    is_float = draw(st.booleans())
    length = draw(st.sampled_from([16, 32, 64]) if is_float else st.integers(1, 64))
    first = draw(st.integers(0, 8 * LENGTH - length))
    is_big_endian = draw(st.booleans())
    low, high = sorted(draw(st.tuples(st.integers(-500, 500), st.integers(-500, 500))))
    signal = Signal(
        "s",
        8 * (first // 8) + 7 - first % 8 if is_big_endian else first,  # a DBC names a Motorola signal's top bit
        length,
        "big_endian" if is_big_endian else "little_endian",
        is_signed=draw(st.booleans()),
        minimum=low,
        maximum=high,  # with both the same there is no range
        conversion=BaseConversion.factory(
            draw(st.sampled_from([1, 0.01, -0.5, 3])),
            draw(st.sampled_from([0, -40, 0.25])),
            choices=dict.fromkeys(draw(st.sets(st.integers(-3, 3))), "not available"),
            is_float=is_float,
        ),
    )
    return MappedSignal(
        channel=Channel(draw(quantities), draw(st.integers(0, 3)), "can0", "M", "s", 0.1, 0.0, 1.0),
        field=signal_field(Message(1, "M", LENGTH, [signal], strict=False), "s"),
        gain=draw(st.sampled_from([1.0, 1.0 / 3.6, -2.0])),
        bias=draw(st.sampled_from([0.0, -7.5])),
        minimum=draw(st.sampled_from([-inf, -20.0])),
        maximum=draw(st.sampled_from([inf, 20.0])),
        no_data_from=draw(st.sampled_from([nan, 254, 2])),
        counter="",
    )


@st.composite
def qualifiers(draw: st.DrawFn) -> Qualifier | None:
    """None, or one of up to four bits, so that few numbers are good and few are not."""
    length, is_big_endian = draw(st.integers(1, 4)), draw(st.booleans())
    first = draw(st.integers(0, 8 * LENGTH - length))
    signal = Signal(
        "q",
        8 * (first // 8) + 7 - first % 8 if is_big_endian else first,
        length,
        "big_endian" if is_big_endian else "little_endian",
        is_signed=draw(st.booleans()),
    )
    field = signal_field(Message(1, "M", LENGTH, [signal], strict=False), "q")
    good = draw(st.frozensets(st.integers(*field.raw_range()), min_size=1))
    return draw(st.sampled_from([None, Qualifier(field, good)]))


payloads = st.binary(max_size=LENGTH + 2) | st.binary(min_size=LENGTH, max_size=LENGTH)


@given(st.lists(st.tuples(entries(), qualifiers()), min_size=1, max_size=5), payloads, st.booleans())
def test_short_cut_and_long_way_agree(
    drawn: list[tuple[MappedSignal, Qualifier | None]], payload: bytes, is_small: bool
) -> None:
    mapped = [replace(entry, qualifier=qualifier) for entry, qualifier in drawn]
    data = bytes(byte & 3 for byte in payload) if is_small else payload  # small numbers are in range more often
    ordinary = ordinary_frame(mapped, LENGTH)
    assert ordinary is not None
    samples = []
    for entry in mapped:
        raw = entry.field.raw_of(data)
        if raw is not None:
            channel = entry.channel
            samples.append(Sample(1.5, channel.quantity, channel.wheelset, *entry.convert(raw)))
    is_ordinary = len(data) == LENGTH and all(sample.quality is Quality.GOOD for sample in samples)
    is_ordinary &= all(told.field.raw_of(data) in told.good for _, told in drawn if told is not None)
    assert ordinary(1.5, data) == (samples if is_ordinary else None)


@given(qualifiers(), st.binary(min_size=LENGTH, max_size=LENGTH))
def test_a_value_that_is_always_good_is_so_while_its_qualifier_says_so(
    qualifier: Qualifier | None, data: bytes
) -> None:
    """Among other values a frame that is ordinary but for a qualifier is rare."""
    field = signal_field(Message(1, "M", LENGTH, [Signal("s", 0, 16)], strict=False), "s")
    channel = Channel(Quantity.SPEED, 0, "can0", "M", "s", 0.1, 0.0, 1.0)
    entry = MappedSignal(channel, field, 1.0, 0.0, -inf, inf, nan, "", qualifier)
    samples = ordinary_frame([entry], LENGTH)(1.5, data)
    assert (samples is not None) is (qualifier is None or qualifier.field.raw_of(data) in qualifier.good)
