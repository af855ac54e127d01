"""Lambda from plumb lines: the cable's two edges are straight, the lens bends them into circular arcs.

Takes edge points of many frames of one camera and how the robot moved; gives lambda with an honest sigma.
Leaves out finding the edges (:mod:`pipeline.cable.silhouette`).

Model: each edge of each frame is, undistorted by equation (15), a straight line of its own (the robot sways)
plus the shape of the cable.  The shape moves through the frames with the travel while the lens stands still,
which is how the two are told apart; it is a sum of waves with a prior: *even*, the diameter swells and both
edges move apart, just as they do under the lens, and *odd*, the axis bends.  Without the shape, sigma would
be far too small: a swelling of 0.3 mm looks like a fifth of an ordinary barrel distortion.

Starting value: a line becomes x^2 + y^2 + A x + B y + C = 0 about the distortion centre, with C = 1 / lambda
(Fitzgibbon 2001; paper, references 37 and 38).  Internally x runs along the cable, coordinates are relative
to the principal point and in half-diagonals, and so is the lambda that is solved for.
"""

from dataclasses import dataclass
from math import hypot, tau

import numpy as np
from numpy.typing import NDArray

from pipeline.cable.plumb_records import PlumbEdges, PlumbLineFit, PlumbLineOptions, PlumbScene
from pipeline.core.errors import StageError
from pipeline.core.fits.robust import FitOptions, Loss, Prior, solve
from pipeline.core.vocabulary import Array

LEAST_NOISE = 2e-5
"""No edge point is better than this, half-diagonals (0.01 px in 960 x 600)."""


def fit_plumb_lines(edges: PlumbEdges, scene: PlumbScene, options: PlumbLineOptions) -> PlumbLineFit:
    """Estimate lambda from the edges.

    Raises:
        StageError: too few edges.
    """
    points = edges.points_px / scene.half_diagonal_px
    lines, line = np.unique(2 * edges.frame + (edges.side > 0), return_inverse=True)
    if len(lines) < 2 or len(points) < 5 * len(lines):
        raise StageError(
            "lens", "too few edges of the cable to estimate lambda", "give more frames, or lambda"
        )
    start = _algebraic_start(points, line, len(lines))
    sigma_scale, division_lambda = 1.0, start
    for _ in range(5):
        shape, spread, place_m = _shape_columns(edges, scene, options, division_lambda)
        unknowns = _Unknowns(points=points, line=line, line_count=len(lines), shape=shape)
        values, covariance, residuals, noise, weights = _adjust(unknowns, start, spread * sigma_scale)
        waves = slice(1 + 2 * len(lines), None)
        # expectation-maximisation for the prior's scale: mean square of the waves, their uncertainty included
        found2 = values[waves] ** 2 + np.diag(covariance)[waves]
        grown = float(np.sqrt(np.mean(found2 / (spread * sigma_scale) ** 2)))
        moved, division_lambda = abs(values[0] - division_lambda), float(values[0])
        if grown <= 1.05 and moved < 0.2 * np.sqrt(covariance[0, 0]):
            break
        sigma_scale *= max(grown, 1.0)
    variance = _variance_with_dependence(
        unknowns, values, covariance, weights * residuals, noise, _patches(edges, scene, place_m, options)
    )
    return PlumbLineFit(
        lambda_half_diagonal=float(values[0]),
        sigma=float(np.sqrt(variance)),
        start_lambda=start,
        line_count=len(lines),
        point_count=len(points),
        bent_px=_crookedness(points, line, 0.0) * scene.half_diagonal_px,
        straight_px=_crookedness(points, line, float(values[0])) * scene.half_diagonal_px,
        noise_px=noise * scene.half_diagonal_px,
        shape_sigma_mm=options.shape_sigma_mm * sigma_scale,
    )


