"""Functional model of the chessboard calibration: corners as a function of lens and poses, and a start.

Takes measured corners and the board; gives residuals with analytic derivatives for
:func:`pipeline.core.fits.robust.solve`.  Starting values after Z. Zhang, "A flexible new technique for camera
calibration", IEEE PAMI 22(11), 2000.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from pipeline.core.division import BEND_UNIT_PX, project_with_jacobian
from pipeline.core.errors import StageError
from pipeline.core.rotations import cross_matrix, rotation_from_vector, vector_from_rotation
from pipeline.core.vocabulary import Array


@dataclass(frozen=True, kw_only=True)
class BoardModel:
    """The adjustment; its values are (f, cx, cy, lambda), then rotation vector and translation a view.

    Attributes:
        corners_px: (v, n, 2) measured corners of v views, pixels.
        board: (n, 3) the corners on the board, z = 0.
        half_diagonal_px: unit of the radius that lambda belongs to.
    """

    corners_px: Array
    board: Array
    half_diagonal_px: float

    def start(self, width_px: int, height_px: int) -> Array:
        """Zhang's closed form with the principal point in the middle and no distortion."""
        centre = np.array([width_px / 2, height_px / 2])
        homographies = [_homography(self.board[:, :2], corners - centre) for corners in self.corners_px]
        focal = _focal(homographies, float(max(width_px, height_px)))
        values = [focal, *centre, 0.0]
        for H in homographies:
            values.extend(_pose(H, focal))
        return np.array(values)

    def update(self, values: Array, step: Array) -> Array:
        """Apply a step: rotations are turned on the left."""
        moved = values + step
        turns = rotation_from_vector(values[4:].reshape(-1, 6)[:, :3])
        turned = rotation_from_vector(step[4:].reshape(-1, 6)[:, :3]) @ turns
        moved[4:].reshape(-1, 6)[:, :3] = vector_from_rotation(turned)
        return moved

    def residuals(self, values: Array) -> tuple[Array, Array]:
        """Measured minus projected corners, pixels, and their Jacobian."""
        focal, cx, cy, division_lambda = values[:4]
        bend_per_lambda = (BEND_UNIT_PX / self.half_diagonal_px) ** 2
        lens = np.array([focal, cx, cy, division_lambda * bend_per_lambda])
        poses = values[4:].reshape(-1, 6)
        count = 2 * len(self.board)
        jacobian = np.zeros((len(poses) * count, len(values)))
        residuals = np.zeros(len(poses) * count)
        for i, (pose, corners) in enumerate(zip(poses, self.corners_px, strict=True)):
            turned = self.board @ rotation_from_vector(pose[:3]).T
            pixels, per_point, per_lens = project_with_jacobian(lens, turned + pose[3:])
            rows = slice(i * count, (i + 1) * count)
            residuals[rows] = (corners - pixels).ravel()
            per_lens[:, :, 3] *= bend_per_lambda
            jacobian[rows, :4] = -per_lens.reshape(count, 4)
            per_turn = per_point @ -cross_matrix(turned)
            per_pose = np.concatenate([per_turn, per_point], axis=2).reshape(count, 6)
            jacobian[rows, 4 + 6 * i : 10 + 6 * i] = -per_pose
        return residuals, jacobian


def _homography(board: Array, pixels: Array) -> Array:
    """(3, 3) from board to picture by the linear method on normalised points, scaled to H33 = 1."""
    H, _ = cv2.findHomography(board, pixels)
    if H is None:
        raise StageError("lens", "the corners of a board lie on a line", "take out that picture")
    return np.asarray(H, dtype=float)


def _focal(homographies: Sequence[Array], fallback: float) -> float:
    """Least squares over h1' w h2 = 0 and h1' w h1 = h2' w h2 with w = diag(1 / f^2, 1 / f^2, 1)."""
    left, right = [], []
    for H in homographies:
        a, b = H[:, 0], H[:, 1]
        scale = 1 / (a @ a + b @ b)
        left += [scale * (a[0] * b[0] + a[1] * b[1]), scale * (a[:2] @ a[:2] - b[:2] @ b[:2])]
        right += [-scale * a[2] * b[2], -scale * (a[2] ** 2 - b[2] ** 2)]
    inverse_square = float(np.dot(left, right) / max(np.dot(left, left), 1e-300))
    return inverse_square**-0.5 if inverse_square > 1e-12 else fallback


def _pose(H: Array, focal: float) -> tuple[float, ...]:
    """Rotation vector and translation of a board from its homography, in front of the camera."""
    a, b, t = (np.diag([1 / focal, 1 / focal, 1.0]) @ H).T
    scale = 2 / (np.linalg.norm(a) + np.linalg.norm(b)) * (1 if t[2] > 0 else -1)
    left, _, right = np.linalg.svd(np.stack([scale * a, scale * b, scale**2 * np.cross(a, b)], axis=1))
    R = left @ np.diag([1, 1, np.linalg.det(left @ right)]) @ right
    return (*vector_from_rotation(R), *(scale * t))
