"""Blocks of frames put together: who looks at the frames sees no difference."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from brake_monitor.frame import Frame, FrameKind
from brake_monitor.frame_block import FrameBlock

frames = st.builds(
    Frame,
    st.floats(0.0, 2e9),
    st.sampled_from(["front", "rear", ""]),
    st.integers(0, 0x1FFFFFFF),
    st.booleans(),
    st.binary(max_size=12),
    st.sampled_from([FrameKind.DATA, FrameKind.DATA, FrameKind.REMOTE, FrameKind.ERROR]),
)


@given(st.lists(st.lists(frames, min_size=1, max_size=4), min_size=1, max_size=4))
def test_joined_blocks_hold_the_same_frames_as_one_of_all(parts: list[list[Frame]]) -> None:
    together = [frame for part in parts for frame in part]

    joined, whole = FrameBlock.joined([FrameBlock.of(part) for part in parts]), FrameBlock.of(together)

    assert list(joined) == together
    assert joined.errors == whole.errors
    assert joined.length.tolist() == whole.length.tolist()
    data = np.flatnonzero(whole.length >= 8)
    assert joined.words(data, np.zeros_like(data)).tolist() == whole.words(data, np.zeros_like(data)).tolist()
    named, places = joined.identifiers
    assert [named[place] for place in places.tolist()] == [
        (frame.bus, frame.extended, frame.can_id) for frame in together
    ]
