"""A ring in another scale sees the same pictures, and is as sure of its shape."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.cable.joint import JointOptions, adjust_ring
from pipeline.segments.scaling import scaled_ring
from tests.cable import ring_scene, scene

SCALE = 1.25


@pytest.fixture(scope="module")
def ring():
    views = ring_scene.views(division_lambda=-0.05)
    blocks = ring_scene.blocks(views, noise_px=0.02, count=300)
    return adjust_ring(
        blocks, ring_scene.marks(views, 0.02), ring_scene.robot(), JointOptions(), scene.silent
    )


def seen(view, block, frame):
    """Pixels of the block's points, through the scene's own camera put where the block says."""
    return replace(view, poses=block.poses).project(frame, block.points[:50])


def test_every_camera_sees_the_same(ring):
    larger = scaled_ring(ring, SCALE)
    for view, one, other in zip(
        ring_scene.views(division_lambda=-0.05), ring.blocks, larger.blocks, strict=True
    ):
        assert other.poses.centres == pytest.approx(SCALE * one.poses.centres)
        for frame in (0, 5):
            assert seen(view, other, frame) == pytest.approx(seen(view, one, frame), abs=1e-6)


def test_lengths_and_their_sigmas_grow_and_angles_stay(ring):
    larger = scaled_ring(ring, SCALE)
    for name in ("section_y_m", "diameter_sigma_mm", "lens_sigma_mm", "readout_mm", "readout_sigma_mm"):
        assert getattr(larger, name) == pytest.approx(SCALE * getattr(ring, name))
    ratio = np.sqrt(np.diag(larger.covariance) / np.diag(ring.covariance)).reshape(-1, 7)
    assert ratio == pytest.approx(np.tile([1, 1, 1, SCALE, SCALE, SCALE, 1], (len(ratio), 1)))
    assert larger.shared_residual_px == ring.shared_residual_px
    assert larger.path.size_m == pytest.approx(SCALE * ring.path.size_m)
    assert larger.path.size_sigma_m / larger.path.size_m == pytest.approx(
        ring.path.size_sigma_m / ring.path.size_m
    )
    middle, turned = 0.1, np.linspace(-1, 1, 9)
    told = [
        r.strips.sigmas_mm(s * middle, np.zeros(9, int), turned, np.full(9, 2 / 9))
        for r, s in ((ring, 1), (larger, SCALE))
    ]
    assert told[1] == pytest.approx(SCALE * np.array(told[0]))


def test_back_again_is_where_it_was(ring):
    back = scaled_ring(scaled_ring(ring, SCALE), 1 / SCALE)
    for one, other in zip(ring.blocks, back.blocks, strict=True):
        assert other.points == pytest.approx(one.points, abs=1e-12)
        assert other.datum_information == pytest.approx(one.datum_information)
