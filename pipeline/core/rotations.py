"""Rotations: vectors and matrices, the POS angles, and the nominal poses of the robot's cameras.

All functions work on n rotations at once.  A rotation vector is axis times angle in radians.
The POS angles of a frame turn the camera about its own axes (x right, y down, z forward), right-handed:
world_from_cam = nominal_world_from_cam * Ry(yaw) * Rx(pitch) * Rz(roll).  They are kept in the order of the
POS file: pitch, yaw, roll.
"""

from math import cos, radians, sin

import numpy as np
from numpy.typing import ArrayLike

from pipeline.core.vocabulary import Array, Poses, TravelDirection


def cross_matrix(vectors: ArrayLike) -> Array:
    """Skew-symmetric [a]x of (..., 3) vectors, paper equation (10): [a]x v = a x v; (..., 3, 3)."""
    a = np.asarray(vectors, dtype=float)
    zero = np.zeros(a.shape[:-1])
    rows = [
        np.stack([zero, -a[..., 2], a[..., 1]], axis=-1),
        np.stack([a[..., 2], zero, -a[..., 0]], axis=-1),
        np.stack([-a[..., 1], a[..., 0], zero], axis=-1),
    ]
    return np.stack(rows, axis=-2)


def rotation_from_vector(vectors: ArrayLike) -> Array:
    """Rodrigues' formula: (..., 3) rotation vectors, radians, to (..., 3, 3) rotation matrices."""
    v = np.asarray(vectors, dtype=float)
    angle = np.linalg.norm(v, axis=-1)[..., None, None]
    skew = cross_matrix(v)
    # np.sinc(x) = sin(pi x) / (pi x) is smooth at zero, and (1 - cos a) / a^2 = sinc^2(a / 2) / 2
    return np.eye(3) + np.sinc(angle / np.pi) * skew + 0.5 * np.sinc(angle / (2 * np.pi)) ** 2 * (skew @ skew)


def vector_from_rotation(rotations: ArrayLike) -> Array:
    """(..., 3, 3) rotation matrices to (..., 3) rotation vectors of at most pi radians.

    By way of the quaternion whose largest component is taken first, so that no angle, pi included, is lost.
    """
    R = np.asarray(rotations, dtype=float)
    flat = R.reshape(-1, 3, 3)
    xx, yy, zz = flat[:, 0, 0], flat[:, 1, 1], flat[:, 2, 2]
    s01, s02, s12 = (flat[:, i, j] + flat[:, j, i] for i, j in ((0, 1), (0, 2), (1, 2)))
    dx, dy, dz = flat[:, 2, 1] - flat[:, 1, 2], flat[:, 0, 2] - flat[:, 2, 0], flat[:, 1, 0] - flat[:, 0, 1]
    # each row is the quaternion (w, x, y, z) times 4 of its own pivot
    rows = np.array(
        [
            [1 + xx + yy + zz, dx, dy, dz],
            [dx, 1 + xx - yy - zz, s01, s02],
            [dy, s01, 1 - xx + yy - zz, s12],
            [dz, s02, s12, 1 - xx - yy + zz],
        ]
    )
    pivot = np.argmax(rows[np.arange(4), np.arange(4)], axis=0)
    q = rows[pivot, :, np.arange(len(flat))]
    q = q / np.linalg.norm(q, axis=1, keepdims=True)
    q = np.where(q[:, :1] < 0, -q, q)
    half_sine = np.linalg.norm(q[:, 1:], axis=1)
    angle = 2 * np.arctan2(half_sine, q[:, 0])
    factor = np.where(half_sine > 1e-12, angle / np.maximum(half_sine, 1e-12), 2.0)
    return (factor[:, None] * q[:, 1:]).reshape(R.shape[:-1])


def angle_between_deg(first: ArrayLike, second: ArrayLike) -> Array:
    """Angle of the rotation from ``first`` to ``second``, (..., 3, 3) each; (...,) degrees in [0, 180]."""
    between = np.swapaxes(np.asarray(first, dtype=float), -1, -2) @ np.asarray(second, dtype=float)
    return np.degrees(np.linalg.norm(vector_from_rotation(between), axis=-1))


def deviation_from_pos_angles(angles_deg: ArrayLike) -> Array:
    """(..., 3) POS angles (pitch, yaw, roll), degrees, to Ry(yaw) Rx(pitch) Rz(roll), (..., 3, 3)."""
    pitch, yaw, roll = np.moveaxis(np.radians(np.asarray(angles_deg, dtype=float)), -1, 0)
    x_axis, y_axis, z_axis = np.eye(3)
    about_y = rotation_from_vector(yaw[..., None] * y_axis)
    about_x = rotation_from_vector(pitch[..., None] * x_axis)
    return about_y @ about_x @ rotation_from_vector(roll[..., None] * z_axis)


def pos_angles_from_deviation(deviations: ArrayLike) -> Array:
    """(..., 3, 3) deviations nominal_cam_from_cam to (..., 3) POS angles (pitch, yaw, roll) in degrees.

    Pitch lies in [-90, 90]; at its ends yaw and roll turn about the same axis and only their sum is defined.
    """
    D = np.asarray(deviations, dtype=float)
    pitch = -np.arcsin(np.clip(D[..., 1, 2], -1, 1))
    yaw = np.arctan2(D[..., 0, 2], D[..., 2, 2])
    roll = np.arctan2(D[..., 1, 0], D[..., 1, 1])
    return np.degrees(np.stack([pitch, yaw, roll], axis=-1))


def nominal_cam_from_world(azimuth_deg: float, travel: TravelDirection) -> Array:
    """Attitude (3, 3) of a camera at the azimuth that looks square at the axis, travel as in the image."""
    a = radians(azimuth_deg)
    forward = np.array([-cos(a), 0.0, sin(a)])
    along = np.array([0.0, 1.0, 0.0])
    match travel:
        case TravelDirection.RIGHT:
            right = along
        case TravelDirection.LEFT:
            right = -along
        case TravelDirection.DOWN:
            right = np.cross(along, forward)
        case TravelDirection.UP:
            right = np.cross(-along, forward)
    return np.stack([right, np.cross(forward, right), forward])


def nominal_pose(azimuth_deg: float, standoff_m: float, y_m: ArrayLike, travel: TravelDirection) -> Poses:
    """Poses of a camera that travels along the cable without sway.

    Args:
        azimuth_deg: place of the camera around the axis, right-hand rule about +y.
        standoff_m: distance from the projection centre to the axis.
        y_m: (n,), metres along the axis, one a frame.
        travel: image direction of +y.
    """
    a, y = radians(azimuth_deg), np.atleast_1d(np.asarray(y_m, dtype=float))
    centres = np.stack(
        [np.full_like(y, standoff_m * cos(a)), y, np.full_like(y, -standoff_m * sin(a))], axis=1
    )
    return poses_from_centres(np.tile(nominal_cam_from_world(azimuth_deg, travel), (len(y), 1, 1)), centres)


def poses_from_centres(cam_from_world_rotations: Array, centres: Array) -> Poses:
    """Poses with the given attitudes (n, 3, 3) and projection centres (n, 3), metres."""
    translations = -np.einsum("nij,nj->ni", cam_from_world_rotations, centres)
    return Poses(rotations=cam_from_world_rotations, translations=translations)
