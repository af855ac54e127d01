"""Spheres of photos and scans matched without names and without a scale; spheres found in a cloud."""

import numpy as np
import pytest

from pipeline.core.errors import StageError
from pipeline.steel.feature_match import match_spheres
from pipeline.steel.photo_spheres import find_spheres
from tests.steel.fused_scene import BALLS, SCALE, into_photo, surface


def spheres(rng, count):
    return np.column_stack([rng.uniform([0, 0, 0], [12, 8, 4], (count, 3)), np.full(count, 0.1)])


def in_photo(rng, site, noise):
    centres = site[:, :3] + rng.normal(0, noise, (len(site), 3))
    return np.column_stack([into_photo(centres), site[:, 3] / SCALE * rng.normal(1, 0.03, len(site))])


@pytest.mark.parametrize("seed", range(4))
def test_common_spheres_are_matched_among_strangers(seed):
    rng = np.random.default_rng(seed)
    site = spheres(rng, 30)
    order = rng.permutation(20)
    photo = np.concatenate([in_photo(rng, site[order], 0.006), in_photo(rng, spheres(rng, 8), 0.0)])
    best = match_spheres(photo, site, 0.15, 0.03, 4)[0]
    truth = best.photo < 20
    assert truth.sum() >= 19
    np.testing.assert_array_equal(best.scan[truth], order[best.photo[truth]])
    assert np.count_nonzero(~truth) <= 1
    assert best.placement.scale == pytest.approx(SCALE, rel=2e-3)


def test_a_square_grid_fits_in_four_ways():
    grid = np.stack(np.meshgrid(np.arange(3) * 3.0, np.arange(3) * 3.0, indexing="ij"), axis=-1).reshape(
        -1, 2
    )
    site = np.column_stack([grid, np.zeros(9), np.full(9, 0.1)])
    # seen from above only: mirror images are no rotations, but a flat grid may also be turned over
    found = match_spheres(in_photo(np.random.default_rng(0), site, 0.003), site, 0.15, 0.03, 9)
    assert len(found) == 8


def test_a_mirrored_structure_does_not_match():
    rng = np.random.default_rng(5)
    site = spheres(rng, 12)
    photo = in_photo(rng, site * [-1, 1, 1, 1], 0.001)
    with pytest.raises(StageError, match="lie to each other like"):
        match_spheres(photo, site, 0.15, 0.03, 6)


def test_spheres_on_a_line_and_too_few_are_refused():
    line = np.column_stack([np.arange(6.0), np.zeros(6), np.zeros(6), np.full(6, 0.1)])
    wide = spheres(np.random.default_rng(6), 6)
    with pytest.raises(StageError, match="lie on a line"):
        match_spheres(line, wide, 0.15, 0.03, 4)
    with pytest.raises(StageError, match="3 spheres in the photo cloud are too few"):
        match_spheres(wide[:3], wide, 0.15, 0.03, 4)


@pytest.mark.parametrize("unit", [1.0, 0.037])
def test_balls_are_found_in_a_cloud_of_any_unit(unit):
    rng = np.random.default_rng(7)
    points, normals = surface(rng, 240_000)
    seen = (normals[:, 2] > -0.3) & (points[:, 2] > 0.3)
    points, normals = points[seen], normals[seen]
    points = points + 0.003 * rng.normal(size=len(points))[:, None] * normals
    normals = normals + 0.1 * rng.normal(size=normals.shape)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    found = find_spheres(unit * points, normals, lambda: None) / unit
    away = np.linalg.norm(found[:, None, :3] - BALLS[None, :, :3], axis=2)
    assert np.all(away.min(axis=0) < 0.004)
    np.testing.assert_allclose(found[away.argmin(axis=0), 3], BALLS[:, 3], atol=0.003)
    assert np.all(away.min(axis=1) < 0.01)
