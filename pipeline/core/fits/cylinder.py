"""Circular cylinder, its axis straight or slightly bowed, by distances to the axis."""

from dataclasses import dataclass
from math import sqrt

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.core.errors import StageError
from pipeline.core.fits.circle import algebraic_circle
from pipeline.core.fits.points import checked
from pipeline.core.fits.robust import Estimate, FitOptions, solve
from pipeline.core.vocabulary import Array

START_POINTS = 1500
"""The search for a first direction looks at about this many of the points."""
START_DIRECTIONS = 150
"""Directions tried over the half sphere: neighbours are about 12 degrees apart."""


@dataclass(frozen=True, kw_only=True)
class Cylinder:
    """Cylinder about the axis point + t direction + t^2 bow.

    Attributes:
        point: (3,) on the axis, square to the points' weighted centre.
        direction: (3,) unit vector, its largest component positive.
        radius: radius.
        bow: (3,) square to the direction, 1 / length unit; zero for a straight axis.
        frame: (3, 3) rows u, v, direction: the frame of the covariance.
        covariance: (5, 5) of (offset along u, along v, slope towards u, towards v, radius), or (7, 7) with
            the bow's u and v components behind.
        noise_sigma: standard deviation of a point of weight 1 across the surface.
        robust_weights: (n,) in [0, 1].
    """

    point: Array
    direction: Array
    radius: float
    bow: Array
    frame: Array
    covariance: Array
    noise_sigma: float
    robust_weights: Array

    @property
    def radius_sigma(self) -> float:
        """Standard deviation of the radius."""
        return sqrt(self.covariance[4, 4])

    def axis_at(self, t: ArrayLike) -> Array:
        """(n, 3) points of the axis at distances t (n,) along it from ``point``."""
        along = np.asarray(t, dtype=float)[:, None]
        return self.point + along * self.direction + along**2 * self.bow

    def distances(self, points: ArrayLike) -> Array:
        """Signed distances of (n, 3) points from the surface, positive outside."""
        local = (np.asarray(points, dtype=float) - self.point) @ self.frame.T
        values = np.array([0, 0, 0, 0, self.radius, *(self.frame[:2] @ self.bow)])
        return _distances(values, local)


def fit_cylinder(
    points: ArrayLike,
    weights: ArrayLike | None = None,
    *,
    direction: ArrayLike | None = None,
    bowed: bool = False,
    options: FitOptions | None = None,
) -> Cylinder:
    """Fit a cylinder to (n, 3) points; part of the surface is enough.

    Args:
        points: (n, 3).
        weights: (n,) relative inverse variances.
        direction: (3,) axis roughly, within about 20 degrees; None: searched for.
        bowed: estimate the axis as a parabola.
        options: loss and noise.

    Raises:
        StageError: too few points, or points that fit no cylinder.
    """
    xyz, weight = checked("cylinder", points, weights, 3)
    count = 7 if bowed else 5
    if np.count_nonzero(weight > 0) < count:
        raise StageError("fit", f"a cylinder needs at least {count} points", "give more points")
    centre = np.average(xyz, axis=0, weights=weight)
    local, few = xyz - centre, _few(weight)
    axis = _first_direction(local[few]) if direction is None else np.asarray(direction, dtype=float)
    # slopes and bow are small quantities about the frame: find the frame on few points, then fit all in it
    rough, frame = _fit_in(_frame(axis), local[few], weight[few], 5, options)
    found, frame = _fit_in(_frame(np.array([*rough.values[2:4], 1.0]) @ frame), local, weight, count, options)
    values = found.values
    return Cylinder(
        point=centre + values[:2] @ frame[:2],
        direction=_unit(np.array([*values[2:4], 1.0]) @ frame),
        radius=float(values[4]),
        bow=values[5:7] @ frame[:2] if bowed else np.zeros(3),
        frame=frame,
        covariance=found.covariance,
        noise_sigma=found.noise_sigma,
        robust_weights=found.robust_weights,
    )


