"""Epipolar geometry: the paper's equations (7) to (11) and its Algorithm 1 on a synthetic pair."""

import numpy as np
import pytest

from pipeline.core import epipolar
from pipeline.core.errors import StageError
from pipeline.core.rotations import nominal_pose, rotation_from_vector
from pipeline.core.vocabulary import Lens, Poses, TravelDirection

LENS = Lens(
    width_px=960, height_px=600, focal_px=720.0, principal_point_px=(480.0, 300.0), division_lambda=0.0
)


def pair(count=300, noise_px=0.0, seed=0):
    """A general pair: 30 mm of travel with 3 degrees of turn, points on the front of a 110 mm cable."""
    rng = np.random.default_rng(seed)
    nominal = nominal_pose(0.0, 0.3, [0.0, 0.03], TravelDirection.RIGHT)
    turned = np.stack(
        [nominal.rotations[0], rotation_from_vector([0.02, -0.04, 0.03]) @ nominal.rotations[1]]
    )
    centres = nominal.centres + np.array([[0, 0, 0], [0.004, 0, -0.006]])
    poses = Poses(rotations=turned, translations=-np.einsum("nij,nj->ni", turned, centres))
    azimuth, y = rng.uniform(-1, 1, count), rng.uniform(-0.08, 0.11, count)
    points = np.column_stack([0.055 * np.cos(azimuth), y, -0.055 * np.sin(azimuth)])
    points *= rng.uniform(0.85, 1.15, (count, 1))  # off the cylinder, a critical surface otherwise
    pixels = []
    for R, t in zip(poses.rotations, poses.translations, strict=True):
        in_cam = points @ R.T + t
        pixels.append(
            720 * in_cam[:, :2] / in_cam[:, 2:] + [480, 300] + noise_px * rng.normal(size=(count, 2))
        )
    return poses, points, pixels


def angle_free(F):
    return F / np.linalg.norm(F) * np.sign(F.flat[np.argmax(np.abs(F))])


def test_f_from_known_orientation_annihilates_true_pairs():
    poses, _, (m1, m2) = pair()
    F = epipolar.fundamental_between(LENS, LENS, poses, 0, 1)
    np.testing.assert_allclose(epipolar.sampson_distances(F, m1, m2), 0, atol=1e-9)
    assert np.linalg.svd(F)[1][2] < 1e-12
    assert np.median(epipolar.sampson_distances(F, m1, m2[::-1])) > 10


def test_equation_9_carries_points_over_at_their_depth():
    poses, points, (m1, m2) = pair()
    K, (R1, R2), C = epipolar.calibration_matrix(LENS), poses.rotations, poses.centres
    A = epipolar.infinite_homography(K, K, R1, R2)
    e2 = epipolar.second_epipole(K, R2, C[0], C[1])
    depths = (points @ R1.T + poses.translations[0])[:, 2]
    np.testing.assert_allclose(epipolar.transfer(m1, A, e2, 1 / depths), m2, atol=1e-8)


def test_epipolar_lines_pass_through_partner_and_epipole():
    poses, _, (m1, m2) = pair()
    F = epipolar.fundamental_between(LENS, LENS, poses, 0, 1)
    lines = epipolar.epipolar_lines(F, m1)
    np.testing.assert_allclose(np.sum(lines * epipolar.homogeneous(m2), axis=1), 0, atol=1e-8)
    e1, e2 = epipolar.epipoles(F)
    np.testing.assert_allclose(F @ e1, 0, atol=1e-12)
    np.testing.assert_allclose(lines @ e2, 0, atol=1e-8)
    C = poses.centres
    expected = epipolar.second_epipole(epipolar.calibration_matrix(LENS), poses.rotations[1], C[0], C[1])
    np.testing.assert_allclose(np.cross(e2, expected / np.linalg.norm(expected)), 0, atol=1e-10)


def test_sampson_distance_is_the_distance_to_first_order():
    """Move true pairs by 0.01 px square to both epipolar lines at once: the distance is 0.01 sqrt(2)."""
    poses, _, (m1, m2) = pair()
    F = epipolar.fundamental_between(LENS, LENS, poses, 0, 1)
    l2, l1 = epipolar.epipolar_lines(F, m1), epipolar.epipolar_lines(F.T, m2)
    moved = epipolar.sampson_distances(F, m1 + 0.01 * l1[:, :2], m2 + 0.01 * l2[:, :2])
    slope1 = np.linalg.norm((epipolar.homogeneous(m2) @ F)[:, :2], axis=1)
    slope2 = np.linalg.norm((epipolar.homogeneous(m1) @ F.T)[:, :2], axis=1)
    np.testing.assert_allclose(moved, 0.01 * (slope1 + slope2) / np.hypot(slope1, slope2), rtol=1e-3)


