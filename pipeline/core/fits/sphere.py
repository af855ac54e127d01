"""Sphere, by orthogonal distances."""

from dataclasses import dataclass
from math import sqrt

import numpy as np
from numpy.typing import ArrayLike

from pipeline.core.errors import StageError
from pipeline.core.fits.points import checked
from pipeline.core.fits.robust import FitOptions, solve
from pipeline.core.vocabulary import Array


@dataclass(frozen=True, kw_only=True)
class Sphere:
    """Sphere.

    Attributes:
        centre: (3,).
        radius: radius.
        covariance: (4, 4) of (x, y, z, radius).
        noise_sigma: standard deviation of a point of weight 1 across the surface.
        robust_weights: (n,) in [0, 1].
    """

    centre: Array
    radius: float
    covariance: Array
    noise_sigma: float
    robust_weights: Array

    @property
    def radius_sigma(self) -> float:
        """Standard deviation of the radius."""
        return sqrt(self.covariance[3, 3])

    def distances(self, points: ArrayLike) -> Array:
        """Signed distances of (n, 3) points, positive outside."""
        return np.linalg.norm(np.asarray(points, dtype=float) - self.centre, axis=1) - self.radius


def fit_sphere(
    points: ArrayLike,
    weights: ArrayLike | None = None,
    radius: float | None = None,
    options: FitOptions | None = None,
) -> Sphere:
    """Fit a sphere to (n, 3) points; with ``radius`` it is held there (a target of known size).

    Raises:
        StageError: too few points, or points in one plane.
    """
    xyz, weight = checked("sphere", points, weights, 3)
    start = algebraic_sphere(xyz, weight)
    held = radius is not None
    values = start[:3] if held else start

    def residuals(values: Array) -> tuple[Array, Array]:
        away = xyz - values[:3]
        distance = np.linalg.norm(away, axis=1)
        outward = away / np.maximum(distance, 1e-300)[:, None]
        if radius is not None:
            return distance - radius, -outward
        return distance - values[3], np.column_stack([-outward, -np.ones(len(xyz))])

    found = solve("sphere", residuals, values, weights=weight, options=options or FitOptions())
    covariance = np.zeros((4, 4))
    covariance[: len(values), : len(values)] = found.covariance
    return Sphere(
        centre=found.values[:3],
        radius=float(radius) if radius is not None else float(found.values[3]),
        covariance=covariance,
        noise_sigma=found.noise_sigma,
        robust_weights=found.robust_weights,
    )


def algebraic_sphere(xyz: Array, weight: Array) -> Array:
    """Starting (x, y, z, radius) by linear least squares on |p|^2 = 2 c . p + d; a start, never a result."""
    if np.count_nonzero(weight > 0) < 4:
        raise StageError("fit", "a sphere needs at least 4 points", "give more points")
    centre = np.average(xyz, axis=0, weights=weight)
    local, root = xyz - centre, np.sqrt(weight)
    design = np.column_stack([2 * local, np.ones(len(xyz))]) * root[:, None]
    solution, _, rank, _ = np.linalg.lstsq(design, np.sum(local**2, axis=1) * root, rcond=1e-9)
    if rank < 4:
        raise StageError("fit", "the points of a sphere lie in a plane", "give a wider part of the sphere")
    radius = sqrt(max(solution[3] + solution[:3] @ solution[:3], 0.0))
    return np.array([*(centre + solution[:3]), radius])
