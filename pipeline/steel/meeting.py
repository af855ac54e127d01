"""Where rods meet: places at which the axes of two or more come together near their ends.

Takes rough rods; gives places where a ball is worth looking for.  Leaves out whether there is one.
"""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from pipeline.core.vocabulary import Array
from pipeline.steel.segments import Pieces

REACH_M = 0.6
"""A rod's seen end is at most this far from its node: the ball's radius, and what is hidden before it."""
MISS_M = 0.06
"""Axes that meet in a node pass each other by less than this."""


def meeting_places(pieces: Pieces) -> Array:
    """Places (n, 3), metres, where the axes of at least two pieces meet beyond their ends."""
    if len(pieces) < 2:
        return np.zeros((0, 3))
    lengths = np.linalg.norm(pieces.ends - pieces.starts, axis=1)
    axes = (pieces.ends - pieces.starts) / lengths[:, None]
    ends = np.concatenate([pieces.starts, pieces.ends])
    outward = np.concatenate([-axes, axes])
    pairs = KDTree(ends).query_pairs(2 * REACH_M, output_type="ndarray")
    pairs = pairs[pairs[:, 0] % len(pieces) != pairs[:, 1] % len(pieces)]
    if not len(pairs):
        return np.zeros((0, 3))
    (i, j), step = pairs.T, ends[pairs[:, 1]] - ends[pairs[:, 0]]
    cosine = np.sum(outward[i] * outward[j], axis=1)
    # feet of the common perpendicular, as distances beyond the ends
    with np.errstate(divide="ignore", invalid="ignore"):
        s, t = np.sum(step * outward[i], axis=1), np.sum(step * outward[j], axis=1)
        first, second = (s - cosine * t) / (1 - cosine**2), (cosine * s - t) / (1 - cosine**2)
        feet = ends[i] + first[:, None] * outward[i], ends[j] + second[:, None] * outward[j]
    crossing = np.abs(cosine) < np.cos(np.radians(15))
    crossing &= np.linalg.norm(feet[0] - feet[1], axis=1) < MISS_M
    crossing &= (np.minimum(first, second) > -0.1) & (np.maximum(first, second) < REACH_M)
    places = 0.5 * (feet[0] + feet[1])[crossing]
    return _clusters(places, 0.1)


def _clusters(places: Array, apart_m: float) -> Array:
    """Medians of places that lie together."""
    if not len(places):
        return np.zeros((0, 3))
    pairs = KDTree(places).query_pairs(apart_m, output_type="ndarray").reshape(-1, 2)
    graph = coo_array((np.ones(len(pairs)), pairs.T), shape=(len(places), len(places)))
    count, label = connected_components(graph, directed=False)
    return np.array([np.median(places[label == k], axis=0) for k in range(count)])
