"""Where the ring of cameras was along the cable, how large it is, and how sure that is."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pipeline.cable.joint import JointOptions, adjust_ring
from pipeline.cable.joint_path import ring_path
from pipeline.core.rig import Rig
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


def test_place_and_size_follow_every_unknown_as_the_rig_itself_moves():
    """Three cameras, so that their middle is off the axis and turns with the body."""
    rng = np.random.default_rng(4)
    rotations = Rotation.from_rotvec(rng.normal(0, 0.3, (5, 3))).as_matrix()
    rig = Rig(
        body_rotations=rotations[:2],
        body_centres=rng.normal(0, 0.1, (2, 3)),
        mount_rotations=rotations[2:],
        mount_centres=0.3 * scene.out_of_cable(np.radians([0, 90, 180])) + rng.normal(0, 0.01, (3, 3)),
        lenses=np.tile([400.0, 160.0, 100.0, 0.0], (3, 1)),
        points=np.zeros((0, 3)),
    )

    def across(of):
        """Places of the middle along x and z, and how far the mean camera leans towards them."""
        centres = of.body_centres[:, None] + np.einsum("fji,cj->fci", of.body_rotations, of.mount_centres)
        turned = of.mount_rotations @ of.body_rotations[:, None]
        before = rig.mount_rotations @ rig.body_rotations[:, None]
        turn = Rotation.from_matrix((turned.swapaxes(-1, -2) @ before).reshape(-1, 3, 3)).as_rotvec()
        turn = turn.reshape(*turned.shape[:2], 3).mean(axis=1)  # of the whole, were it this that turned
        middle = centres.mean(axis=1)
        return np.array([[*middle[:, 0], *-turn[:, 2]], [*middle[:, 2], *turn[:, 0]]])

    def told(of):
        centres = of.body_centres[:, None] + np.einsum("fji,cj->fci", of.body_rotations, of.mount_centres)
        spread = centres - centres.mean(axis=1, keepdims=True)
        return centres[..., 1].mean(axis=1), np.sqrt(np.mean(np.sum(spread**2, axis=2), axis=1))[0]

    for unknown in range(rig.unknowns):
        step = np.zeros(rig.unknowns)
        step[unknown] = 1e-6
        there, here = (told(rig.moved(s, np.zeros((0, 3)))) for s in (step, -step))
        covariance = np.zeros((rig.unknowns, rig.unknowns))
        covariance[unknown, unknown] = 1.0
        path = ring_path(SimpleNamespace(rig=rig, covariance=covariance))
        assert np.sqrt(np.diag(path.covariance_m2)) == pytest.approx(
            np.abs(there[0] - here[0]) / 2e-6, abs=1e-6
        )
        assert path.size_sigma_m == pytest.approx(abs(there[1] - here[1]) / 2e-6, abs=1e-6)
        there, here = (across(rig.moved(s, np.zeros((0, 3)))) for s in (step, -step))
        towards = (there - here) / 2e-6
        assert path.across_covariance == pytest.approx(towards.T @ towards / 2, abs=1e-6)
    assert (path.y_m, path.size_m) == (pytest.approx(told(rig)[0]), pytest.approx(told(rig)[1]))
