"""Circle in the plane, by orthogonal distances."""

from dataclasses import dataclass
from math import inf, sqrt

import numpy as np
from numpy.typing import ArrayLike

from pipeline.core.errors import StageError
from pipeline.core.fits.points import checked
from pipeline.core.fits.robust import FitOptions, Prior, solve
from pipeline.core.vocabulary import Array


@dataclass(frozen=True, kw_only=True)
class CirclePrior:
    """What is known of a circle beforehand.

    Attributes:
        centre: (x, y).
        centre_sigma: standard deviation of each coordinate; inf where nothing is known.
        radius: radius.
        radius_sigma: its standard deviation; inf where nothing is known.
    """

    centre: tuple[float, float] = (0.0, 0.0)
    centre_sigma: float = inf
    radius: float = 1.0
    radius_sigma: float = inf


@dataclass(frozen=True, kw_only=True)
class Circle:
    """Circle.

    Attributes:
        centre: (2,).
        radius: radius.
        covariance: (3, 3) of (x, y, radius).
        noise_sigma: standard deviation of a point of weight 1 across the circle.
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
        return sqrt(self.covariance[2, 2])

    def distances(self, points: ArrayLike) -> Array:
        """Signed distances of (n, 2) points, positive outside."""
        return np.linalg.norm(np.asarray(points, dtype=float) - self.centre, axis=1) - self.radius


def fit_circle(
    points: ArrayLike,
    weights: ArrayLike | None = None,
    prior: CirclePrior | None = None,
    options: FitOptions | None = None,
) -> Circle:
    """Fit a circle, or several arcs of one, to (n, 2) points by orthogonal distances.

    Args:
        points: (n, 2).
        weights: (n,) relative inverse variances.
        prior: centre and radius with sigmas, in the points' unit.
        options: loss and noise.

    Raises:
        StageError: fewer than three points, or points on a line.
    """
    xy, weight = checked("circle", points, weights, 2)
    prior_values = None
    if prior is not None:
        mean = np.array([*prior.centre, prior.radius])
        sigmas = np.array([prior.centre_sigma, prior.centre_sigma, prior.radius_sigma])
        prior_values = Prior(mean=mean, sigmas=sigmas)
    start = _start(xy, weight, prior_values)

    def residuals(values: Array) -> tuple[Array, Array]:
        away = xy - values[:2]
        distance = np.linalg.norm(away, axis=1)
        outward = away / np.maximum(distance, 1e-300)[:, None]
        return distance - values[2], np.column_stack([-outward, -np.ones(len(xy))])

    found = solve(
        "circle", residuals, start, weights=weight, options=options or FitOptions(), prior=prior_values
    )
    return Circle(
        centre=found.values[:2],
        radius=float(found.values[2]),
        covariance=found.covariance,
        noise_sigma=found.noise_sigma,
        robust_weights=found.robust_weights,
    )


def _start(xy: Array, weight: Array, prior: Prior | None) -> Array:
    """Start from the prior where it knows all, else from the algebraic circle."""
    if prior is not None and np.isfinite(prior.sigmas).all():
        return prior.mean
    return np.array(algebraic_circle(xy, weight))


def algebraic_circle(xy: Array, weight: Array) -> tuple[float, float, float]:
    """Starting circle (x, y, radius) by Pratt's constrained algebraic fit.

    V. Pratt, "Direct least-squares fitting of algebraic surfaces", SIGGRAPH 1987.  Biased on noisy arcs: a
    start, never a result.

    Raises:
        StageError: fewer than three points, or points on a line.
    """
    if np.count_nonzero(weight > 0) < 3:
        raise StageError("fit", "a circle needs at least 3 points", "give more points")
    centre = np.average(xy, axis=0, weights=weight)
    local = xy - centre
    size = sqrt(np.average(np.sum(local**2, axis=1), weights=weight))
    if size == 0:
        raise StageError("fit", "all points of a circle are the same", "give points that are spread wider")
    x, y = (local / size).T
    design = np.column_stack([x**2 + y**2, x, y, np.ones_like(x)]) * np.sqrt(weight)[:, None]
    moments = design.T @ design / weight.sum()
    constraint_inverse = np.array([[0, 0, 0, -0.5], [0, 1, 0, 0], [0, 0, 1, 0], [-0.5, 0, 0, 0]])
    values, vectors = np.linalg.eig(constraint_inverse @ moments)
    real = np.where(values.real > -1e-12, values.real, np.inf)
    a, b, c, d = vectors[:, np.argmin(real)].real
    if abs(a) < 1e-9 * np.abs([b, c, d]).max():
        raise StageError("fit", "the points of a circle lie on a line", "give a wider arc")
    radius = sqrt(max(b * b + c * c - 4 * a * d, 0.0)) / abs(2 * a)
    return centre[0] - size * b / (2 * a), centre[1] - size * c / (2 * a), radius * size
