"""Triangles of places: their shapes, which no turn, move or scale changes, and what brings one to another.

Takes places and which of them to use; gives triangles, and similarities between pairs of them.  Leaves out
which pairs belong together (:mod:`pipeline.steel.feature_match`).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.core.vocabulary import Array

Corners = NDArray[np.int64]
LEAST_HEIGHT = 0.15
"""A triangle lower than this share of its longest side does not hold a turn about it."""


@dataclass(frozen=True)
class Triangles:
    """Triangles of spheres.

    Attributes:
        corners: (t, 3) numbers of the spheres, opposite the longest, the middle and the shortest side.
        longest: (t,) side; shape: (t, 2) the other sides as shares of it.
    """

    corners: NDArray[np.int64]
    longest: Array
    shape: Array

    def some(self, chosen: NDArray[np.int64]) -> "Triangles":
        """Those with the numbers ``chosen``."""
        return Triangles(self.corners[chosen], self.longest[chosen], self.shape[chosen])


def triangles(chosen: NDArray[np.int64], places: Array) -> Triangles:
    """All triangles of the ``chosen`` ones of (n, 3) places that are not too flat to hold a turn."""
    corners = chosen[_combinations(len(chosen))].T
    sides = _sides(corners, places)
    order = np.argsort(-sides, axis=1)
    corners, sides = np.take_along_axis(corners, order, 1), np.take_along_axis(sides, order, 1)
    half = sides.sum(axis=1) / 2
    area = np.sqrt(np.maximum(half * np.prod(half[:, None] - sides, axis=1), 0))
    good = 2 * area > LEAST_HEIGHT * sides[:, 0] ** 2
    # sides of equal length leave the order of the corners open: each order is a triangle of its own
    every = [corners[good]]
    for a, b in ((0, 1), (1, 2)):
        alike = good & (sides[:, b] > 0.97 * sides[:, a])
        swapped = corners[alike].copy()
        swapped[:, [a, b]] = swapped[:, [b, a]]
        every.append(swapped)
    corners = np.concatenate(every)
    sides = _sides(corners, places)
    return Triangles(corners, sides[:, 0], sides[:, 1:] / sides[:, :1])


def from_triangles(x: Array, y: Array) -> tuple[Array, Array, Array]:
    """Similarities (h,), (h, 3, 3), (h, 3) from h pairs of triangles (h, 3, 3), by their frames."""
    scale = _size(y) / _size(x)
    rotation = np.einsum("hai,haj->hij", _frame(y), _frame(x))
    return (
        scale,
        rotation,
        y.mean(axis=1) - scale[:, None] * np.einsum("hij,hj->hi", rotation, x.mean(axis=1)),
    )


def _sides(corners: NDArray[np.int64], places: Array) -> Array:
    """(t, 3) lengths of the sides opposite the corners."""
    x = places[corners]
    return np.linalg.norm(x[:, [1, 0, 0]] - x[:, [2, 2, 1]], axis=2)


def _combinations(count: int) -> NDArray[np.int64]:
    i, j, k = np.meshgrid(*[np.arange(count)] * 3, indexing="ij")
    chosen = (i < j) & (j < k)
    return np.stack([i[chosen], j[chosen], k[chosen]])


def _size(corners: Array) -> Array:
    return np.sqrt(np.sum((corners - corners.mean(axis=1, keepdims=True)) ** 2, axis=(1, 2)))


def _frame(corners: Array) -> Array:
    a = corners[:, 2] - corners[:, 1]
    a = a / np.linalg.norm(a, axis=1, keepdims=True)
    n = np.cross(a, corners[:, 0] - corners[:, 1])
    n = n / np.linalg.norm(n, axis=1, keepdims=True)
    return np.stack([a, np.cross(n, a), n], axis=1)
