"""Epipolar geometry of two pictures: from known orientation, and what follows from a fundamental matrix.

Takes pinhole (undistorted) cameras and corresponding points; gives the fundamental matrix, epipolar lines,
distances and the projective reconstruction.  Also the door to the estimate of F from points alone
(:mod:`pipeline.core.fundamental`).

Image points are (n, 2), in pixels or as rays (then the calibration matrices are identities).  m2^T F m1 = 0.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pipeline.core.fundamental import (
    FundamentalEstimate,
    FundamentalOptions,
    eight_point,
    estimate_fundamental,
    homogeneous,
    sampson_distances,
)
from pipeline.core.rotations import cross_matrix
from pipeline.core.vocabulary import Array, Lens, Poses

__all__ = [
    "FundamentalEstimate",
    "FundamentalOptions",
    "ProjectiveReconstruction",
    "calibration_matrix",
    "eight_point",
    "epipolar_lines",
    "epipoles",
    "estimate_fundamental",
    "fundamental_between",
    "fundamental_from_orientation",
    "homogeneous",
    "infinite_homography",
    "reconstruct_projective",
    "sampson_distances",
    "second_epipole",
    "transfer",
]


def calibration_matrix(lens: Lens) -> Array:
    """K (3, 3) of the lens without its distortion."""
    cx, cy = lens.principal_point_px
    return np.array([[lens.focal_px, 0, cx], [0, lens.focal_px, cy], [0, 0, 1]])


def infinite_homography(K1: Array, K2: Array, cam1_from_world: Array, cam2_from_world: Array) -> Array:
    """A = K2 R2^T R1 K1^-1, equation (8), with the paper's R = (cam_from_world)^T; all (3, 3)."""
    return K2 @ cam2_from_world @ cam1_from_world.T @ np.linalg.inv(K1)


def second_epipole(K2: Array, cam2_from_world: Array, centre1: Array, centre2: Array) -> Array:
    """e2 = K2 R2^T (C1 - C2), equation (7): the first camera's centre seen by the second; homogeneous."""
    return K2 @ cam2_from_world @ (np.asarray(centre1) - np.asarray(centre2))


def fundamental_from_orientation(A: Array, e2: Array) -> Array:
    """F = [e2]x A, equation (11), scaled to Frobenius norm 1; (3, 3)."""
    F = cross_matrix(e2) @ A
    return F / np.linalg.norm(F)


def fundamental_between(lens1: Lens, lens2: Lens, poses: Poses, first: int, second: int) -> Array:
    """F (3, 3) between two of the poses, equations (7), (8) and (11), for undistorted pixels."""
    K1, K2 = calibration_matrix(lens1), calibration_matrix(lens2)
    R1, R2 = poses.rotations[first], poses.rotations[second]
    centres = poses.centres
    A = infinite_homography(K1, K2, R1, R2)
    return fundamental_from_orientation(A, second_epipole(K2, R2, centres[first], centres[second]))


def transfer(points1: ArrayLike, A: Array, e2: Array, inverse_depths: ArrayLike) -> Array:
    """Equation (9): m2 ~ A m1 + e2 / rho1 for depths rho1 in the first camera; (n, 2)."""
    mapped = homogeneous(points1) @ A.T + np.asarray(inverse_depths, dtype=float)[:, None] * e2
    return mapped[:, :2] / mapped[:, 2:]


def epipolar_lines(F: Array, points1: ArrayLike) -> Array:
    """Lines l2 = F m1 in the second picture, (n, 3), scaled so that l . (x, y, 1) is a distance."""
    lines = homogeneous(points1) @ F.T
    return lines / np.linalg.norm(lines[:, :2], axis=1, keepdims=True)


def epipoles(F: Array) -> tuple[Array, Array]:
    """(e1, e2), homogeneous unit vectors (3,): F e1 = 0 and F^T e2 = 0."""
    left, _, right = np.linalg.svd(F)
    return right[2], left[:, 2]


@dataclass(frozen=True, kw_only=True)
class ProjectiveReconstruction:
    """Scene up to a projective map of space, from two pictures without calibration.

    Attributes:
        points: (n, 4) homogeneous, unit length.
        P1, P2: (3, 4) camera matrices [I | 0] and [A | e2].
        residuals_px: (n,) root mean square reprojection error of each point over its four coordinates, in the
            unit of the points.
    """

    points: Array
    P1: Array
    P2: Array
    residuals_px: Array


def reconstruct_projective(F: Array, points1: ArrayLike, points2: ArrayLike) -> ProjectiveReconstruction:
    """Paper, Algorithm 1: projective reconstruction from a fundamental matrix and corresponding points.

    Step 3 leaves a vector a free.  [e2]x F has rank 2, its null vector is e1 and its columns are square to
    e2; adding e2 a^T with a along e1 supplies exactly the missing direction, so A is as regular as it gets.
    Before the linear equations of step 4, each pair of points is moved onto the epipolar relation (Sampson
    correction), so that noise does not decide which of the four equations are believed.
    """
    e1, e2 = epipoles(F)
    size = np.linalg.norm(F) / np.sqrt(2)
    P1 = np.hstack([np.eye(3), np.zeros((3, 1))])
    P2 = np.hstack([cross_matrix(e2) @ F + size * np.outer(e2, e1), e2[:, None]])
    corrected1, corrected2 = _onto_epipolar_relation(F, points1, points2)
    points = _intersected(P2, corrected1, corrected2)
    errors = [_pinhole(P, points) - np.asarray(m, float) for P, m in ((P1, points1), (P2, points2))]
    residuals = np.sqrt(np.mean(np.concatenate(errors, axis=1) ** 2, axis=1))
    return ProjectiveReconstruction(points=points, P1=P1, P2=P2, residuals_px=residuals)


def _intersected(P2: Array, first: Array, second: Array) -> Array:
    """Step 4 of Algorithm 1: rho1 m1 = [I | 0] M and rho2 m2 = P2 M, (n, 4) of unit length.

    The first says M ~ (m1, w); crossing the second with m2 removes rho2 and leaves one unknown w in three
    equations, which agree with each other because the pairs lie on the epipolar relation.
    """
    m1, m2 = homogeneous(first), homogeneous(second)
    from_ray, from_centre = np.cross(m2, m1 @ P2[:, :3].T), np.cross(m2, P2[:, 3])
    # M = (m1 s, w) with s from_ray + w from_centre = 0: no division, so that no depth is lost
    share = np.einsum("ni,ni->n", from_centre, from_centre)
    depth = -np.einsum("ni,ni->n", from_centre, from_ray)
    points = np.column_stack([m1 * share[:, None], depth])
    return points / np.linalg.norm(points, axis=1, keepdims=True)


def _pinhole(P: Array, points: Array) -> Array:
    mapped = points @ P.T
    return mapped[:, :2] / mapped[:, 2:]


def _onto_epipolar_relation(F: Array, points1: ArrayLike, points2: ArrayLike) -> tuple[Array, Array]:
    """Pairs moved by the Sampson correction, three times: Hartley and Zisserman 2003, section 12.4."""
    first, second = np.array(points1, dtype=float), np.array(points2, dtype=float)
    for _ in range(3):
        l2, l1 = homogeneous(first) @ F.T, homogeneous(second) @ F
        error = np.sum(homogeneous(second) * l2, axis=1)
        slope2 = np.sum(l1[:, :2] ** 2, axis=1) + np.sum(l2[:, :2] ** 2, axis=1)
        share = (error / np.maximum(slope2, 1e-300))[:, None]
        first, second = first - share * l1[:, :2], second - share * l2[:, :2]
    return first, second
