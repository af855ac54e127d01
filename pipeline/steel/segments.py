"""Pieces of cylinders in one tile: no size, no direction need be known.

Takes oriented points; gives straight pieces with axis and radius, good enough to gather their points.  For
seeds spread over the surface, the normals around each tell its kind (their image on the Gauss sphere is a
point for a plane, an arc of a great circle for a cylinder, a cap for a sphere); the axis is the direction the
normals avoid, and centre and radius solve p - r n = c, all reweighted so that other figures nearby drop out.
Seeds that agree make a piece.  Leaves out pieces that go on in the next tile, see rods.py.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from pipeline.core.vocabulary import Array
from pipeline.steel.oriented import Oriented, one_in_each_cube
from pipeline.steel.vectors import dots, lengths

AROUND = 96
"""A seed looks at this many of its neighbours."""
SEED_BATCH = 400
"""Seeds worked on at once."""
LEAST_AROUND = 20
"""Fewer points around a seed tell nothing."""
LEAST_ARC = 0.012
"""Least share of the normals' scatter across their mean: an arc some 35 degrees wide."""
LINK = 1.4
"""Seeds of one piece lie this close to their neighbours, in units of the neighbourhood's reach."""


@dataclass(frozen=True, kw_only=True)
class Pieces:
    """Straight cylindrical pieces.

    Attributes:
        starts, ends: (n, 3) of the axes, metres, site frame.
        radii_m: (n,).
        seeds: (n,) how many seeds agreed.
    """

    starts: Array
    ends: Array
    radii_m: Array
    seeds: Array

    def __len__(self) -> int:
        return len(self.starts)


@dataclass(frozen=True, kw_only=True)
class Window:
    """Radii looked for: (lower, upper) metres each."""

    ranges: tuple[tuple[float, float], ...]

    def holds(self, radii: Array) -> NDArray[np.bool_]:
        """Which radii lie in one of the ranges; (n,) bool."""
        return np.any([(radii >= low) & (radii <= high) for low, high in self.ranges], axis=0)


def find_pieces(
    points: Oriented, window: Window, reach_m: float, noise_m: float, tick: Callable[[], None]
) -> Pieces:
    """Find the pieces of cylinders among oriented points; ``tick`` is called between batches."""
    seeds = one_in_each_cube(points.places, 0.5 * reach_m)
    parts = []
    for first in range(0, len(seeds), SEED_BATCH):
        tick()
        parts.append(_local_cylinders(points, seeds[first : first + SEED_BATCH], reach_m, noise_m))
    centres, axes, radii = (np.concatenate(part) for part in zip(*parts, strict=True))
    good = window.holds(radii)
    return _agreeing(centres[good], axes[good], radii[good], LINK * reach_m)


def _local_cylinders(
    points: Oriented, seeds: NDArray[np.int64], reach_m: float, noise_m: float
) -> tuple[Array, ...]:
    """Cylinder around each seed that has one: (m, 3) centre beside the seed, (m, 3) axis, (m,) radius."""
    index, present = _around(points, seeds, reach_m)
    weight: Array
    place = points.places[index] - points.places[seeds][:, None]
    normal = points.normals[index]
    # the seed's own surface first: points near it, with normals near its own
    weight = present.astype(float) * np.exp(-0.5 * dots(place, place) / (0.6 * reach_m) ** 2)
    weight = weight * (np.squeeze(normal @ points.normals[seeds][:, :, None], axis=2) > -0.2)
    curved = (present.sum(axis=1) >= LEAST_AROUND) & (_spectrum(normal, weight)[0][:, 1] > 0.5 * LEAST_ARC)
    present, seeds = present[curved], seeds[curved]
    place, normal, weight = place[curved], normal[curved], weight[curved]
    scale = max(3.0 * noise_m, 0.004)
    # weights narrow from turn to turn: others nearby drop out one after the other
    for width, lean in ((3.0, 0.5), (3.0, 0.5), (1.0, 0.25), (1.0, 0.25), (1.0, 0.25)):
        spectrum, vectors = _spectrum(normal, weight)
        axis, flat = vectors[:, :, 0], vectors[:, :, 1:]
        q, m = place @ flat, normal @ flat
        centre, radius = _circles(q, m, weight)
        away = q - centre[:, None]
        length = lengths(away)
        distance = length - radius[:, None]
        tilt = np.squeeze(normal @ axis[:, :, None], axis=2) / lean
        weight = (
            np.clip(1 - (distance / (width * scale)) ** 2, 0, None) ** 2 * np.clip(1 - tilt**2, 0, None) ** 2
        )
        weight *= present * (dots(m, away) > 0)
        weight[weight.sum(axis=1) < 1e-6] = 1e-12
    total = weight.sum(axis=1)
    share = np.sum((weight > 0.1) & present, axis=1) / np.maximum(present.sum(axis=1), 1)
    miss = np.sqrt(np.sum(weight * distance**2, axis=1) / np.maximum(total, 1e-9))
    good = (share > 0.4) & (miss < 0.7 * scale) & (radius > 0)
    # an arc of normals, and next to no normal along the axis
    good &= (spectrum[:, 1] > LEAST_ARC) & (spectrum[:, 0] < 0.3 * spectrum[:, 1]) & (spectrum[:, 0] < 0.03)
    beside = points.places[seeds] + np.squeeze(flat @ centre[:, :, None], axis=2)
    return beside[good], axis[good], radius[good]


