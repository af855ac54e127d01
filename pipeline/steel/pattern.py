"""A few places found again among many, by their mutual distances alone.

Takes the places of one station and a map; gives the motion that brings most of them onto the map, how many,
and how many the best other motion brings.  Leaves out names and the growth of the map (``naming.py``).

Two places of a levelled station and two of the map with the same distance and height difference propose a
turn about z and a shift; without a plumb axis a third one is added whose distances agree as well.  Every
proposal is counted on all places.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from pipeline.core.vocabulary import Array

MOST_SEEDS = 16
"""Places of the station that propose motions: the best measured ones."""
MOST_PROPOSALS = 60_000
PROPOSALS_PER_RUN = 4000
OTHER_PLACE_M = 0.3
"""Motions that put the station farther apart than this are different ones; nearer ones may be the same."""
LEAST_BASE_M = 0.5
"""Two places nearer than this do not hold a direction."""


@dataclass(frozen=True, kw_only=True)
class Fit:
    """How a station's places lie on the map.

    Attributes:
        rotation, translation: (3, 3), (3,) map_from_station.
        partner: (n,) number of the place of the map, -1 without.
        count: places with a partner.
        rival: the same of the best motion that puts the station elsewhere.
    """

    rotation: Array
    translation: Array
    partner: NDArray[np.int64]
    count: int
    rival: int


def find_pattern(places: Array, known: Array, tolerance_m: float, *, level: bool) -> Fit | None:
    """Find places (n, 3) of a station on the map ``known`` (m, 3); None where not even three agree.

    Args:
        places: station frame, metres, the best measured first.
        known: map frame, metres.
        tolerance_m: how far places may lie apart.
        level: both z axes are plumb.
    """
    if len(places) < 3 or len(known) < 3:
        return None
    source, target = (_level_pairs if level else _triples)(places[:MOST_SEEDS], known, tolerance_m)
    if not len(source):
        return None
    tree = cKDTree(known)
    rotations, translations = (_level_motions if level else _motions)(places[source], known[target])
    counts = np.concatenate(
        [
            _count(places, rotations[run], translations[run], tree, tolerance_m)
            for run in _runs(len(rotations))
        ]
    )
    best = int(np.argmax(counts))
    rotation, translation, partner = _refined(
        places, known, rotations[best], translations[best], tree, tolerance_m
    )
    elsewhere = np.linalg.norm(translations - translation, axis=1) > OTHER_PLACE_M
    turned = np.einsum("nij,ij->n", rotations, rotation) < 1 + 2 * np.cos(np.radians(3.0))
    rivals = counts[elsewhere | turned]
    count = int((partner >= 0).sum())
    if count < 3:
        return None
    return Fit(
        rotation=rotation,
        translation=translation,
        partner=partner,
        count=count,
        rival=int(rivals.max()) if len(rivals) else 0,
    )


def _level_pairs(
    places: Array, known: Array, tolerance_m: float
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Pairs (p, 2) of places and of the map that agree in distance and height difference."""
    mine, theirs = _pairs(len(places)), _pairs(len(known), both=True)
    first, second = (x[p[:, 1]] - x[p[:, 0]] for x, p in ((places, mine), (known, theirs)))
    key_mine, key_theirs = (np.column_stack([np.hypot(d[:, 0], d[:, 1]), d[:, 2]]) for d in (first, second))
    wide = key_mine[:, 0] > LEAST_BASE_M
    return _agreeing(mine[wide], key_mine[wide], theirs, key_theirs, tolerance_m)


