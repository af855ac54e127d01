"""Shifts between images give their places; those that contradict the others are found out."""

import numpy as np
import pytest

from pipeline.cable.levelling import Net, net_places
from pipeline.core.errors import StageError


def net(places, pairs, along=None):
    first, second = np.array(pairs).T
    return Net(
        first=first,
        second=second,
        along_m=places[second] - places[first] if along is None else along,
        sigma_m=np.full(len(pairs), 1e-3),
    )


PLACES = np.array([0.07, 0.0, 0.11, 0.04, 0.19])
PAIRS = [(a, b) for a in range(5) for b in range(a + 1, 5)]


def test_shifts_that_contradict_the_others_do_not_move_the_places():
    good = net(PLACES, PAIRS)
    spoilt = good.along_m + np.where(np.arange(len(PAIRS)) % 4 == 0, 0.05, 0)
    found = net_places(net(PLACES, PAIRS, spoilt), 0.01, list("abcde"), "Block1")
    np.testing.assert_allclose(found - found[0], PLACES - PLACES[0], atol=1e-9)


def test_a_chain_is_enough():
    found = net_places(net(PLACES, [(0, 1), (1, 2), (2, 3), (3, 4)]), 0.01, list("abcde"), "Block1")
    np.testing.assert_allclose(found - found[0], PLACES - PLACES[0], atol=1e-9)


def test_groups_without_a_common_mark_are_told_by_the_smaller():
    with pytest.raises(StageError, match="Block1: d, e cannot be tied"):
        net_places(net(PLACES, [(0, 1), (1, 2), (3, 4)]), 0.01, list("abcde"), "Block1")
