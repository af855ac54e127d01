"""How well the strips lie, place by place: what a section's sigma is made of."""

import numpy as np
import pytest

from pipeline.cable.closing import SharedMarks
from pipeline.cable.joint import JointOptions, adjust_ring
from pipeline.cable.joint_sections import SHAPES, shapes
from tests.cable import ring_scene, scene

PLACE_M, NOISE_PX = 0.09, 0.1
TURNED = np.radians(np.arange(-50, 51, 2.0))


def seen_by(marks, cameras):
    """The marks that two of the first so many cameras share."""
    kept = (marks.pairs < cameras).all(axis=1)
    rows = kept[marks.mark]
    return SharedMarks(
        block=marks.block[rows],
        frame=marks.frame[rows],
        mark=(np.cumsum(kept) - 1)[marks.mark[rows]],
        pixels=marks.pixels[rows],
        points=marks.points[kept],
        pairs=marks.pairs[kept],
    )


def adjusted(cameras, noise_px=NOISE_PX, seed=6):
    views = ring_scene.views()
    marks = ring_scene.marks(views, noise_px, seed + 1)
    blocks = ring_scene.blocks(views, noise_px, seed)[:cameras]
    options = JointOptions(sigma_px=NOISE_PX, shared_sigma_px=NOISE_PX, least_sigma_px=NOISE_PX)
    return adjust_ring(blocks, seen_by(marks, cameras), ring_scene.robot(), options, scene.silent)


def circle_gain(cameras):
    """Blocks, azimuths and gains of an even circle through all strips: twice the mean radius, centre free."""
    block = np.repeat(np.arange(cameras), len(TURNED))
    azimuth = np.tile(TURNED, cameras) + np.radians(90.0 * block)
    design = np.stack([np.ones_like(azimuth), np.cos(azimuth), np.sin(azimuth)], axis=1)
    return block, azimuth, 2 * np.linalg.pinv(design)[0]


def circle_mm(found, cameras):
    """The same circle through the strips' points as they were adjusted, smoothed by the same shapes."""
    block, azimuth, gain = circle_gain(cameras)
    radius = np.zeros_like(azimuth)
    for number in range(cameras):
        points = found.blocks[number].points
        points = points[np.abs(points[:, 1] - PLACE_M) < 0.02]
        turned = np.arctan2(-points[:, 2], points[:, 0]) - np.radians(90.0 * number)
        turned = np.angle(np.exp(1j * turned))
        radii = 1000 * np.hypot(points[:, 0], points[:, 2])
        best = np.linalg.lstsq(shapes(turned), radii, rcond=None)[0]
        radius[block == number] = shapes(azimuth[block == number] - np.radians(90.0 * number)) @ best
    return float(gain @ radius)


@pytest.mark.parametrize("cameras", [4, 3])
def test_sigma_predicts_the_scatter_of_repeated_surveys_with_and_without_a_gap(cameras):
    """What noise of the points themselves adds is small beside what moves the strips as a whole."""
    runs = [adjusted(cameras, seed=100 + 7 * k) for k in range(6)]
    scatter = np.std([circle_mm(r, cameras) for r in runs], ddof=1)
    sigma, lens = runs[0].strips.sigmas_mm(PLACE_M, *circle_gain(cameras))
    assert 0.4 < scatter / sigma < 2.5
    assert lens == 0.0


def test_a_camera_that_is_lost_costs_more_than_its_share():
    """Half as many again where only the number of points counted; the open ring turns about its seams."""
    whole, open_ring = (adjusted(n).strips.sigmas_mm(PLACE_M, *circle_gain(n))[0] for n in (4, 3))
    assert open_ring > 1.5 * whole


def test_all_places_and_strips_have_a_covariance():
    strips = adjusted(4).strips
    assert strips.strips_mm2.shape == (len(strips.y_m), 4 * SHAPES, 4 * SHAPES)
    for part in strips.strips_mm2:
        assert np.linalg.eigvalsh(part).min() > -1e-9 * np.trace(part)
    np.testing.assert_allclose(np.rad2deg(strips.azimuth), ring_scene.AZIMUTHS_DEG)
