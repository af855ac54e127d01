"""Ellipse that is nearly a circle, by distances; regular at zero ovality.

With mean semi-axis m and half-difference e = hypot(a, b) of the semi-axes, the exact polar form about the
centre is rho(t) = (m^2 - e^2) / sqrt(m^2 + e^2 - 2 m q), q = a cos 2t + b sin 2t.  Unlike semi-axes and an
angle, (a, b) stay well determined for a circle, and their first order is the Fourier form
rho = m + a cos 2t + b sin 2t.
"""

from dataclasses import dataclass
from math import atan2, degrees, hypot, sqrt

import numpy as np
from numpy.typing import ArrayLike

from pipeline.core.errors import StageError
from pipeline.core.fits.circle import fit_circle
from pipeline.core.fits.points import checked
from pipeline.core.fits.robust import FitOptions, Loss, Prior, solve
from pipeline.core.vocabulary import Array


@dataclass(frozen=True, kw_only=True)
class Ellipse:
    """Ellipse.

    Attributes:
        centre: (2,).
        mean_diameter: mean of the largest and the smallest diameter.
        largest_diameter, smallest_diameter: the principal diameters.
        angle_deg: direction of the largest diameter, from x towards y, in (-90, 90].
        covariance: (5, 5) of (x, y, m, a, b) of the module's formula.
        noise_sigma: standard deviation of a point of weight 1 across the ellipse.
        robust_weights: (n,) in [0, 1].
    """

    centre: Array
    mean_diameter: float
    largest_diameter: float
    smallest_diameter: float
    angle_deg: float
    covariance: Array
    noise_sigma: float
    robust_weights: Array

    @property
    def mean_diameter_sigma(self) -> float:
        """Standard deviation of the mean diameter."""
        return 2 * sqrt(self.covariance[2, 2])

    @property
    def ovality_sigma(self) -> float:
        """Standard deviation of (largest - smallest) diameter, the larger of its two components."""
        return 4 * sqrt(np.linalg.eigvalsh(self.covariance[3:, 3:])[-1])


def fit_ellipse(
    points: ArrayLike,
    weights: ArrayLike | None = None,
    ovality_sigma: float | None = None,
    options: FitOptions | None = None,
) -> Ellipse:
    """Fit an ellipse to (n, 2) points by distances along the radius, made orthogonal to first order.

    Args:
        points: (n, 2).
        weights: (n,) relative inverse variances.
        ovality_sigma: how large (largest - smallest) diameter may be expected, in the points' unit; holds
            the shape where the points cover only an arc.  None: free.
        options: loss and noise.

    Raises:
        StageError: fewer than five points without a prior, points on a line, or a figure far from a circle.
    """
    xy, weight = checked("ellipse", points, weights, 2)
    circle = fit_circle(xy, weight, options=FitOptions(loss=Loss.HUBER))
    start = np.array([*circle.centre, circle.radius, 0.0, 0.0])
    prior = None
    if ovality_sigma is not None:
        # (largest - smallest) is 4 e, and e has two components
        sigmas = np.array([np.inf, np.inf, np.inf, ovality_sigma / 4, ovality_sigma / 4])
        prior = Prior(mean=np.zeros(5), sigmas=sigmas)
    found = solve(
        "ellipse",
        lambda values: _residuals(values, xy),
        start,
        weights=weight,
        options=options or FitOptions(),
        prior=prior,
    )
    x, y, mean, a, b = found.values
    half_difference = hypot(a, b)
    if mean <= 0 or half_difference >= mean / 4:
        raise StageError("fit", "the points lie on no nearly circular ellipse", "check the section's points")
    return Ellipse(
        centre=np.array([x, y]),
        mean_diameter=2 * mean,
        largest_diameter=2 * (mean + half_difference),
        smallest_diameter=2 * (mean - half_difference),
        angle_deg=degrees(0.5 * atan2(b, a)),
        covariance=found.covariance,
        noise_sigma=found.noise_sigma,
        robust_weights=found.robust_weights,
    )


def _residuals(values: Array, xy: Array) -> tuple[Array, Array]:
    """Distances with their Jacobian, by central differences of the exact form (five cheap columns)."""
    distance = _distances(values, xy)
    size = 1e-5 * max(abs(values[2]), 1e-300)
    columns = [
        (_distances(values + step, xy) - _distances(values - step, xy)) / (2 * size)
        for step in np.eye(5) * size
    ]
    return distance, np.column_stack(columns)


def _distances(values: Array, xy: Array) -> Array:
    """Radial distance times the cosine between radius and normal."""
    x, y, mean, a, b = values
    away = xy - (x, y)
    rho = np.linalg.norm(away, axis=1)
    cosine, sine = (away / np.maximum(rho, 1e-300)[:, None]).T
    cosine2, sine2 = cosine**2 - sine**2, 2 * sine * cosine
    e2 = a * a + b * b
    inner = np.maximum(mean**2 + e2 - 2 * mean * (a * cosine2 + b * sine2), 1e-300)
    on_ellipse = (mean**2 - e2) / np.sqrt(inner)
    # d rho / d t = rho m q' / inner with q' = 2 (b cos 2t - a sin 2t)
    slope = 2 * mean * (b * cosine2 - a * sine2) / inner
    return (rho - on_ellipse) / np.sqrt(1 + slope**2)
