"""Straight line in the plane, by orthogonal distances."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pipeline.core.fits.points import checked
from pipeline.core.fits.robust import FitOptions, solve
from pipeline.core.vocabulary import Array


@dataclass(frozen=True, kw_only=True)
class Line2D:
    """Line normal . p = offset.

    Attributes:
        normal: (2,) unit normal.
        offset: distance from the origin along the normal.
        covariance: (2, 2) of (angle of the normal in radians, distance at ``centre``).
        centre: (2,) weighted centre of the points' feet, on the line.
        rms: root mean square of the distances, robustly weighted.
        robust_weights: (n,) in [0, 1].
    """

    normal: Array
    offset: float
    covariance: Array
    centre: Array
    rms: float
    robust_weights: Array

    def distances(self, points: ArrayLike) -> Array:
        """Signed distances of (n, 2) points."""
        return np.asarray(points, dtype=float) @ self.normal - self.offset


def fit_line(
    points: ArrayLike, weights: ArrayLike | None = None, options: FitOptions | None = None
) -> Line2D:
    """Fit a line to (n, 2) points by orthogonal distances.

    Raises:
        StageError: fewer than two distinct points.
    """
    xy, weight = checked("line", points, weights, 2)
    centre = np.average(xy, axis=0, weights=weight) if weight.sum() > 0 else np.full(2, np.nan)
    local = xy - centre
    start = np.array([_normal_angle(local, weight), 0.0])

    def residuals(values: Array) -> tuple[Array, Array]:
        sine, cosine = np.sin(values[0]), np.cos(values[0])
        distance = local @ [cosine, sine] - values[1]
        return distance, np.column_stack([local @ [-sine, cosine], -np.ones(len(local))])

    found = solve("line", residuals, start, weights=weight, options=options or FitOptions())
    normal = np.array([np.cos(found.values[0]), np.sin(found.values[0])])
    total = weight * found.robust_weights
    return Line2D(
        normal=normal,
        offset=float(found.values[1] + normal @ centre),
        covariance=found.covariance,
        centre=centre + found.values[1] * normal,
        rms=float(np.sqrt(np.average(found.residuals**2, weights=total))),
        robust_weights=found.robust_weights,
    )


def _normal_angle(local: Array, weight: Array) -> float:
    """Start: direction of least scatter, by closed form of the 2 x 2 eigenproblem."""
    xx, yy = weight @ local[:, 0] ** 2, weight @ local[:, 1] ** 2
    xy = weight @ (local[:, 0] * local[:, 1])
    return float(0.5 * np.arctan2(2 * xy, xx - yy) + np.pi / 2)
