"""Where the ring of cameras was along the cable, how large it is, and how sure that is."""

import numpy as np
import pytest

from pipeline.cable.joint import JointOptions, adjust_ring
from tests.cable import ring_scene, scene


def path_of(views, noise_px=0.0, seed=6):
    blocks = ring_scene.blocks(views, noise_px, seed, count=250)
    marks = ring_scene.marks(views, noise_px, seed + 1)
    robot = ring_scene.robot()
    robot.body_sigmas[[0, -1], 4] = 1e-6  # the travel is exact: what is told of it is told apart
    return adjust_ring(blocks, marks, robot, JointOptions(), scene.silent).path


@pytest.fixture(scope="module")
def views():
    return ring_scene.views()


@pytest.fixture(scope="module")
def true_centres(views):
    return np.stack([v.poses.centres for v in views])


def test_without_noise_the_path_and_the_size_are_the_true_ones(views, true_centres):
    path = path_of(views)
    middle = true_centres.mean(axis=0)
    # where the middle stands on the robot is a matter of mountings: the same for all frames
    assert np.ptp(path.y_m - middle[:, 1]) < 2e-5
    true_m = np.sqrt(np.mean(np.sum((true_centres - middle) ** 2, axis=2)))
    assert path.size_m == pytest.approx(true_m, rel=1e-4)


def test_sigmas_tell_the_spread_over_noise(views):
    paths = [path_of(views, noise_px=0.1, seed=seed) for seed in range(12)]
    sizes = np.array([p.size_m for p in paths])
    assert sizes.std(ddof=1) / np.mean([p.size_sigma_m for p in paths]) == pytest.approx(1, abs=0.5)
    inner = np.array([p.y_m[5] - p.y_m[[0, -1]].mean() for p in paths])
    by = np.zeros(scene.FRAMES)
    by[[5, 0, -1]] = 1, -0.5, -0.5
    sigma = np.mean([np.sqrt(by @ p.covariance_m2 @ by) for p in paths])
    assert inner.std(ddof=1) / sigma == pytest.approx(1, abs=0.5)
