"""A cable of known radius found among the points of a scan: rooms, ground and other things may be around it.

Takes points in metres and the radius; gives axis and extent, or nothing.  From a point of the cable, one
radius inward along the normal, lies the axis: the cable's points all lead to one line, which is far more
crowded than what walls and other tubes lead to.  Leaves out the exact axis
(:mod:`pipeline.steel.cable_start`).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from pipeline.core.errors import StageError
from pipeline.core.fits import fit_cylinder
from pipeline.core.vocabulary import Array

NEIGHBOURS = 24
BATCH = 20_000
SPACING, BLOCK, CELL, WITHIN = 0.12, 4.0, 0.3, 0.3
"""In radii: between the points looked at, of the blocks tested for planes, of the cells that count places on
the axis, and how far off a line they may be."""
FLAT = 0.08
"""Points of a block that scatter less than this across two other directions, in radii, lie on a plane."""
CROWDED = 3000
"""So many of the most crowded cells are looked at."""
TRIES, MOST_LINES = 1500, 6
NEAREST_PAIR, FARTHEST_PAIR = 3.0, 40.0
"""Two cells on one axis, in radii, that are tried as a line."""
LEAST_POINTS = 300
LEAST_LENGTH, GAP = 2.0, 3.0
"""Of what is taken for a cable, and of a place where it is hidden, in radii."""
ALIKE = 0.1
"""The fitted radius may differ by this share."""


@dataclass(frozen=True, kw_only=True)
class FoundCable:
    """A cable: ``place`` (3,) on its axis, ``direction`` (3,), ``radius_m``, ends along the direction."""

    place: Array
    direction: Array
    radius_m: float
    first_m: float
    last_m: float

    def holds(self, points: Array, aside_m: float, beyond_m: float) -> NDArray[np.bool_]:
        """(n,) whether points (n, 3) are so near the surface, and at most so far beyond the ends."""
        away = points - self.place
        along = away @ self.direction
        off = _off(points, self.place, self.direction)
        inside = (along > self.first_m - beyond_m) & (along < self.last_m + beyond_m)
        return np.asarray(inside & (np.abs(off - self.radius_m) < aside_m))


def find_cable(points: Array, radius_m: float, tick: Callable[[int], None]) -> FoundCable | None:
    """Find a cable among points (n, 3), metres; ``tick`` is told 0 to 300."""
    tick(0)
    few = points[~_in_planes(points, BLOCK * radius_m, FLAT * radius_m)]
    if len(few) < LEAST_POINTS:
        return None
    few = few[np.unique(_cells(few, SPACING * radius_m), return_index=True)[1]]
    if len(few) < LEAST_POINTS:
        return None
    centres = _centres(few, radius_m, tick)
    cell = _cells(centres, CELL * radius_m)
    _, inverse, counts = np.unique(cell, return_inverse=True, return_counts=True)
    crowded = np.argsort(-counts, kind="stable")[:CROWDED]
    middles = np.stack([np.bincount(inverse, column) for column in centres.T], axis=1) / counts[:, None]
    left, worth = middles[crowded], counts[crowded].astype(float)
    for number in range(MOST_LINES):
        tick(260 + 40 * number // MOST_LINES)
        line = _line(left, worth, radius_m)
        if line is None:
            return None
        found = _fitted(few, *line, radius_m)
        if found is not None:
            return found
        # another tube, or no tube at all: what led to it no longer counts
        other = _off(left, *line) < WITHIN * radius_m
        left, worth = left[~other], worth[~other]
    return None


def _cells(points: Array, edge: float) -> NDArray[np.int64]:
    cells = np.floor((points - points.min(axis=0)) / edge).astype(np.int64)
    size = cells.max(axis=0) + 1
    return np.asarray((cells[:, 0] * size[1] + cells[:, 1]) * size[2] + cells[:, 2])


def _in_planes(points: Array, edge: float, thin_m: float) -> NDArray[np.bool_]:
    """Points of blocks that hold a thin layer and nothing else."""
    _, block, counts = np.unique(_cells(points, edge), return_inverse=True, return_counts=True)
    mean = np.stack([np.bincount(block, column) for column in points.T], axis=1) / counts[:, None]
    away = points - mean[block]
    moments = np.empty((len(counts), 3, 3))
    for i in range(3):
        for j in range(3):
            moments[:, i, j] = np.bincount(block, away[:, i] * away[:, j]) / counts
    return np.asarray((np.linalg.eigvalsh(moments)[:, 0] < thin_m**2)[block])


def _centres(points: Array, radius_m: float, tick: Callable[[int], None]) -> Array:
    """(2 n, 3) one radius to both sides of each point, along its normal."""
    tree, normals = KDTree(points), np.empty_like(points)
    for first in range(0, len(points), BATCH):
        tick(20 + 240 * first // len(points))
        some = slice(first, first + BATCH)
        around = points[tree.query(points[some], min(NEIGHBOURS, len(points)))[1]]
        around = around - around.mean(axis=1, keepdims=True)
        normals[some] = np.linalg.eigh(np.einsum("nki,nkj->nij", around, around))[1][:, :, 0]
    return np.concatenate([points + radius_m * normals, points - radius_m * normals])


def _line(middles: Array, counts: Array, radius_m: float) -> tuple[Array, Array] | None:
    """Place and direction of the line with the most crowded cells on it, by trying pairs."""
    if len(middles) < 2:
        return None
    rng = np.random.default_rng(len(middles))
    best, line = 0.0, None
    for i, j in rng.choice(len(middles), (TRIES, 2), p=counts / counts.sum()):
        step = middles[j] - middles[i]
        length = float(np.linalg.norm(step))
        if not NEAREST_PAIR * radius_m < length < FARTHEST_PAIR * radius_m:
            continue
        direction = step / length
        score = float(counts[_off(middles, middles[i], direction) < WITHIN * radius_m].sum())
        if score > best:
            best, line = score, (middles[i], direction)
    return line


def _off(points: Array, place: Array, direction: Array) -> Array:
    """(n,) distances of points from a line."""
    away = points - place
    along = away @ direction
    return np.asarray(np.sqrt(np.maximum(np.sum(away**2, axis=1) - along**2, 0)))


def _stretch(along: Array, radius_m: float) -> tuple[float, float]:
    """The stretch with the most points that is nowhere empty for long: walls lie across the axis as well."""
    ordered = np.sort(along)
    breaks = np.flatnonzero(np.diff(ordered) > GAP * radius_m)
    parts = np.split(ordered, breaks + 1)
    best = max(parts, key=len)
    return float(best[0]), float(best[-1])


def _fitted(points: Array, place: Array, direction: Array, radius_m: float) -> FoundCable | None:
    for reach in (0.4, 0.2):
        on = points[np.abs(_off(points, place, direction) - radius_m) < reach * radius_m]
        if len(on) < LEAST_POINTS:
            return None
        try:
            tube = fit_cylinder(on[:: len(on) // 20_000 + 1], direction=direction)
        except StageError:  # what lies there is no tube
            return None
        place, direction = tube.point, tube.direction
    first, last = _stretch((on - place) @ direction, radius_m)
    if abs(tube.radius / radius_m - 1) > ALIKE or last - first < LEAST_LENGTH * radius_m:
        return None
    return FoundCable(
        place=place,
        direction=direction,
        radius_m=float(tube.radius),
        first_m=float(first),
        last_m=float(last),
    )