def _triples(places: Array, known: Array, tolerance_m: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Triangles (p, 3) of places and of the map whose three sides agree."""
    n, m = len(places), len(known)
    D, K = (np.linalg.norm(x[:, None] - x[None], axis=2) for x in (places, known))
    i, j, k = (index.ravel() for index in np.meshgrid(*[np.arange(n)] * 3, indexing="ij"))
    ordered = (i < j) & (j < k)
    mine = np.column_stack([i, j, k])[ordered]
    key_mine = np.column_stack(
        [D[mine[:, 0], mine[:, 1]], D[mine[:, 1], mine[:, 2]], D[mine[:, 0], mine[:, 2]]]
    )
    wide = _area(places[mine]) > LEAST_BASE_M**2
    theirs = _near_triples(K, float(D.max()) + tolerance_m) if m > 40 else _all_triples(m)
    key_theirs = np.column_stack(
        [K[theirs[:, 0], theirs[:, 1]], K[theirs[:, 1], theirs[:, 2]], K[theirs[:, 0], theirs[:, 2]]]
    )
    return _agreeing(mine[wide], key_mine[wide], theirs, key_theirs, tolerance_m)


def _all_triples(m: int) -> NDArray[np.int64]:
    a, b, c = (index.ravel() for index in np.meshgrid(*[np.arange(m)] * 3, indexing="ij"))
    return np.column_stack([a, b, c])[(a != b) & (b != c) & (a != c)]


def _near_triples(K: Array, reach_m: float) -> NDArray[np.int64]:
    """Ordered triples of a large map, each of whose sides is within reach and among the shortest."""
    reach = min(reach_m, float(np.sort(K, axis=1)[:, min(24, K.shape[1] - 1)].max()))
    found = []
    for a in range(len(K)):
        near = np.flatnonzero((K[a] < reach) & (K[a] > 0))
        b, c = (index.ravel() for index in np.meshgrid(near, near, indexing="ij"))
        keep = (b != c) & (K[b, c] < reach)
        found.append(np.column_stack([np.full(int(keep.sum()), a), b[keep], c[keep]]))
    return np.concatenate(found)


def _pairs(count: int, *, both: bool = False) -> NDArray[np.int64]:
    a, b = (index.ravel() for index in np.meshgrid(np.arange(count), np.arange(count), indexing="ij"))
    return np.column_stack([a, b])[(a != b) if both else (a < b)]


def _agreeing(
    mine: NDArray[np.int64], key_mine: Array, theirs: NDArray[np.int64], key_theirs: Array, tolerance_m: float
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    if not len(mine) or not len(theirs):
        return mine[:0], theirs[:0]
    hits: Any = cKDTree(key_theirs).query_ball_point(key_mine, 2 * tolerance_m, p=np.inf)
    source = np.repeat(np.arange(len(mine)), [len(hit) for hit in hits])
    target = np.concatenate([np.asarray(hit, dtype=np.int64) for hit in hits])
    if len(source) > MOST_PROPOSALS:
        kept = np.linspace(0, len(source) - 1, MOST_PROPOSALS).astype(np.int64)
        source, target = source[kept], target[kept]
    return mine[source], theirs[target]


def _level_motions(source: Array, target: Array) -> tuple[Array, Array]:
    """Turn about z and shift (p, ...) of pairs (p, 2, 3)."""
    a, b = source[:, 1] - source[:, 0], target[:, 1] - target[:, 0]
    angle = np.arctan2(b[:, 1], b[:, 0]) - np.arctan2(a[:, 1], a[:, 0])
    R = np.zeros((len(a), 3, 3))
    R[:, 0, 0] = R[:, 1, 1] = np.cos(angle)
    R[:, 1, 0], R[:, 0, 1], R[:, 2, 2] = np.sin(angle), -np.sin(angle), 1
    return R, target.mean(axis=1) - np.einsum("nij,nj->ni", R, source.mean(axis=1))


def _motions(source: Array, target: Array) -> tuple[Array, Array]:
    """Motions (p, ...) of triangles (p, 3, 3): Umeyama 1991, many at once."""
    source_centre, target_centre = source.mean(axis=1), target.mean(axis=1)
    x, y = source - source_centre[:, None], target - target_centre[:, None]
    left, _, right = np.linalg.svd(y.transpose(0, 2, 1) @ x)
    signs = np.ones((len(x), 3))
    signs[:, 2] = np.sign(np.linalg.det(left) * np.linalg.det(right))
    R = (left * signs[:, None, :]) @ right
    return R, target_centre - np.einsum("nij,nj->ni", R, source_centre)


def _count(
    places: Array, rotations: Array, translations: Array, tree: cKDTree, tolerance_m: float
) -> NDArray[np.int64]:
    moved = places @ rotations.transpose(0, 2, 1) + translations[:, None]
    distance, _ = tree.query(moved, distance_upper_bound=2 * tolerance_m)
    counted: NDArray[np.int64] = np.isfinite(distance).sum(axis=1)
    return counted


def _refined(
    places: Array, known: Array, rotation: Array, translation: Array, tree: cKDTree, tolerance_m: float
) -> tuple[Array, Array, NDArray[np.int64]]:
    """The motion by all partners, and who they are; of two that want the same partner the nearer has it."""
    partner = np.full(len(places), -1)
    for bound in (2 * tolerance_m, 2 * tolerance_m, 1.5 * tolerance_m):
        found = tree.query(places @ rotation.T + translation, distance_upper_bound=bound)
        distance, nearest = np.asarray(found[0]), np.asarray(found[1])
        partner = np.full(len(places), -1)
        taken: set[int] = set()
        for n in np.argsort(distance):
            if np.isfinite(distance[n]) and int(nearest[n]) not in taken:
                partner[n] = nearest[n]
                taken.add(int(nearest[n]))
        has = partner >= 0
        if has.sum() < 3:
            break
        R, t = _motions(places[has][None], known[partner[has]][None])
        rotation, translation = R[0], t[0]
    return rotation, translation, partner


def _area(triangles: Array) -> Array:
    sides = triangles[:, 1:] - triangles[:, :1]
    return np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) / 2


def _runs(count: int) -> list[slice]:
    return [slice(first, first + PROPOSALS_PER_RUN) for first in range(0, count, PROPOSALS_PER_RUN)]
