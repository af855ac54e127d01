"""Pieces of cylinders that are one: across tiles, and across places where a member is hidden.

Takes the pieces of all tiles; gives whole ones.  Leaves out their exact fit, see rods.py.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from pipeline.core.vocabulary import Array
from pipeline.steel.segments import Pieces

FACING = np.cos(np.radians(15))
"""Cosine up to which two pieces run the same way; short pieces know their direction badly."""


def join_pieces(pieces: Pieces, gap_m: float, barriers: Array, barrier_m: float) -> Pieces:
    """Join pieces of the same cylinder.

    Args:
        pieces: of all tiles.
        gap_m: longest stretch between two pieces of one member.
        barriers: (n, 3) places that no member goes through: the ball nodes; metres, site frame.
        barrier_m: no member goes through their surroundings of this radius.
    """
    if len(pieces) < 2:
        return pieces
    pairs = _near(pieces, gap_m)
    same = [(i, j) for i, j in pairs if _is_one(pieces, i, j, gap_m, barriers, barrier_m)]
    graph = np.array(same, dtype=np.int64).reshape(-1, 2)
    _, label = connected_components(
        coo_array((np.ones(len(graph)), graph.T), shape=(len(pieces), len(pieces))), directed=False
    )
    order = np.argsort(label, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(label[order])) + 1)
    joined = [_joined(pieces, g) for g in groups]
    return Pieces(
        starts=np.array([p[0] for p in joined]),
        ends=np.array([p[1] for p in joined]),
        radii_m=np.array([p[2] for p in joined]),
        seeds=np.array([p[3] for p in joined]),
    )


def longer_than(pieces: Pieces, least_m: float) -> Pieces:
    """The pieces of at least this length."""
    keep = np.linalg.norm(pieces.ends - pieces.starts, axis=1) >= least_m
    return chosen(pieces, np.flatnonzero(keep))


def chosen(pieces: Pieces, index: NDArray[np.int64]) -> Pieces:
    """Some of the pieces."""
    return Pieces(
        starts=pieces.starts[index],
        ends=pieces.ends[index],
        radii_m=pieces.radii_m[index],
        seeds=pieces.seeds[index],
    )


def all_pieces(parts: list[Pieces]) -> Pieces:
    """The pieces of all parts."""
    return Pieces(
        starts=np.concatenate([np.zeros((0, 3)), *[p.starts for p in parts]]),
        ends=np.concatenate([np.zeros((0, 3)), *[p.ends for p in parts]]),
        radii_m=np.concatenate([np.zeros(0), *[p.radii_m for p in parts]]),
        seeds=np.concatenate([np.zeros(0), *[p.seeds for p in parts]]),
    )


def _near(pieces: Pieces, gap_m: float) -> list[tuple[int, int]]:
    """Pairs of pieces whose axes come near each other: points every quarter metre of each are compared."""
    samples, owner = [], []
    for number, (a, b) in enumerate(zip(pieces.starts, pieces.ends, strict=True)):
        steps = np.linspace(0, 1, int(np.ceil(np.linalg.norm(b - a) / 0.25)) + 1)[:, None]
        samples.append(a + steps * (b - a))
        owner.append(np.full(len(steps), number))
    tree, owners = KDTree(np.concatenate(samples)), np.concatenate(owner)
    found = owners[tree.query_pairs(gap_m + 0.25, output_type="ndarray")]
    found = np.unique(np.sort(found[found[:, 0] != found[:, 1]], axis=1), axis=0)
    return [(int(i), int(j)) for i, j in found]


def _is_one(pieces: Pieces, i: int, j: int, gap_m: float, barriers: Array, barrier_m: float) -> bool:
    """Tell whether two pieces lie on one cylinder, with nothing between them that ends members."""
    lengths = [float(np.linalg.norm(pieces.ends[k] - pieces.starts[k])) for k in (i, j)]
    long, short = (i, j) if lengths[0] >= lengths[1] else (j, i)
    radii = pieces.radii_m[[i, j]]
    axis = (pieces.ends[long] - pieces.starts[long]) / max(lengths)
    other = pieces.ends[short] - pieces.starts[short]
    if radii.max() > 1.4 * radii.min():
        return False
    # a piece not longer than it is thick has no direction of its own
    if min(lengths) > 2 * radii.min() and abs(other @ axis) < FACING * np.linalg.norm(other):
        return False
    ends = np.stack([pieces.starts[short], pieces.ends[short]]) - pieces.starts[long]
    along = ends @ axis
    across = np.linalg.norm(ends - along[:, None] * axis, axis=1)
    beyond = np.maximum(np.maximum(-along, along - max(lengths)), 0)
    gap = float(beyond.min()) if (along.min() > max(lengths) or along.max() < 0) else 0.0
    if gap > gap_m or (across > 0.4 * radii.min() + 0.005 + 0.03 * beyond).any():
        return False
    if gap == 0.0 or not len(barriers):
        return True
    near_end = pieces.starts[long] + np.clip(along[np.argmin(beyond)], 0, max(lengths)) * axis
    far_end = near_end + np.sign(along[np.argmin(beyond)]) * gap * axis
    step = far_end - near_end
    foot = near_end + np.clip((barriers - near_end) @ step / (step @ step), 0, 1)[:, None] * step
    return bool((np.linalg.norm(barriers - foot, axis=1) > barrier_m).all())


def _joined(pieces: Pieces, group: NDArray[np.int64]) -> tuple[Array, Array, float, float]:
    """One piece over a group; its axis weighted with the seeds and lengths of its parts."""
    if len(group) == 1:
        k = int(group[0])
        return pieces.starts[k], pieces.ends[k], float(pieces.radii_m[k]), float(pieces.seeds[k])
    ends = np.concatenate([pieces.starts[group], pieces.ends[group]])
    weight = np.tile(pieces.seeds[group], 2)
    middle = np.average(ends, axis=0, weights=weight)
    _, _, vectors = np.linalg.svd((ends - middle) * np.sqrt(weight)[:, None], full_matrices=False)
    along = (ends - middle) @ vectors[0]
    radius = float(np.average(pieces.radii_m[group], weights=pieces.seeds[group]))
    first, last = middle + along.min() * vectors[0], middle + along.max() * vectors[0]
    return first, last, radius, float(pieces.seeds[group].sum())