def test_eight_point_is_exact_on_clean_pairs():
    poses, _, (m1, m2) = pair(40)
    known = epipolar.fundamental_between(LENS, LENS, poses, 0, 1)
    np.testing.assert_allclose(angle_free(epipolar.eight_point(m1, m2)), angle_free(known), atol=1e-8)


def test_estimate_agrees_with_known_orientation_despite_a_third_of_wrong_matches():
    poses, _, (m1, m2) = pair(600, noise_px=0.2)
    rng = np.random.default_rng(1)
    wrong = rng.choice(600, 200, replace=False)
    m2[wrong] += rng.uniform(-60, 60, (200, 2))
    found = epipolar.estimate_fundamental(m1, m2, epipolar.FundamentalOptions(noise_sigma=0.28, seed=5))
    right = np.setdiff1d(np.arange(600), wrong)
    assert found.inliers[right].mean() > 0.98
    assert found.inliers[wrong].mean() < 0.1  # some wrong matches lie on their epipolar line by chance
    assert 0.15 < found.rms < 0.25
    assert np.linalg.svd(found.F)[1][2] < 1e-12
    known = epipolar.fundamental_between(LENS, LENS, poses, 0, 1)
    _, _, (clean1, clean2) = pair(600)
    # on noise-free pairs the estimate is off by far less than the noise of one match
    assert np.sqrt(np.mean(epipolar.sampson_distances(found.F, clean1, clean2) ** 2)) < 0.06
    assert np.max(epipolar.sampson_distances(known, clean1, clean2)) < 1e-9


def test_minimising_sampson_distances_beats_the_eight_point_start():
    _, _, (m1, m2) = pair(200, noise_px=0.3)
    refined = epipolar.estimate_fundamental(m1, m2, epipolar.FundamentalOptions(noise_sigma=1.2))
    eight = epipolar.eight_point(m1, m2)
    cost = [np.sum(epipolar.sampson_distances(F, m1, m2) ** 2) for F in (refined.F, eight)]
    assert cost[0] < cost[1]


def test_same_seed_same_answer():
    _, _, (m1, m2) = pair(100, noise_px=0.3)
    first, again = (
        epipolar.estimate_fundamental(m1, m2, epipolar.FundamentalOptions(seed=3)) for _ in range(2)
    )
    np.testing.assert_array_equal(first.F, again.F)


def test_hopeless_matches_are_refused():
    with pytest.raises(StageError, match="7 pairs"):
        epipolar.estimate_fundamental(np.zeros((7, 2)), np.zeros((7, 2)))


def test_algorithm_1_reprojects_exactly_and_is_a_homography_away_from_the_truth():
    poses, points, (m1, m2) = pair(120)
    F = epipolar.fundamental_between(LENS, LENS, poses, 0, 1)
    found = epipolar.reconstruct_projective(F, m1, m2)
    np.testing.assert_allclose(found.residuals_px, 0, atol=1e-7)
    assert np.linalg.cond(found.P2[:, :3]) < 1e9
    np.testing.assert_allclose(found.P1, np.eye(4)[:3])
    homography = homography_between(found.points, np.column_stack([points, np.ones(120)]))
    mapped = found.points @ homography.T
    np.testing.assert_allclose(mapped[:, :3] / mapped[:, 3:], points, atol=1e-7)
    straight = homography_between(found.points, np.column_stack([points[::-1], np.ones(120)]))
    wrong = found.points @ straight.T
    assert np.median(np.abs(wrong[:, :3] / wrong[:, 3:] - points[::-1])) > 1e-3  # it is no accident


def test_algorithm_1_keeps_its_residual_at_the_noise():
    _, _, (m1, m2) = pair(200, noise_px=0.3)
    found = epipolar.reconstruct_projective(epipolar.estimate_fundamental(m1, m2).F, m1, m2)
    # one of a pair's four coordinates is redundant: rms residual = 0.3 sqrt(1 / 4)
    assert 0.12 < np.sqrt(np.mean(found.residuals_px**2)) < 0.18


def homography_between(source, target):
    """4 x 4 H with target ~ H source, by the linear method on homogeneous points (n, 4)."""
    rows = []
    for x, y in zip(source, target / np.linalg.norm(target, axis=1, keepdims=True), strict=True):
        for i in range(4):
            for j in range(i):
                row = np.zeros((4, 4))
                row[i], row[j] = y[j] * x, -y[i] * x
                rows.append(row.ravel())
    return np.linalg.svd(np.array(rows))[2][-1].reshape(4, 4)
