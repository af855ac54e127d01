"""Rotations: against scipy, and against the contract's words about the camera's attitude."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pipeline.core import rotations
from pipeline.core.vocabulary import TravelDirection


def random_vectors(count=50, seed=0):
    rng = np.random.default_rng(seed)
    axes = rng.normal(size=(count, 3))
    return axes / np.linalg.norm(axes, axis=1, keepdims=True) * rng.uniform(0, np.pi - 1e-6, (count, 1))


def test_rodrigues_agrees_with_scipy_also_near_zero_and_pi():
    axis = np.array([[0.6, -0.48, 0.64]])
    vectors = np.concatenate([random_vectors(), np.zeros((1, 3)), 1e-9 * axis, (np.pi - 1e-9) * axis])
    matrices = rotations.rotation_from_vector(vectors)
    np.testing.assert_allclose(matrices, Rotation.from_rotvec(vectors).as_matrix(), atol=1e-12)
    np.testing.assert_allclose(rotations.vector_from_rotation(matrices), vectors, atol=1e-9)


def test_half_a_turn_is_kept():
    for axis in np.eye(3):
        vector = rotations.vector_from_rotation(rotations.rotation_from_vector(np.pi * axis))
        np.testing.assert_allclose(np.abs(vector), np.pi * axis, atol=1e-9)


def test_single_rotation_and_stacks_have_their_own_shapes():
    assert rotations.rotation_from_vector(np.zeros(3)).shape == (3, 3)
    assert rotations.vector_from_rotation(np.eye(3)).shape == (3,)
    assert rotations.rotation_from_vector(np.zeros((2, 4, 3))).shape == (2, 4, 3, 3)


def test_cross_matrix_is_the_vector_product():
    a, v = random_vectors(5), random_vectors(5, seed=1)
    np.testing.assert_allclose(
        np.einsum("nij,nj->ni", rotations.cross_matrix(a), v), np.cross(a, v), atol=1e-14
    )


def test_angle_between_two_attitudes():
    first = rotations.rotation_from_vector(random_vectors(4))
    turn = rotations.rotation_from_vector(np.radians(7.0) * np.array([0.6, 0.0, 0.8]))
    np.testing.assert_allclose(rotations.angle_between_deg(first, first @ turn), 7.0, atol=1e-10)


def test_pos_angles_turn_yaw_then_pitch_then_roll_about_the_cameras_own_axes():
    pitch, yaw, roll = 2.0, -3.0, 5.0
    expected = Rotation.from_euler("YXZ", [yaw, pitch, roll], degrees=True).as_matrix()
    np.testing.assert_allclose(rotations.deviation_from_pos_angles([pitch, yaw, roll]), expected, atol=1e-14)


def test_pos_angles_come_back():
    angles = np.random.default_rng(1).uniform(-80, 80, (40, 3))
    deviations = rotations.deviation_from_pos_angles(angles)
    np.testing.assert_allclose(rotations.pos_angles_from_deviation(deviations), angles, atol=1e-9)


@pytest.mark.parametrize("azimuth_deg", [0.0, 90.0, 200.0])
@pytest.mark.parametrize("travel", list(TravelDirection))
def test_nominal_camera_looks_at_the_axis_and_sees_the_travel_in_its_direction(azimuth_deg, travel):
    poses = rotations.nominal_pose(azimuth_deg, 0.3, [0.1, 0.2], travel)
    a = np.radians(azimuth_deg)
    np.testing.assert_allclose(poses.centres[1], [0.3 * np.cos(a), 0.2, -0.3 * np.sin(a)], atol=1e-14)
    assert np.linalg.det(poses.rotations) == pytest.approx(1.0)

    def in_image(point):
        x, y, z = poses.rotations[1] @ point + poses.translations[1]
        assert z > 0
        return np.array([x, y]) / z

    np.testing.assert_allclose(in_image([0.0, 0.2, 0.0]), 0, atol=1e-14)
    ahead = in_image([0.0, 0.23, 0.0])
    image_direction = {"right": (1, 0), "left": (-1, 0), "down": (0, 1), "up": (0, -1)}[travel]
    np.testing.assert_allclose(ahead, 0.1 * np.array(image_direction), atol=1e-14)
