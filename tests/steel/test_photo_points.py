"""Points from depth maps know how far they may be off: on even ground, and on a ball that windows flatten."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from pipeline.core.vocabulary import Lens, Poses
from pipeline.steel.photo_depth import DepthMap, grid_rays
from pipeline.steel.photo_points import points_of, share_behind
from pipeline.steel.photo_records import DepthOptions, OrientedPhotos

LENS = Lens(
    width_px=400, height_px=300, focal_px=400.0, principal_point_px=(200.0, 150.0), division_lambda=0.0
)
CENTRES = np.array([[-1.2, 0.0, 0.0], [0.0, 0.0, 0.0], [1.2, 0.0, 0.0]])
BALL, RADIUS, GROUND = np.array([0.0, 0.0, 4.0]), 0.2, 5.0
OPTIONS = DepthOptions(step_px=2, window_px=9)
WINDOW = 5


def true_depth(rays, centre):
    """Along z, of what each line of sight meets: the ball, or the ground behind it."""
    away, square = BALL - centre, np.sum(rays**2, axis=-1)
    along = rays @ away
    inside = along**2 - square * (away @ away - RADIUS**2)
    ball = (along - np.sqrt(np.maximum(inside, 0))) / square
    return np.where(inside > 0, ball, GROUND)


def flattened(depth, rng, noise_px):
    """As windows see it: the mean over a window, with what a correlation's peak is off by."""
    inverse = cv2.blur(1 / depth, (WINDOW, WINDOW)) + noise_px / LENS.focal_px / 1.2 * rng.normal(
        size=depth.shape
    )
    return (1 / inverse).astype(np.float32)


def plate_depth(rays, centre):
    """Along z: a square plate that faces the cameras, or the ground behind it."""
    met = BALL[2] * rays + centre
    return np.where(np.abs(met[..., :2]).max(axis=-1) < RADIUS, BALL[2], GROUND)


def fattened(depth, rng, noise_px):
    """As windows see an edge: half a window beyond it, what is nearer counts."""
    inverse = 1 / cv2.erode(depth, np.ones((WINDOW, WINDOW)))
    return (1 / (inverse + noise_px / LENS.focal_px / 1.2 * rng.normal(size=depth.shape))).astype(np.float32)


def cloud_of(true, seen):
    """Points of the middle of three photos, whose depth maps ``seen`` makes of the ``true`` depths."""
    rng = np.random.default_rng(1)
    rays = grid_rays(LENS, OPTIONS.step_px)
    maps = {}
    for number, centre in enumerate(CENTRES):
        depth = seen(true(rays, centre), rng, 0.06)
        others = tuple(k for k in range(3) if k != number)
        maps[number] = DepthMap(
            depth=depth, score=np.full(depth.shape, 0.9, dtype=np.float32), neighbours=others, step_px=2
        )
    photos = OrientedPhotos(
        files=tuple(Path(f"{k}.png") for k in range(3)),
        lens=LENS,
        poses=Poses(rotations=np.tile(np.eye(3), (3, 1, 1)), translations=-CENTRES),
        points=np.zeros((0, 3)),
        observations=np.zeros((0, 2), dtype=np.int64),
        pixels=np.zeros((0, 2)),
        left_out=(),
        reprojection_px=0.3,
    )
    return points_of(photos, maps, 1, np.zeros((300, 400, 3), dtype=np.uint8), OPTIONS)


@pytest.fixture(scope="module")
def cloud():
    return cloud_of(true_depth, flattened)


def along_rays(points):
    """Points less the truth along the middle photo's lines of sight, metres."""
    rays = points / points[:, 2:]
    return (points[:, 2] - true_depth(rays, np.zeros(3))) * np.linalg.norm(rays, axis=1)


def test_points_on_the_ball_are_off_as_far_as_they_say(cloud):
    aside = np.hypot(*(cloud.points[:, :2] / cloud.points[:, 2:]).T)
    on = aside < 0.75 * RADIUS / BALL[2]
    off, sigmas = along_rays(cloud.points[on]), cloud.sigmas[on]
    # flattened: their mean lies behind the ball's surface
    assert 0.003 < off.mean() < 0.02
    assert np.mean(np.abs(off) < 2 * sigmas) >= 0.9
    assert np.sqrt(np.mean(sigmas**2)) < 3 * np.sqrt(np.mean(off**2))


def test_points_on_the_ground_do_not_suffer_for_it(cloud):
    far = np.hypot(*(cloud.points[:, :2] / cloud.points[:, 2:]).T) > 1.5 * RADIUS / BALL[2]
    off, sigmas = along_rays(cloud.points[far]), cloud.sigmas[far]
    assert np.mean(np.abs(off) < 2 * sigmas) >= 0.9
    assert np.median(sigmas) < 3 * 1.4826 * np.median(np.abs(off))


def test_points_beside_an_edge_that_have_its_depth_know_how_far_they_may_be_off():
    cloud = cloud_of(plate_depth, fattened)
    rays = cloud.points / cloud.points[:, 2:]
    ground = plate_depth(rays, np.zeros(3)) == GROUND
    hover = ground & (cloud.points[:, 2] < 0.5 * (GROUND + BALL[2]))
    past_m = np.abs(cloud.points[hover, :2]).max(axis=1) - RADIUS
    assert hover.sum() > 50
    assert 0.01 < np.median(past_m) < 0.06
    assert np.mean(past_m < 2 * cloud.sigmas[hover]) >= 0.9
    # the ground's own points beside them are as good as those far from the plate
    own = ground & (cloud.points[:, 2] > 0.98 * GROUND)
    beside = own & (np.abs(rays[:, :2]).max(axis=1) < 1.5 * RADIUS / BALL[2])
    assert beside.sum() > 50
    assert np.median(cloud.sigmas[beside]) < 1.5 * np.median(cloud.sigmas[own & ~beside])


def test_only_what_lies_behind_counts_and_the_unknown_counts_as_the_farthest_beside_it():
    depth = np.full((40, 60), 5.0)
    depth[:, :30] = 4.0
    valid = np.ones(depth.shape, dtype=bool)
    share = share_behind(depth, valid)[20]
    assert share[29] == pytest.approx(2 / 5)
    assert share[28] == pytest.approx(1 / 5)
    assert not share[:28].any()
    assert not share[30:].any()
    holes = valid.copy()
    holes[:, 29:32] = False  # between near and far: cells of the near side may be behind
    holes[:, 45:48] = False  # on even ground: of no matter
    share = share_behind(depth, holes)[20]
    assert share[28] == pytest.approx(2 / 5)
    assert not share[32:].any()