def _algebraic_start(points: Array, line: NDArray[np.int64], count: int) -> float:
    """Median over the edges of C = 1 / lambda, from y = a + b x + a lambda r^2, weighted by a^2."""
    values, weights = np.zeros(count), np.zeros(count)
    for i in range(count):
        x, y = points[line == i].T
        design = np.column_stack([np.ones_like(x), x, x**2 + y**2])
        a, _, bend = np.linalg.lstsq(design, y, rcond=None)[0]
        values[i], weights[i] = bend / a if abs(a) > 1e-6 else 0.0, a**2
    order = np.argsort(values)
    middle = int(np.searchsorted(np.cumsum(weights[order]), weights.sum() / 2))
    farthest2 = float(np.max(np.sum(points**2, axis=1)))
    return float(np.clip(values[order][min(middle, count - 1)], -0.5 / farthest2, 0.5 / farthest2))


def _shape_columns(
    edges: PlumbEdges, scene: PlumbScene, options: PlumbLineOptions, division_lambda: float
) -> tuple[Array, Array, Array]:
    """Waves (n, m) of the shape at each point, their prior sigmas (m,) in half-diagonals, places (n,) m.

    The places need the lens too: 1.5 % off towards the picture's ends, a wave would be bent into a bias.
    """
    r2 = np.sum((edges.points_px / scene.half_diagonal_px) ** 2, axis=1)
    x, y = (edges.points_px / (1 + division_lambda * r2)[:, None]).T
    half_width = float(np.median(np.abs(y - np.mean([np.median(y[edges.side == s]) for s in (-1, 1)]))))
    # the edge is seen where the ray touches the cable: nearer than the axis by cos^2, and slanted
    cosine = 1 / hypot(1.0, half_width / scene.focal_px)
    place = scene.positions_m[edges.frame] + scene.forward * x * scene.standoff_m * cosine**2 / scene.focal_px
    period = 2 * max(float(np.ptp(place)), options.shortest_wave_m)
    first = max(int(np.ceil(period / options.longest_wave_m)), 1)
    last = max(int(period / options.shortest_wave_m), first)
    number = np.arange(first, last + 1.0)
    phase = tau * (place[:, None] - place.min()) / period * number
    waves = np.concatenate([np.cos(phase), np.sin(phase)], axis=1)
    # a wave with coefficients of variance v for cosine and sine has the variance v everywhere
    share = np.tile((1 / number) / np.sum(1 / number), 2)
    px_per_mm = scene.focal_px / (scene.standoff_m * 1000 * cosine**3)
    per_mm = px_per_mm / scene.half_diagonal_px
    even, odd = options.shape_sigma_mm / 2 * per_mm, options.shape_sigma_mm * per_mm
    columns = np.concatenate([edges.side[:, None] * waves, waves], axis=1)
    return columns, np.concatenate([even * np.sqrt(share), odd * np.sqrt(share)]), place


@dataclass(frozen=True, kw_only=True)
class _Unknowns:
    """Constants of the adjustment; its values are lambda, (offset, slope) per line, waves."""

    points: Array
    line: NDArray[np.int64]
    line_count: int
    shape: Array

    def residuals(self, values: Array) -> tuple[Array, Array]:
        """Measured minus predicted y in the distorted picture, half-diagonals, and the Jacobian.

        The prediction solves y = slope x + (offset + shape) (1 + lambda (x^2 + y^2)), equation (15)
        multiplied out.  No measured y goes into it: a lambda that shrinks the noise with the picture, or
        noise in r^2, each would be a bias of up to two sigma.
        """
        x, y = self.points.T
        offset, slope = values[1 : 1 + 2 * self.line_count].reshape(-1, 2)[self.line].T
        height = offset + self.shape @ values[1 + 2 * self.line_count :]
        predicted = y
        for _ in range(2):  # Newton: the first step is good to the square of the noise
            error = predicted - slope * x - height * (1 + values[0] * (x**2 + predicted**2))
            predicted = predicted - error / (1 - 2 * values[0] * height * predicted)
        r2 = x**2 + predicted**2
        per_right_side = -1 / (1 - 2 * values[0] * height * predicted)
        growth = (1 + values[0] * r2) * per_right_side
        row = np.arange(len(x))
        jacobian = np.zeros((len(x), len(values)))
        jacobian[:, 0] = height * r2 * per_right_side
        jacobian[row, 1 + 2 * self.line] = growth
        jacobian[row, 2 + 2 * self.line] = x * per_right_side
        jacobian[:, 1 + 2 * self.line_count :] = self.shape * growth[:, None]
        return y - predicted, jacobian