def _around(
    points: Oriented, seeds: NDArray[np.int64], reach_m: float
) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Indices (m, AROUND) of points near each seed, and which of these places are filled."""
    near = points.tree.query_ball_point(points.places[seeds], reach_m, return_sorted=False)
    index = np.zeros((len(seeds), AROUND), dtype=np.int64)
    present = np.zeros((len(seeds), AROUND), dtype=bool)
    for row, inside in enumerate(near):
        found: list[int] = inside  # type: ignore[assignment]
        if len(found) > AROUND:
            found = [found[k * len(found) // AROUND] for k in range(AROUND)]
        index[row, : len(found)] = found
        present[row, : len(found)] = True
    return index, present


def _spectrum(normal: Array, weight: Array) -> tuple[Array, Array]:
    """Shares (n, 3), ascending, and eigenvectors (n, 3, 3) of the normals' weighted scatter about zero."""
    values, vectors = np.linalg.eigh(np.swapaxes(normal, 1, 2) @ (weight[:, :, None] * normal))
    return values / np.maximum(values.sum(axis=1), 1e-12)[:, None], vectors


def _circles(q: Array, m: Array, weight: Array) -> tuple[Array, Array]:
    """Centres (n, 2) and radii (n,) that solve q - r m = c in the mean; a negative radius is a hollow."""
    total = np.maximum(weight.sum(axis=1), 1e-12)[:, None]
    w = weight[:, None, :]
    q_mean, m_mean = np.squeeze(w @ q, axis=1) / total, np.squeeze(w @ m, axis=1) / total
    dm = (m - m_mean[:, None]) * weight[:, :, None]
    both, own = np.sum(dm * q, axis=(1, 2)), np.sum(dm * m, axis=(1, 2))
    radius = both / np.maximum(own, 1e-9)
    return q_mean - radius[:, None] * m_mean, radius


def _agreeing(centres: Array, axes: Array, radii: Array, link_m: float) -> Pieces:
    """Join seeds whose cylinders are the same, and not farther apart than ``link_m``, into pieces."""
    if len(centres) < 3:
        return _pieces([])
    pairs = KDTree(centres).query_pairs(link_m, output_type="ndarray")
    i, j = pairs.T
    step = centres[j] - centres[i]
    across_i = lengths(step - dots(step, axes[i])[:, None] * axes[i])
    across_j = lengths(step - dots(step, axes[j])[:, None] * axes[j])
    cosine = np.abs(dots(axes[i], axes[j]))
    ratio = np.maximum(radii[i], radii[j]) / np.minimum(radii[i], radii[j])
    small = np.minimum(radii[i], radii[j])
    same = (cosine > np.cos(np.radians(14))) & (np.maximum(across_i, across_j) < 0.4 * small + 0.005)
    same &= ratio < 1.4
    graph = coo_array((np.ones(same.sum()), (i[same], j[same])), shape=(len(centres), len(centres)))
    _, label = connected_components(graph, directed=False)
    order = np.argsort(label, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(label[order])) + 1)
    return _pieces([_piece(centres[g], radii[g]) for g in groups if len(g) >= 4])


def _piece(centres: Array, radii: Array) -> tuple[Array, Array, float, int]:
    """Straight piece through the centres of agreeing seeds."""
    middle = np.median(centres, axis=0)
    _, _, vectors = np.linalg.svd(centres - middle, full_matrices=False)
    axis = vectors[0]
    along = (centres - middle) @ axis
    radius = float(np.median(radii))
    return middle + along.min() * axis, middle + along.max() * axis, radius, len(centres)


def _pieces(found: list[tuple[Array, Array, float, int]]) -> Pieces:
    return Pieces(
        starts=np.array([p[0] for p in found]).reshape(-1, 3),
        ends=np.array([p[1] for p in found]).reshape(-1, 3),
        radii_m=np.array([p[2] for p in found]),
        seeds=np.array([p[3] for p in found], dtype=float),
    )
