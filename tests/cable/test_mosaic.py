"""Blocks that stand a little astray are joined to the cable they were cut from, and the ring closes."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import block_diag
from scipy.spatial.transform import Rotation

from pipeline.cable.mosaic import (
    MosaicOptions,
    PointPairs,
    lookup,
    mosaic_blocks,
    residuals_mm,
    surface_at,
)
from tests.cable import pieces, scene

TEXTURE = scene.Texture(seed=3)


@pytest.fixture(scope="module")
def astray():
    """Four blocks, each cut out of the cable by formula and standing up to half a millimetre off."""
    return pieces.ring(pieces.ASTRAY, texture=TEXTURE, noise_mm=0.03)[0]


@pytest.fixture(scope="module")
def joined(astray):
    return mosaic_blocks(astray, None, None, MosaicOptions(), scene.silent)


def truth(places):
    """Points of the true cable at (azimuth, y) (k, 2)."""
    points = scene.RADIUS_M * scene.out_of_cable(places[:, 0])
    points[:, 1] = places[:, 1]
    return points


def own(motion, points):
    """True points as a displaced block shows them."""
    R = Rotation.from_rotvec(np.radians(motion.turn_deg)).as_matrix()
    arms = points - pieces.MIDDLE - np.array(motion.shift_mm) / 1000
    return pieces.MIDDLE + arms @ R / motion.scale


def gaps_mm(mosaic, motions=pieces.ASTRAY):
    """How far marks that two neighbours share lie apart after joining, (neighbours, marks)."""
    y = np.linspace(0, pieces.TRAVEL_M, 9)
    found = []
    for first in range(4):
        second = (first + 1) % 4
        marks = truth(np.stack([np.full(9, np.radians(90 * first + 45)), y], axis=1))
        ends = [mosaic.placement.apply(n, own(motions[n], marks)) for n in (first, second)]
        found.append(1000 * np.linalg.norm(ends[0] - ends[1], axis=1))
    return np.array(found)


def radii_mm(mosaic, motions=pieces.ASTRAY):
    """Distance of the joined blocks' middle lines from their common axis."""
    y = np.linspace(0, pieces.TRAVEL_M, 9)
    lines = [
        mosaic.placement.apply(
            n, own(motions[n], truth(np.stack([np.full(9, np.radians(90.0 * n)), y], axis=1)))
        )
        for n in range(4)
    ]
    middle = np.mean(lines, axis=0)
    return 1000 * np.linalg.norm((np.array(lines) - middle)[..., [0, 2]], axis=2)


def standing_still(blocks):
    return mosaic_blocks(blocks, (), None, MosaicOptions(), scene.silent)


def test_before_joining_the_ring_gapes(astray):
    still = standing_still(astray)
    assert gaps_mm(still).min() > 0.2
    assert gaps_mm(still).max() < 3
    assert still.joins == ()
    np.testing.assert_allclose(still.placement.shifts, 0)


def test_the_ring_closes(joined):
    assert gaps_mm(joined).max() < 0.12
    assert np.median(gaps_mm(joined)) < 0.06


def test_the_joined_ring_has_the_right_diameter(astray, joined):
    """Scales were off by 0.1 %, shifts by half a millimetre: the mean over the ring is what the POS knows."""
    before = np.abs(radii_mm(standing_still(astray)) - 55).mean()
    after = radii_mm(joined)
    assert before > 0.15
    assert abs(after.mean() - 55) < 0.01
    assert np.ptp(after.mean(axis=1)) < 0.1


def test_all_four_neighbours_are_found_the_last_and_the_first_included(joined):
    assert [(j.first, j.second) for j in joined.joins] == [(0, 1), (0, 3), (1, 2), (2, 3)]
    for join in joined.joins:
        assert join.pairs > 20
        assert join.residual_mm.max() < 0.1
        assert 0 < join.surface_mm < 0.1


def test_one_pair_of_neighbours_is_held_together_to_a_micrometre(joined):
    for join in joined.joins:
        held = joined.placement.apply(join.first, join.held[0]) - joined.placement.apply(
            join.second, join.held[1]
        )
        assert np.linalg.norm(held) < 2e-6


@pytest.fixture(scope="module")
def by_single_points(astray):
    return mosaic_blocks(astray, None, None, MosaicOptions(single_point=True), scene.silent)


def test_single_points_hold_where_they_are_and_no_better_than_all_points_elsewhere(by_single_points, joined):
    """The paper's way: one pair of each two neighbours, then the surfaces as close as they go."""
    for join in by_single_points.joins:
        ends = [
            by_single_points.placement.apply(n, p)
            for n, p in zip((join.first, join.second), join.held, strict=True)
        ]
        assert np.linalg.norm(ends[0] - ends[1]) < 2e-6
    assert np.median(gaps_mm(joined)) < np.median(gaps_mm(by_single_points)) < 0.4