def _adjust(unknowns: _Unknowns, start: float, spread: Array) -> tuple[Array, Array, Array, float, Array]:
    """Robust adjustment: values, covariance, residuals, noise, and the total weight of each point."""
    count = unknowns.line_count
    values = np.concatenate([[start], np.zeros(2 * count + len(spread))])
    prior = Prior(mean=np.zeros(len(values)), sigmas=np.concatenate([np.full(1 + 2 * count, np.inf), spread]))
    weights = np.ones(len(unknowns.points))
    values[1 : 1 + 2 * count : 2] = _mean_heights(unknowns)
    found = solve(
        "plumb line",
        unknowns.residuals,
        values,
        weights=weights,
        options=FitOptions(loss=Loss.TUKEY, least_noise_sigma=LEAST_NOISE, iterations=20),
        prior=prior,
    )
    return found.values, found.covariance, found.residuals, found.noise_sigma, found.robust_weights


def _mean_heights(unknowns: _Unknowns) -> Array:
    """Mean y of each edge: lambda multiplies the heights, so they must not start at zero."""
    count = np.bincount(unknowns.line, minlength=unknowns.line_count)
    total = np.bincount(unknowns.line, unknowns.points[:, 1], minlength=unknowns.line_count)
    return total / np.maximum(count, 1)


def _patches(
    edges: PlumbEdges, scene: PlumbScene, place_m: Array, options: PlumbLineOptions
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Numbers (n,) of the patch of cable, and of the part of the picture, that each point lies on."""
    on_cable = np.floor((place_m - place_m.min()) * 1000 / options.patch_mm).astype(np.int64)
    in_picture = np.floor(edges.points_px[:, 0] / scene.half_diagonal_px * 8 + 16).astype(np.int64)
    second = edges.side > 0
    return 2 * on_cable + second, 2 * in_picture + second


def _variance_with_dependence(
    unknowns: _Unknowns,
    values: Array,
    covariance: Array,
    weighted_residuals: Array,
    noise: float,
    patches: tuple[NDArray[np.int64], NDArray[np.int64]],
) -> float:
    """Variance of lambda when errors on one patch of the cable, or in one part of the picture, go together.

    A. C. Cameron, J. B. Gelbach and D. L. Miller, "Robust inference with multiway clustering", J. Business &
    Economic Statistics 29(2), 2011: the excess of each grouping over independent errors is added.
    """
    jacobian = unknowns.residuals(values)[1]
    lever = jacobian @ covariance[0] / noise
    from_noise = float(lever @ lever)
    pull = lever * weighted_residuals
    growth = [float(np.sum(np.bincount(patch, pull) ** 2) / np.sum(pull**2)) for patch in patches]
    return float(covariance[0, 0]) + from_noise * sum(max(value - 1, 0.0) for value in growth)


def _crookedness(points: Array, line: NDArray[np.int64], division_lambda: float) -> float:
    """Root mean square distance from the best straight line through each edge, gross errors left out."""
    straight = points / (1 + division_lambda * np.sum(points**2, axis=1))[:, None]
    squares = []
    for i in range(int(line.max()) + 1):
        x, y = straight[line == i].T
        rest = y - np.polynomial.Polynomial.fit(x, y, 1)(x)
        squares.append(rest[np.abs(rest) <= 4 * 1.4826 * np.median(np.abs(rest)) + 1e-12] ** 2)
    return float(np.sqrt(np.mean(np.concatenate(squares))))
