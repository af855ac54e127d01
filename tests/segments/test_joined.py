"""Which segments hang together where some tell nothing."""

from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.segments.joined import unbroken


def finished(number, places):
    told = None if places is None else SimpleNamespace(axis=SimpleNamespace(position_m=np.zeros(places)))
    return SimpleNamespace(number=number, told=told)


@pytest.mark.parametrize(
    ("places", "chains"),
    [
        ([50, 50, 50], [[1, 2, 3]]),
        ([50, None, 50, 50], [[1], [3, 4]]),
        ([None, 50, 50, None], [[2, 3]]),
        ([50, 2, 50], [[1], [3]]),
        ([None, None], []),
    ],
)
def test_a_segment_that_tells_nothing_of_its_axis_breaks_the_chain(places, chains):
    segments = tuple(finished(n, p) for n, p in enumerate(places, 1))
    assert [[s.number for s in chain] for chain in unbroken(segments)] == chains
