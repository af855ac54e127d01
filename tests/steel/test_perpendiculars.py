"""The paper's node centre on lines whose geometry is known in closed form."""

import numpy as np
import pytest

from pipeline.steel.perpendiculars import CentreRule, perpendicular_centre
from tests.steel.seen_surfaces import unit


def through(place, *directions):
    """Lines through one place; each is given by a point some way along it."""
    axes = unit(directions)
    steps = np.linspace(0.5, 2.0, len(axes))[:, None]
    return np.asarray(place) + steps * axes, axes


def test_two_skew_lines_meet_halfway_along_their_common_perpendicular():
    places = np.array([[5.0, 0.0, 0.0], [0.0, -3.0, 0.4]])
    found = perpendicular_centre(places, np.eye(3)[:2])
    np.testing.assert_allclose(found.centre, [0.0, 0.0, 0.2], atol=1e-12)
    assert found.midpoints == 1


@pytest.mark.parametrize("count", [2, 3, 4, 5, 6, 8])
def test_lines_through_one_place_meet_there(count):
    rng = np.random.default_rng(count)
    found = perpendicular_centre(*through([1.0, -2.0, 3.0], *rng.normal(size=(count, 3))))
    np.testing.assert_allclose(found.centre, [1.0, -2.0, 3.0], atol=1e-9)
    assert found.spread_m < 1e-9


def test_three_lines_give_the_triangle_rule():
    # the axes' directions, each moved by d along another: the midpoints are known
    d = 0.02
    places, axes = np.array([[1.0, d, 0.0], [0.0, 2.0, d], [d, 0.0, 3.0]]), np.eye(3)
    found = perpendicular_centre(places, axes)
    assert found.rule is CentreRule.TRIANGLE
    assert found.midpoints == 3
    # by symmetry about (1, 1, 1) all coordinates are equal: midpoints (0, d, d/2) and its turns
    centroid = d / 2
    feet = (centroid + d + 0.0) / 3
    np.testing.assert_allclose(found.centre, np.full(3, 0.5 * (centroid + feet)), atol=1e-12)


def test_an_even_number_of_midpoints_gives_the_sphere_through_them():
    rng = np.random.default_rng(8)
    for _ in range(50):
        tetrahedral = np.array([[1, 1, 1], [-1, -1, 1], [-1, 1, -1], [1, -1, -1]])
        places, axes = through([0.0, 0.0, 0.0], *(tetrahedral + rng.normal(0, 0.1, (4, 3))))
        found = perpendicular_centre(places + rng.normal(0, 0.003, places.shape), axes)
        assert found.midpoints == 6
        assert found.rule in (CentreRule.SPHERE, CentreRule.CENTROID)
        # whichever rule: never far from the lines, where equation 14 alone may run off
        assert np.linalg.norm(found.centre) < 0.05


def test_rods_in_one_line_have_no_perpendicular():
    places = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.001]])
    axes = unit([[1.0, 0.0, 0.0], [-1.0, 0.001, 0.0]])
    found = perpendicular_centre(places, axes)
    assert found.rule is CentreRule.NONE
    assert np.isnan(found.centre).all()
    # a third rod, which crosses both, brings it
    found = perpendicular_centre(np.vstack([places, [0, 2, 0]]), np.vstack([axes, [0, 1, 0]]))
    assert found.midpoints == 2
    np.testing.assert_allclose(found.centre, [0, 0, 0], atol=0.001)