def _fit_in(
    frame: Array, centred: Array, weight: Array, count: int, options: FitOptions | None
) -> tuple[Estimate, Array]:
    """Fit in a frame whose third row is the axis to within some degrees."""
    local = centred @ frame.T
    x, y, radius = algebraic_circle(local[:, :2], weight)
    start = np.array([x, y, 0.0, 0.0, radius, 0.0, 0.0])[:count]
    found = solve(
        "cylinder", lambda v: _residuals(v, local), start, weights=weight, options=options or FitOptions()
    )
    return found, frame


def _distances(values: Array, local: Array) -> Array:
    """Signed distances of (n, 3) local points: exact for a line, to second order of the bow otherwise."""
    return _residuals(values, local)[0]


def _residuals(values: Array, local: Array) -> tuple[Array, Array]:
    """Distances from the surface and their Jacobian (n, 5) or (n, 7)."""
    t = local[:, 2]
    bow = values[5:7] if len(values) == 7 else np.zeros(2)
    away = local[:, :2] - values[:2] - t[:, None] * values[2:4] - (t**2)[:, None] * bow
    tangent = values[2:4] + 2 * t[:, None] * bow
    length2 = 1 + np.sum(tangent**2, axis=1)
    along = np.sum(away * tangent, axis=1)
    distance = np.sqrt(np.maximum(np.sum(away**2, axis=1) - along**2 / length2, 1e-300))
    # d(distance^2)/2 = away . d away - along (tangent . d away + away . d tangent) / length2
    #                   + along^2 (tangent . d tangent) / length2^2
    ratio = (along / length2)[:, None]
    per_away = (away - ratio * tangent) / distance[:, None]
    per_tangent = (-ratio * away + ratio**2 * tangent) / distance[:, None]
    columns = [-per_away, -t[:, None] * per_away + per_tangent, -np.ones((len(t), 1))]
    if len(values) == 7:
        columns.append(-(t**2)[:, None] * per_away + 2 * t[:, None] * per_tangent)
    return distance - values[4], np.concatenate(columns, axis=1)


def _first_direction(centred: Array) -> Array:
    """The direction along which the points look most like a thin circle: coarse search, then finer."""
    index = np.arange(START_DIRECTIONS) + 0.5
    height, turn = index / START_DIRECTIONS, index * np.pi * (3 - sqrt(5))
    ring = np.sqrt(1 - height**2)
    coarse = np.stack([ring * np.cos(turn), ring * np.sin(turn), height], axis=1)
    best = coarse[np.argmin([_thickness(d, centred) for d in coarse])]
    for step in (0.05, 0.012):
        grid = np.stack(np.meshgrid(*[np.arange(-4, 5) * step] * 2), axis=-1).reshape(-1, 2)
        fine = np.column_stack([grid, np.ones(len(grid))]) @ _frame(best)
        best = fine[np.argmin([_thickness(d, centred) for d in fine])]
    return best


def _thickness(direction: Array, centred: Array) -> float:
    """Median distance of the points, seen along the direction, from their circle."""
    flat = centred @ _frame(direction)[:2].T
    try:
        x, y, radius = algebraic_circle(flat, np.ones(len(flat)))
    except StageError:  # seen along this direction they lie on a line, so it is not the axis
        return np.inf
    return float(np.median(np.abs(np.hypot(*(flat - (x, y)).T) - radius)))


def _few(weight: Array) -> NDArray[np.int64]:
    """Indices of at most START_POINTS used points, spread evenly over their order."""
    used = np.flatnonzero(weight > 0)
    return used[np.linspace(0, len(used) - 1, min(len(used), START_POINTS)).astype(np.int64)]


def _frame(axis: Array) -> Array:
    """Rows u, v, direction; right-handed, the direction's largest component positive."""
    direction = _unit(axis)
    direction = direction * np.sign(direction[np.argmax(np.abs(direction))])
    u = _unit(np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))]))
    return np.stack([u, np.cross(direction, u), direction])


def _unit(vector: Array) -> Array:
    return vector / np.linalg.norm(vector)
