"""A plane through the ranges that one station measured, and how well a floor or wall is known by it.

Takes points on and around a plane, roughly known; gives its place, normal and covariance, or nothing where
they make none.  Leaves out where planes are (``planes.py``).

The plane is cut into cells, and cells are adjusted, not points.  A point is worth its noise; a cell is
worth its points' mean and the unevenness of the surface besides, which is estimated from the cells' own
residuals: without it the thousands of points beside the tripod would decide alone.  What cells near each
other share (bends, levels of one pour of concrete) is found by summing residuals over ever larger
patches.  Ranges are held against the place where their ray meets the plane, and points are chosen by that
place, so that noise neither turns the plane nor chooses its points (see ``rays.py``).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.core.errors import StageError
from pipeline.core.fits import FitOptions, Loss
from pipeline.core.fits.robust import solve
from pipeline.core.vocabulary import Array
from pipeline.steel.fitting import FLOOR_M
from pipeline.steel.survey_records import Scanner

STEEPEST = 0.17
"""Rays that meet the plane at a smaller cosine (over 80 degrees) smear over their footprint."""
GATES_M = (0.03, 0.012, 0.012)
"""How far points may be off the plane to be looked at, pass by pass, or ``GATE_SIGMAS`` if that is more."""
GATE_SIGMAS = 5.0
AROUND = np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])
LEAST_IN_CELL, ROUGH_CELL = 8, 1.6
"""A cell has so many points, and they scatter at most so many times as noise does."""
LEAST_PATCHES = 8
"""Fewer patches tell no scatter."""


@dataclass(frozen=True, kw_only=True)
class FittedPlane:
    """A plane of one station.

    Attributes:
        place: (3,) metres, station frame, in the middle of the cells.
        frame: (3, 3) rows u, v, normal; the normal points to the scanner.
        covariance: (3, 3) of (offset along the normal, slope towards u, towards v).
        points: how many it was fitted to.
        rms_m: of their distances.
        uneven_m: standard deviation of the cells about the plane beyond noise.
        area_m2: of the cells.
        reach_m: root mean square distance of the cells from the place.
    """

    place: Array
    frame: Array
    covariance: Array
    points: int
    rms_m: float
    uneven_m: float
    area_m2: float
    reach_m: float


@dataclass(frozen=True)
class _Cells:
    """(m, 2) numbers, (m, 3) Jacobian rows, (m,) mean heights, their variances, points, sums of squares."""

    number: NDArray[np.int64]
    jacobian: Array
    height: Array
    variance: Array
    count: NDArray[np.int64]
    square: Array


def fit_plane(
    points: Array, place: Array, frame: Array, inside: Array, cell_m: float, scanner: Scanner, floor_m: float
) -> FittedPlane | None:
    """Fit a plane to the points (n, 3) around it; None where too few cells lie on one.

    Args:
        points: station frame, metres.
        place, frame: (3,) and (3, 3) rows u, v, normal: roughly.
        inside: (k, 3) centres of the cubes that are on it: the plane is looked at only there.
        cell_m: edge of those cubes and of a cell.
        scanner: its noise.
        floor_m: no offset is taken to be better known than this.
    """
    for gate_m in GATES_M:
        cells = _cells(points, place, frame, inside, cell_m, scanner, gate_m)
        if len(cells.height) < LEAST_PATCHES:
            return None
        # steps lead from the place to the middle of the cells, where offset and slopes hang together least
        middle = np.average(-cells.jacobian[:, 1:], axis=0)
        found = _adjusted(cells)
        if found is None:
            return None
        values, covariance, uneven_m, weights = found
        normal = frame[2] + values[1:] @ frame[:2]
        place = place + values[0] * frame[2] + _on_plane(middle, values, frame)
        turned = frame_along(normal / np.linalg.norm(normal))
        covariance = _about(covariance, middle, frame, turned)
        frame = turned
    used = weights > 0.1
    away = cells.jacobian[used, 1:] + middle
    reach_m = float(np.sqrt(np.mean(np.sum(away**2, axis=1))))
    count = int(cells.count[used].sum())
    return FittedPlane(
        place=place,
        frame=frame,
        covariance=covariance + floor_m**2 * np.diag([1.0, reach_m**-2, reach_m**-2]),
        points=count,
        rms_m=float(np.sqrt(cells.square[used].sum() / count)),
        uneven_m=uneven_m,
        area_m2=int(used.sum()) * cell_m**2,
        reach_m=reach_m,
    )


def _cells(
    points: Array,
    place: Array,
    frame: Array,
    inside: Array,
    cell_m: float,
    scanner: Scanner,
    gate_m: float,
) -> _Cells:
    """Means of the points' heights over the plane, cell by cell, each where its ray meets the plane."""
    ranges = np.linalg.norm(points, axis=1)
    rays = points / ranges[:, None]
    cosines = rays @ frame[2]
    facing = np.abs(cosines) > STEEPEST
    rays, ranges, cosines = rays[facing], ranges[facing], cosines[facing]
    met = (place @ frame[2]) / cosines
    height = (ranges - met) * cosines
    across = (met[:, None] * rays - place) @ frame[:2].T
    sigma2 = (scanner.range_sigma_m * cosines) ** 2 + FLOOR_M**2
    sigma2 += (scanner.angle_sigma_rad * ranges) ** 2 * (1 - cosines**2)
    number = np.floor(across / cell_m).astype(np.int64)
    filled = np.floor((inside - place) @ frame[:2].T / cell_m).astype(np.int64)
    # cubes and cells do not keep step: a cell between cubes may hold the middle of none
    wanted = np.unique(_key((filled[:, None] + AROUND).reshape(-1, 2)))
    gate = np.maximum(gate_m, GATE_SIGMAS * np.sqrt(sigma2))
    keep = (met > 0) & (np.abs(height) < gate) & np.isin(_key(number), wanted)
    _, first, cell = np.unique(_key(number[keep]), return_index=True, return_inverse=True)
    weight = 1 / sigma2[keep]

    def mean_of(values: Array) -> Array:
        return np.bincount(cell, weight * values, minlength=len(first)) / total

    total = np.bincount(cell, weight, minlength=len(first))
    count = np.bincount(cell, minlength=len(first))
    heights = mean_of(height[keep])
    scatter = (height[keep] - heights[cell]) ** 2
    chi2 = np.bincount(cell, weight * scatter) / np.maximum(count - 1, 1)
    good = (count >= LEAST_IN_CELL) & (chi2 < ROUGH_CELL**2)
    jacobian = np.column_stack([np.ones(len(first)), *(-mean_of(across[keep][:, k]) for k in range(2))])
    return _Cells(
        number=number[keep][first][good],
        jacobian=jacobian[good],
        height=heights[good],
        variance=1 / total[good],
        count=count[good],
        square=np.bincount(cell, scatter)[good],
    )


