"""A small part of `python tests/fuzz/run.py`, with hypothesis choosing what is spoilt."""

import random
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fuzzing import TARGETS, is_taken, mutated, play, random_frames

dice = st.integers(0, 2**64).map(random.Random)


@cache
def good(target: str) -> bytes:
    with TemporaryDirectory() as folder:
        return TARGETS[target].good(Path(folder))


@given(dice)
@settings(max_examples=20, deadline=None)
def test_frames(dice: random.Random) -> None:
    play(random_frames(dice), 1000)


def test_random_frames_are_no_desert() -> None:
    """Nonsense that never came as far as the filter would prove nothing."""
    assert play(random_frames(random.Random(1)), 3000) > 50


@pytest.mark.parametrize("target", TARGETS)
def test_what_is_good_is_taken(target: str, tmp_path: Path) -> None:
    assert is_taken(TARGETS[target].read, good(target), tmp_path)


@pytest.mark.parametrize("target", TARGETS)
@given(dice=dice)
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_what_is_spoilt_is_taken_or_refused_in_a_sentence(target: str, dice: random.Random) -> None:
    content = mutated(good(target), dice)
    with TemporaryDirectory() as folder:
        is_taken(TARGETS[target].read, content, Path(folder))
