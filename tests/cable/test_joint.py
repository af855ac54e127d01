"""The ring adjusted together keeps the scale, closes, sees the focal lengths, and knows how sure it is."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.cable.joint import JointOptions, adjust_ring
from pipeline.core.fits.circle import fit_circle
from tests.cable import ring_scene, scene


def adjust(views, *, blocks=None, marks=None, noise_px=0.0, seed=6, options=None, emit=scene.silent):
    return adjust_ring(
        blocks or ring_scene.blocks(views, noise_px, seed),
        marks or ring_scene.marks(views, noise_px, seed + 1),
        ring_scene.robot(),
        options or JointOptions(),
        emit,
    )


def diameters_mm(found, places=(0.05, 0.09, 0.13)):
    points = 1000 * np.concatenate([b.points for b in found.blocks])
    cuts = [points[np.abs(points[:, 1] - 1000 * y) < 20][:, [0, 2]] for y in places]
    return np.array([2 * fit_circle(cut).radius for cut in cuts])


def scale_errors(found, views):
    return np.array(
        [
            np.polyfit(v.poses.centres[:, 1], (b.poses.centres - v.poses.centres)[:, 1], 1)[0]
            for b, v in zip(found.blocks, views, strict=True)
        ]
    )


@pytest.fixture(scope="module")
def views():
    return ring_scene.views()


@pytest.fixture(scope="module")
def exact(views):
    return adjust(views)


@pytest.fixture(scope="module")
def noisy(views):
    return adjust(views, noise_px=0.1)


def test_the_scale_is_that_of_the_travel_in_every_block(exact, views):
    """Without noise only the priors pull, by far less than their own millimetres over the travel."""
    assert np.abs(scale_errors(exact, views)).max() < 1e-4


def test_the_diameter_is_right_though_every_camera_stood_elsewhere(exact):
    assert np.abs(diameters_mm(exact) - 2000 * scene.RADIUS_M).max() < 0.01


def test_noise_of_a_tenth_of_a_pixel_costs_about_a_tenth_of_a_pixel(noisy):
    """A pixel is 0.6 mm on this surface."""
    errors = np.abs(diameters_mm(noisy) - 2000 * scene.RADIUS_M)
    assert 1e-5 < errors.max() < 0.1
    assert 0.05 < noisy.blocks[0].reprojection_px < 0.2


def test_calibrated_lenses_are_held(noisy, views):
    assert all(b.lens == v.lens for b, v in zip(noisy.blocks, views, strict=True))
    assert noisy.lens_sigma_mm.max() == 0.0


def test_focal_length_and_lambda_are_found_from_five_percent_off(views):
    true = views[0].lens
    stated = replace(
        true, focal_px=1.05 * true.focal_px, focal_sigma_px=0.03 * true.focal_px, division_lambda=-0.04
    )
    stated = replace(stated, lambda_sigma=0.02)
    blocks = ring_scene.blocks(views, 0.05, 6, lens=stated)
    found = adjust(views, blocks=blocks, marks=ring_scene.marks(views, 0.05))
    for block in found.blocks:
        error = block.lens.focal_px / true.focal_px - 1
        assert abs(error) < 0.01
        assert abs(error) < 4 * block.lens.focal_sigma_px / true.focal_px
        assert 0 < block.lens.focal_sigma_px < 0.02 * true.focal_px
        assert abs(block.lens.division_lambda - true.division_lambda) < 0.004
    assert np.abs(diameters_mm(found) - 2000 * scene.RADIUS_M).max() < 0.15
    assert found.lens_sigma_mm.min() > 0


def test_marks_that_neighbours_share_make_the_diameter_surer(views):
    alone = adjust(views, marks=ring_scene.no_marks(), noise_px=0.1)
    tied = adjust(views, noise_px=0.1)
    assert tied.diameter_sigma_mm.max() < 0.7 * alone.diameter_sigma_mm.max()
    assert alone.shared_residual_px == 0.0
    assert 0.05 < tied.shared_residual_px < 0.3


@pytest.mark.parametrize("readout_m", [0.004, -0.0025])
def test_a_rolling_shutter_is_found_and_the_diameter_is_right(views, readout_m):
    """The marks of all seams are off by the same; held to a global shutter the ring does not close."""
    measured = {
        "blocks": ring_scene.blocks(views, 0.1, readout_m=readout_m),
        "marks": ring_scene.marks(views, 0.1, readout_m=readout_m),
    }
    found = adjust(views, **measured)
    assert 0 < found.readout_sigma_mm < 0.1
    assert abs(found.readout_mm - 1000 * readout_m) < 3 * found.readout_sigma_mm
    assert all(block.poses.readout_m == found.readout_mm / 1000 for block in found.blocks)
    assert all(0.05 < block.reprojection_px < 0.2 for block in found.blocks)
    for block, start in zip(found.blocks, measured["blocks"], strict=True):
        # points lie where they are, not where a frame of one moment would have them, but for a roll of the
        # mounting, of 0.2 degrees sigma: 0.16 mm at the limb, which is 0.35 of the height from the middle
        rows = block.pixels[:, 1] / scene.HEIGHT_PX - 0.5
        off_m = (block.points - start.orientation.points)[block.point, 1]
        assert abs(np.polyfit(rows, off_m, 1)[0]) < 2 * 0.00016 / 0.35
    held = adjust(views, **measured, options=JointOptions(readout_sigma_mm=0))
    assert held.readout_mm == held.readout_sigma_mm == 0.0
    assert held.shared_residual_px > 3 * found.shared_residual_px


def test_sigma_predicts_the_scatter_of_repeated_surveys(views):
    """The same way again with other noise: what scatters is what sigma says, within a factor of two."""
    options = JointOptions(sigma_px=0.1, shared_sigma_px=0.1)
    runs = [adjust(views, noise_px=0.1, seed=100 + 7 * k, options=options) for k in range(8)]
    scatter = np.sqrt(np.mean((np.array([diameters_mm(r) for r in runs]) - 2000 * scene.RADIUS_M) ** 2))
    places = np.interp([0.05, 0.09, 0.13], runs[0].section_y_m, runs[0].diameter_sigma_mm)
    assert 0.5 < scatter / np.sqrt(np.mean(places**2)) < 2.0


def test_gross_errors_do_not_reach_the_result(views):
    blocks = ring_scene.blocks(views)
    first = blocks[0].orientation
    bad = np.random.default_rng(3).random(len(first.pixels)) < 0.03
    pixels = first.pixels + np.where(bad[:, None], 12.0, 0.0)
    blocks = (replace(blocks[0], orientation=replace(first, pixels=pixels)), *blocks[1:])
    found = adjust(views, blocks=blocks)
    assert np.abs(diameters_mm(found) - 2000 * scene.RADIUS_M).max() < 0.02
    assert len(found.blocks[0].pixels) < len(first.pixels) - 0.9 * bad.sum()


def test_progress_stays_within_its_total(views):
    events = []
    adjust(views, emit=events.append)
    assert len(events) > 2
    assert all(e.stage == "joint" and 0 <= e.done < e.total for e in events)