def _adjusted(cells: _Cells) -> tuple[Array, Array, float, Array] | None:
    """Offset and slopes with covariance, the cells' unevenness, and their robust weights."""
    uneven2 = 0.0
    options = FitOptions(loss=Loss.HUBER, noise_sigma=1.0, iterations=20)

    def residuals(values: Array) -> tuple[Array, Array]:
        return cells.jacobian @ values - cells.height, cells.jacobian

    for _ in range(8):
        weight = 1 / (cells.variance + uneven2)
        try:
            found = solve("plane", residuals, np.zeros(3), weights=weight, options=options)
        except StageError:  # the cells lie on one line
            return None
        # single cells, a door or a heap, do not count beyond three sigmas
        square = float(np.mean(np.minimum(found.residuals**2 * weight, 9.0)))
        uneven2 = max(uneven2 + (square - 1) * float(np.median(cells.variance + uneven2)), 0.0)
    P = weight * found.robust_weights
    covariance = _by_patches(cells, P, found.residuals)
    return found.values, covariance, float(np.sqrt(uneven2)), found.robust_weights


def _by_patches(cells: _Cells, weight: Array, residuals: Array) -> Array:
    """Covariance (3, 3) of offset and slopes: that of independent cells, and more where patches want more.

    The jackknife that leaves out one patch after the other (J. Shao and D. Tu, "The Jackknife and Bootstrap",
    1995, section 2.3), at the size of patch where it is largest.  Few patches
    know the shape of a covariance badly, so no direction gets less than the average of the three.
    """
    normal = cells.jacobian.T @ (weight[:, None] * cells.jacobian)
    root = np.linalg.cholesky(np.linalg.inv(normal))
    largest, size = np.eye(3), 1
    while True:
        _, patch = np.unique(_key(cells.number // size), return_inverse=True)
        patches = int(patch.max()) + 1
        if patches < LEAST_PATCHES:
            break
        own = np.zeros((patches, 3, 3))
        outer = cells.jacobian[:, :, None] * cells.jacobian[:, None, :]
        np.add.at(own, patch, weight[:, None, None] * outer)
        score = np.stack([np.bincount(patch, weight * residuals * one) for one in cells.jacobian.T], axis=1)
        # ridge: without one patch of few the others may lie almost on one line
        without = normal - own + 1e-6 * np.diag(np.diag(normal))
        moved = np.linalg.solve(root, np.linalg.solve(without, score[:, :, None]))[:, :, 0]
        spread = (patches - 1) / patches * np.einsum("gi,gj->ij", moved, moved)
        largest = spread if np.trace(spread) > np.trace(largest) else largest
        size *= 2
    values, vectors = np.linalg.eigh(largest)
    gain = root @ vectors
    covariance: Array = gain @ (np.maximum(values, values.mean())[:, None] * gain.T)
    return covariance


def _about(covariance: Array, middle: Array, frame: Array, turned: Array) -> Array:
    """The covariance of offset and slopes in another frame and at another place on the plane."""
    to_slopes = turned[:2] @ frame[:2].T
    gain = np.zeros((3, 3))
    # the offset at the middle: height there follows the slopes
    gain[0] = [1.0, -middle[0], -middle[1]]
    gain[1:, 1:] = to_slopes
    moved: Array = gain @ covariance @ gain.T
    return moved


def _on_plane(middle: Array, values: Array, frame: Array) -> Array:
    """(3,) step from the place to the middle, in the adjusted plane."""
    step: Array = middle @ frame[:2] - (middle @ values[1:]) * frame[2]
    return step


def _key(number: NDArray[np.int64]) -> NDArray[np.int64]:
    return (number[:, 0] << 32) + number[:, 1]


def frame_along(axis: Array) -> Array:
    """(3, 3) rows u, v, direction, right-handed, of a unit vector (3,)."""
    u = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    u /= np.linalg.norm(u)
    return np.stack([u, np.cross(axis, u), axis])
