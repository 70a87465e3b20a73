"""Paths are free and repeat themselves, and shortcuts never lengthen."""

import numpy as np
from hypothesis import event, given, settings
from hypothesis import strategies as st

from kabo.streams import stream_key
from kabo.ways import NoPath, find_way, shortened
from tests.ways.worlds import LEFT, LOWER, RIGHT, UPPER, Discs, length

COUNT = settings.get_profile("kabo").max_examples


@st.composite
def worlds(draw):
    """Discs anywhere, few or many, small or large; sometimes they hem in an end."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    count = draw(st.sampled_from([0, 3, 10, 25]))
    return Discs(rng.uniform(-2, 2, (count, 2)), rng.uniform(0.05, 0.5, count))


@settings(max_examples=max(20, COUNT // 2))
@given(world=worlds(), number=st.integers(0, 1000))
def test_every_path_is_free_and_repeats_itself_and_never_gets_longer(world, number):
    key = stream_key("law", number)

    def found():
        return find_way(LEFT, RIGHT, world.space(), LOWER, UPPER, key, samples=150, restart=60)

    path = found()
    if isinstance(path, NoPath):
        event("blocked")
        assert path.hits
        assert path.samples in (0, 150)
        assert isinstance(found(), NoPath)
        return
    event("straight" if len(path) == 2 else "around")
    assert np.array_equal(path, found())
    assert np.array_equal(path[[0, -1]], [LEFT, RIGHT])
    assert world.clearance(path) > 0
    short = shortened(path, world.space(), key, 40)
    assert length(short) <= length(path)
    assert np.array_equal(short[[0, -1]], [LEFT, RIGHT])
    assert world.clearance(short) > 0
    assert np.array_equal(short, shortened(path, world.space(looks=False), key, 40))