def test_pairs_given_by_hand_replace_the_automatic_ones(astray):
    def mark(first, second, azimuth_deg, y_m):
        marks = truth(np.array([[np.radians(azimuth_deg), y_m]]))
        ends = [own(pieces.ASTRAY[n], marks) for n in (first, second)]
        return PointPairs(first=first, second=second, points_first=ends[0], points_second=ends[1])

    given = (mark(0, 1, 45, 0.02), mark(1, 2, 135, 0.09), mark(2, 3, 225, 0.05))
    mosaic = mosaic_blocks(astray, given, None, MosaicOptions(), scene.silent)
    assert [(j.first, j.second, j.pairs) for j in mosaic.joins] == [(0, 1, 1), (1, 2, 1), (2, 3, 1)]
    for pair in given:
        ends = [
            mosaic.placement.apply(n, p)
            for n, p in ((pair.first, pair.points_first), (pair.second, pair.points_second))
        ]
        assert np.linalg.norm(ends[0] - ends[1]) < 2e-6


def test_of_several_pairs_given_by_hand_the_first_is_held(astray):
    marks = truth(np.array([[np.radians(45), 0.02], [np.radians(45), 0.06], [np.radians(46), 0.1]]))
    clumsy = own(pieces.ASTRAY[1], marks) + np.array([[0.3e-3, 0.2e-3, 0], [0, 0, 0], [0, 0, 0]])
    given = (PointPairs(first=0, second=1, points_first=own(pieces.ASTRAY[0], marks), points_second=clumsy),)
    join = mosaic_blocks(astray, given, None, MosaicOptions(), scene.silent).joins[0]
    np.testing.assert_array_equal(join.held, [given[0].points_first[0], clumsy[0]])


def test_a_block_that_shares_nothing_stays_where_the_pos_put_it(astray):
    stranger, _ = pieces.block(180.0, pieces.ASTRAY[2], texture=scene.Texture(seed=77))
    mosaic = mosaic_blocks((*astray[:2], stranger), None, None, MosaicOptions(), scene.silent)
    assert [(j.first, j.second) for j in mosaic.joins] == [(0, 1)]
    np.testing.assert_allclose(mosaic.placement.deviation()[2], 0, atol=1e-12)
    np.testing.assert_allclose(np.sqrt(np.diag(mosaic.covariance)[14:]), pieces.SIGMAS, rtol=1e-6)


def test_joining_makes_the_ring_better_known_than_its_blocks(joined):
    sigmas = np.sqrt(np.diag(joined.covariance)).reshape(4, 7)
    assert (sigmas < pieces.SIGMAS).all()
    common = np.tile(np.eye(7), (1, 4)) / 4
    as_one = np.sqrt(np.diag(common @ joined.covariance @ common.T))
    # four blocks with independent POS: the ring as one body is known half as well as one of them, at best
    np.testing.assert_allclose(as_one[3:6], pieces.SIGMAS[3:6] / 2, rtol=0.2)


def test_blocks_that_were_adjusted_together_stay_and_are_only_judged(astray):
    whole = pieces.ring(texture=TEXTURE)[0]
    settled = block_diag(*[np.diag(pieces.SIGMAS**2)] * 4) / 100
    for blocks, gap_mm in ((whole, 0.02), (astray, None)):
        mosaic = mosaic_blocks(blocks, None, settled, MosaicOptions(), scene.silent)
        np.testing.assert_array_equal(mosaic.placement.deviation(), 0)
        np.testing.assert_array_equal(mosaic.covariance, settled)
        assert len(mosaic.joins) == 4
        worst = max(float(j.residual_mm.max()) for j in mosaic.joins)
        assert worst < gap_mm if gap_mm else worst > 0.2


def test_progress_counts_the_pairs_of_blocks(astray):
    events = []
    mosaic_blocks(astray[:3], None, None, MosaicOptions(), events.append)
    assert [(e.stage, e.done, e.total) for e in events] == [("mosaic", k, 4) for k in range(3)]


def test_surface_points_are_looked_up_between_cells_and_a_turn_away(astray):
    block, _ = pieces.block(270.0)
    places = np.array([[np.radians(270.3), 0.0503], [np.radians(-60.2), 0.02], [np.radians(30.0), 0.05]])
    found = surface_at(block.surface, block.keep, places)
    np.testing.assert_allclose(found[:2], truth(places[:2]), atol=1e-7)
    assert np.isnan(found[2]).any()  # the other side of the cable
    cut = replace(block, keep=np.zeros_like(block.keep))
    assert np.isnan(surface_at(cut.surface, cut.keep, places)).any(axis=1).all()
    assert surface_at(block.surface, block.keep, np.zeros((0, 2))).shape == (0, 3)


def test_lookup_is_bilinear():
    block, _ = pieces.block(0.0)
    a, y = np.meshgrid(block.surface.azimuth, block.surface.y_m)
    places = np.radians([-30.0, 0.1, 44.4]), np.array([0.011, 0.052, 0.0999])
    found = lookup(block.surface, 3 * a + 2 * y, *places)
    np.testing.assert_allclose(found, 3 * places[0] + 2 * places[1], atol=1e-9)


def test_residuals_of_pairs_are_along_around_and_out_of_the_cable(astray):
    """At azimuth 90 degrees the cable's way out is -z, around is -x."""
    still = standing_still(astray).placement
    point = np.array([[0.0, 0.1, -0.055]])
    aside = point - np.array([[0.2e-3, 0.3e-3, 0.4e-3]])
    pairs = PointPairs(first=0, second=1, points_first=point, points_second=aside)
    np.testing.assert_allclose(
        np.abs(residuals_mm(pairs, still, MosaicOptions())), [[0.3, 0.2, 0.4]], atol=1e-9
    )
