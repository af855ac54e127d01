"""The Rodrigues matrix of equations (2) to (4) gives the least-squares motion, half turns included."""

import numpy as np
import pytest

from pipeline.core.errors import StageError
from pipeline.core.fits import fit_similarity
from pipeline.core.rotations import angle_between_deg, rotation_from_vector
from pipeline.steel.rodrigues import consensus, level_motion, rodrigues_matrix, rodrigues_motion

CORNERS = np.array([[3.0, 1, 0.2], [-4, 6, 1.1], [9, -2, 3.0], [5, 8, -0.5], [-7, -3, 2.2]])


def test_the_matrix_is_the_printed_one_up_to_the_sign_of_b():
    # the paper prints the Rodrigues matrix with b negated in row 1 and column 1
    a, b, c = 0.3, -0.5, 0.8
    printed_first_column = np.array([1 + a**2 - b**2 - c**2, 2 * c - 2 * a * b, 2 * b + 2 * a * c])
    R = rodrigues_matrix(np.array([a, -b, c])) * (1 + a**2 + b**2 + c**2)
    assert R[0, 0] == pytest.approx(printed_first_column[0])
    assert R[1, 0] == pytest.approx(printed_first_column[1])
    assert R[2, 0] == pytest.approx(printed_first_column[2])


@pytest.mark.parametrize("angle_deg", [0.0, 25.0, 119.0, 179.9999, 180.0])
@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 0, 1), (1, 2, -3)])
def test_without_noise_the_motion_is_exact_at_any_angle(angle_deg, axis):
    turn = np.radians(angle_deg) * np.array(axis) / np.linalg.norm(axis)
    R, t = rotation_from_vector(turn), np.array([40.0, -3.0, 7.0])
    rotation, translation = rodrigues_motion(CORNERS, CORNERS @ R.T + t)
    assert np.abs(rotation - R).max() < 1e-12
    assert np.abs(translation - t).max() < 1e-11


@pytest.mark.parametrize("seed", range(4))
def test_with_noise_it_is_the_least_squares_motion(seed):
    rng = np.random.default_rng(seed)
    R = rotation_from_vector(rng.normal(size=3) * 1.5)
    target = CORNERS @ R.T + rng.normal(size=3) + rng.normal(scale=0.2, size=CORNERS.shape)
    rotation, translation = rodrigues_motion(CORNERS, target)
    umeyama = fit_similarity(CORNERS, target, with_scale=False)
    assert angle_between_deg(rotation, umeyama.rotation) < 1e-6
    assert np.abs(translation - umeyama.translation).max() < 1e-8


def test_points_on_a_line_are_refused():
    line = np.outer([0.0, 1, 3], [1, 2, 0.5])
    with pytest.raises(StageError, match="lie on a line"):
        rodrigues_motion(line, line + 1)


def test_two_points_are_enough_for_plumb_stations():
    R, t = rotation_from_vector([0, 0, 2.5]), np.array([1.0, 2, 3])
    rotation, translation = level_motion(CORNERS[:2], CORNERS[:2] @ R.T + t)
    assert np.abs(rotation - R).max() < 1e-12
    assert np.abs(translation - t).max() < 1e-12
    with pytest.raises(StageError, match="above one another"):
        level_motion(np.array([[1.0, 2, 0], [1, 2, 5]]), np.array([[1.0, 2, 0], [1, 2, 5]]))


@pytest.mark.parametrize("level", [True, False])
def test_a_misnamed_point_stays_outside_the_consensus(level):
    R, t = rotation_from_vector([0, 0, -1.2]), np.array([5.0, 0, 1])
    target = CORNERS @ R.T + t
    target[3] = target[1] + 0.8
    rotation, translation, inside = consensus(CORNERS, target, 0.05, level=level)
    assert inside.tolist() == [True, True, True, False, True]
    assert np.abs(rotation - R).max() < 1e-9
    assert np.abs(translation - t).max() < 1e-9
