"""Which segments hang together where some tell nothing."""

from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.segments.joined import unbroken


def finished(number, places, at_m=0.0):
    """``places`` of its axis at ``at_m``; it tells what lies before 1 m."""
    told = None if places is None else SimpleNamespace(axis=SimpleNamespace(position_m=np.full(places, at_m)))
    placement = SimpleNamespace(here=lambda y_m, last: y_m < 1.0 or last)
    return SimpleNamespace(number=number, told=told, placement=placement)


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


def test_so_does_one_whose_axis_its_neighbours_tell_all_of():
    segments = finished(1, 50), finished(2, 50, at_m=1.2), finished(3, 50)
    assert [[s.number for s in chain] for chain in unbroken(segments)] == [[1], [3]]
    assert [[s.number for s in chain] for chain in unbroken(segments[:2])] == [[1, 2]]  # to the survey's end
