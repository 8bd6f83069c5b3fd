"""A value is used while the signal beside it says that it may be; what cannot say so is refused by name."""

from pathlib import Path

import pytest

from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.errors import InputError
from brake_monitor.frame import Frame
from brake_monitor.frame_block import FrameBlock
from brake_monitor.samples import Quality, Quantity
from test_signals import settings

MAPPED = 'message = "S", signal = "v", qualifier = "q"'
GOOD, NOT_AVAILABLE, BAD_COUNTER = Quality.GOOD, Quality.NOT_AVAILABLE, Quality.BAD_COUNTER


def decoder_of(tmp_path: Path, speed: str, *signals: str) -> SignalDecoder:
    """The speed of a message with these signals beside v; given as the DBC has them, but for the scale."""
    layout = "".join(f'\n SG_ {signal} (1,0) [0|0] "" A' for signal in signals)
    return SignalDecoder.from_settings(settings(tmp_path, speed, f"BO_ 7 S: 3 A{layout}"))


def qualities(decoder: SignalDecoder, *payloads: str) -> list[Quality | None]:
    """Of the speed in frame after frame, alone and by the block; None where a frame has none."""
    frames = [Frame(0.01 * k, "can0", 7, False, bytes.fromhex(payload)) for k, payload in enumerate(payloads)]
    singly = [[sample.quality for sample in decoder.decode(frame)] for frame in frames]
    together = decoder.decode_block(FrameBlock.of(frames))
    assert [quality for found in singly for quality in found] == [sample.quality for sample in together.samples]
    return [found[0] if found else None for found in singly]


@pytest.mark.parametrize(("good", "taken"), [("", {1}), (", qualifier_good = [2, 3]", {2, 3})])
def test_other_numbers_than_the_good_ones_reject_the_value(tmp_path: Path, good: str, taken: set[int]) -> None:
    decoder = decoder_of(tmp_path, MAPPED + good, "v : 0|8@1+", "q : 8|2@1+")
    found = qualities(decoder, *(f"05{number:02X}00" for number in range(4)))
    assert found == [GOOD if number in taken else NOT_AVAILABLE for number in range(4)]
    (qualifier,) = decoder.qualifiers.values()
    assert qualifier.rejected == 2 * (4 - len(taken))  # alone and by the block
    assert decoder.counts.not_available == qualifier.rejected


def test_a_qualifier_with_a_sign_may_be_good_by_a_negative_number(tmp_path: Path) -> None:
    decoder = decoder_of(tmp_path, f"{MAPPED}, qualifier_good = [-1]", "v : 0|8@1+", "q : 8|2@1-")
    assert qualities(decoder, "050300", "050100") == [GOOD, NOT_AVAILABLE]


def test_a_rejected_value_does_not_keep_its_channel_alive(tmp_path: Path) -> None:
    decoder = decoder_of(tmp_path, f"{MAPPED}, timeout_s = 0.5", "v : 0|8@1+", "q : 8|2@1+")
    decoder.decode(Frame(10.0, "can0", 7, False, bytes.fromhex("050100")))
    for time_s in (10.2, 10.4, 10.6):
        decoder.decode(Frame(time_s, "can0", 7, False, bytes.fromhex("050000")))
    assert Quantity.SPEED in {sample.quantity for sample in decoder.expire(10.6)}


def test_a_frame_that_ends_before_the_qualifier_is_too_short(tmp_path: Path) -> None:
    decoder = decoder_of(tmp_path, MAPPED, "v : 0|8@1+", "q : 8|2@1+")
    assert qualities(decoder, "05", "0501", "0500") == [None, GOOD, NOT_AVAILABLE]
    assert decoder.counts.short_frames == 2  # alone and by the block
    (qualifier,) = decoder.qualifiers.values()
    assert qualifier.rejected == 2


