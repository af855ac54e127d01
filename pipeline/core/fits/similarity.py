"""Similarity transform between corresponding points."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pipeline.core.errors import StageError
from pipeline.core.fits.points import checked
from pipeline.core.rotations import cross_matrix
from pipeline.core.vocabulary import Array


@dataclass(frozen=True, kw_only=True)
class Similarity:
    """target = scale * rotation @ source + translation.

    Attributes:
        scale: 1 where it was held.
        rotation: (3, 3) target_from_source.
        translation: (3,).
        noise_sigma: standard deviation of one coordinate of weight 1, from the residuals.
        covariance: (7, 7) of (rotation vector on the left in radians, translation of the weighted centre,
            scale); the scale's row is zero where it was held.
        residuals: (n, 3), target minus transformed source.
    """

    scale: float
    rotation: Array
    translation: Array
    noise_sigma: float
    covariance: Array
    residuals: Array

    def apply(self, points_in_source: ArrayLike) -> Array:
        """(n, 3) points in the source frame to the target frame."""
        return self.scale * np.asarray(points_in_source, dtype=float) @ self.rotation.T + self.translation


def fit_similarity(
    source: ArrayLike, target: ArrayLike, weights: ArrayLike | None = None, *, with_scale: bool = True
) -> Similarity:
    """Least-squares similarity (or rigid motion) from (n, 3) source to (n, 3) target points.

    S. Umeyama, "Least-squares estimation of transformation parameters between two point patterns", IEEE PAMI
    13(4), 1991, equations (39) to (42), with weights.

    Raises:
        StageError: fewer than three points, points on a line, or shapes that differ.
    """
    x, weight = checked("similarity", source, weights, 3)
    y, _ = checked("similarity", target, weights, 3)
    if len(x) != len(y):
        raise StageError("fit", f"{len(x)} source and {len(y)} target points do not correspond", "give pairs")
    if np.count_nonzero(weight > 0) < 3:
        raise StageError("fit", "a similarity needs at least 3 pairs of points", "give more pairs")
    share = weight / weight.sum()
    x_centre, y_centre = share @ x, share @ y
    x_local, y_local = x - x_centre, y - y_centre
    left, singular, right = np.linalg.svd((y_local * share[:, None]).T @ x_local)
    if singular[1] <= 1e-12 * max(singular[0], 1e-300):
        raise StageError("fit", "the points of a similarity lie on a line", "give points off the line")
    signs = np.array([1.0, 1.0, np.sign(np.linalg.det(left) * np.linalg.det(right))])
    rotation = left * signs @ right
    variance = float(share @ np.sum(x_local**2, axis=1))
    scale = float(singular @ signs / variance) if with_scale else 1.0
    translation = y_centre - scale * rotation @ x_centre
    residuals = y - (scale * x @ rotation.T + translation)
    redundancy = 3 * np.count_nonzero(weight > 0) - (7 if with_scale else 6)
    noise = float(np.sqrt(np.sum(weight[:, None] * residuals**2) / redundancy)) if redundancy > 0 else 0.0
    covariance = noise**2 * _cofactor(scale * x_local @ rotation.T, x_local @ rotation.T, weight, with_scale)
    return Similarity(
        scale=scale,
        rotation=rotation,
        translation=translation,
        noise_sigma=noise,
        covariance=covariance,
        residuals=residuals,
    )


def _cofactor(turned: Array, per_scale: Array, weight: Array, with_scale: bool) -> Array:
    """Inverse normal matrix about the centre for (rotation, translation, scale)."""
    count = 7 if with_scale else 6
    jacobian = np.zeros((len(turned), 3, 7))
    jacobian[:, :, :3] = -cross_matrix(turned)
    jacobian[:, :, 3:6] = np.eye(3)
    jacobian[:, :, 6] = per_scale
    normal = np.einsum("n,nij,nik->jk", weight, jacobian, jacobian)[:count, :count]
    cofactor = np.zeros((7, 7))
    cofactor[:count, :count] = np.linalg.inv(normal)
    return cofactor