def test_a_repeated_frame_says_nothing_by_its_qualifier(tmp_path: Path) -> None:
    mapped = f'{MAPPED}, counter = "c", timeout_s = 100.0'
    alone, by_block = (decoder_of(tmp_path, mapped, "v : 0|8@1+", "q : 8|2@1+", "c : 16|4@1+") for _ in range(2))
    frames = [Frame(0.01 * k, "can0", 7, False, bytes([5, q, c])) for k, (q, c) in enumerate([(1, 0), (0, 0), (0, 1)])]
    samples = [each for frame in frames for each in alone.decode(frame)]
    assert [each.quality for each in samples] == [GOOD, BAD_COUNTER, NOT_AVAILABLE]
    assert by_block.decode_block(FrameBlock.of(frames)).samples == samples
    for decoder in (alone, by_block):
        assert [qualifier.rejected for qualifier in decoder.qualifiers.values()] == [1]


PAGES = ("page M : 0|4@1+", "v m1 : 8|8@1+")


@pytest.mark.parametrize("qualifier", ["q m1 : 16|2@1+", "q : 16|2@1+", "q : 4|2@1+"])
def test_a_qualifier_may_be_on_the_page_of_its_value_or_on_all(tmp_path: Path, qualifier: str) -> None:
    decoder = decoder_of(tmp_path, MAPPED, *PAGES, qualifier, "w m2 : 8|8@1+")
    assert qualities(decoder, "110501", "010500", "120501") == [GOOD, NOT_AVAILABLE, None]


@pytest.mark.parametrize(
    ("qualifier", "sentence"),
    [
        ("q m2 : 16|2@1+", 'signal "q" cannot be the qualifier of "v": it is only on some pages, expected a whole '
         "number in every frame that has the value"),
        ("r : 16|2@1+", 'message "S" has no signal "q", there is'),
    ],
)  # fmt: skip
def test_a_signal_that_cannot_tell_is_no_qualifier(tmp_path: Path, qualifier: str, sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        decoder_of(tmp_path, MAPPED, *PAGES, qualifier, "w m2 : 8|8@1+")
    assert str(caught.value).startswith(f"{tmp_path / 'x.toml'}:15: signals.speed.qualifier: {sentence}")


def test_a_qualifier_on_a_page_does_not_tell_of_a_value_on_all(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="it is only on some pages"):
        decoder_of(tmp_path, MAPPED, "page M : 0|4@1+", "v : 8|8@1+", "q m1 : 16|2@1+")


def test_a_floating_point_number_is_no_qualifier(tmp_path: Path) -> None:
    layout = (
        'BO_ 7 S: 8 A\n SG_ v : 0|8@1+ (1,0) [0|0] "" A\n SG_ q : 8|32@1- (1,0) [0|0] "" A\n\nSIG_VALTYPE_ 7 q : 1;'
    )
    with pytest.raises(
        InputError, match=r'signals.speed.qualifier: signal "q" cannot be .* it is a floating-point num'
    ):
        SignalDecoder.from_settings(settings(tmp_path, MAPPED, layout))


def test_a_value_is_not_its_own_qualifier(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"signals.speed.qualifier: .* it is the value itself"):
        decoder_of(tmp_path, 'message = "S", signal = "v", qualifier = "v"', "v : 0|8@1+")


@pytest.mark.parametrize(
    ("layout", "good", "sentence"),
    [
        ("q : 8|2@1+", "[1, 4]", 'signal "q" has 2 bits, expected raw numbers from 0 to 3'),
        ("q : 8|1@1+", "[-1]", 'signal "q" has 1 bit, expected raw numbers from 0 to 1'),
        ("q : 8|2@1-", "[2]", 'signal "q" has 2 bits, expected raw numbers from -2 to 1'),
        ("q : 8|1@1-", "", 'signal "q" has 1 bit, expected raw numbers from -1 to 0'),
        ("q : 8|2@1+", f"[{10**30}]", 'signal "q" has 2 bits, expected raw numbers from 0 to 3'),
    ],
)
def test_numbers_that_a_qualifier_cannot_have_are_refused(
    tmp_path: Path, layout: str, good: str, sentence: str
) -> None:
    with pytest.raises(InputError) as caught:
        decoder_of(tmp_path, MAPPED + (good and f", qualifier_good = {good}"), "v : 0|8@1+", layout)
    assert str(caught.value) == f"{tmp_path / 'x.toml'}:15: signals.speed.qualifier_good: {sentence}"
