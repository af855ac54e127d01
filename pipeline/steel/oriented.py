"""The points the search looks at: one in each small cube, with the surface's normal, planes left out.

Takes points with their stations; gives points with outward unit normals (towards the scanner that saw them).
Leaves out what they lie on.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from pipeline.core.vocabulary import Array
from pipeline.steel.tile_records import SitePoints
from pipeline.steel.vectors import dots

NEIGHBOURS = 20
"""A normal rests on this many neighbours."""
CUBE_M = 0.2
"""Planes are looked for in cubes of this size."""
BATCH = 15_000
"""Normals computed at once."""


@dataclass(frozen=True)
class Oriented:
    """Points and normals, (n, 3) each, and the tree over the points."""

    places: Array
    normals: Array
    tree: KDTree


def oriented(
    points: SitePoints, scanners: Array, spacing_m: float, noise_m: float, tick: Callable[[], None]
) -> Oriented | None:
    """Thin the points, leave out planes, and find normals; None where too few points are left.

    Args:
        points: of one tile and its margin.
        scanners: (k, 3) centres of the stations, metres, site frame.
        spacing_m: edge of the cubes of which one point is kept.
        noise_m: of a point.
        tick: called between batches.
    """
    few = points.where(one_in_each_cube(points.places, spacing_m))
    # twice, the cubes shifted: where a plane cuts off a corner of a cube, too little of it is in there
    for shift_m in (0.0, 0.5 * CUBE_M):
        few = few.where(~_in_planes(few.places, noise_m, spacing_m, shift_m))
    if len(few) < 2 * NEIGHBOURS:
        return None
    tree = KDTree(few.places)
    normals = np.empty_like(few.places)
    for first in range(0, len(few), BATCH):
        tick()
        mine = slice(first, first + BATCH)
        _, near = tree.query(few.places[mine], NEIGHBOURS)
        around = few.places[near]
        around = around - around.mean(axis=1, keepdims=True)
        _, vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", around, around))
        normal = vectors[:, :, 0]
        to_scanner = scanners[few.stations[mine]] - few.places[mine]
        normals[mine] = normal * np.where(dots(normal, to_scanner) < 0, -1.0, 1.0)[:, None]
    return Oriented(few.places, normals, tree)


def one_in_each_cube(places: Array, edge_m: float) -> NDArray[np.int64]:
    """Indices of one point in each cube, chosen by the points' order (not by their place in the cube)."""
    if not len(places):
        return np.zeros(0, dtype=np.int64)
    _, first = np.unique(_cube_numbers(places, edge_m), return_index=True)
    return np.sort(first)


def _cube_numbers(places: Array, edge_m: float) -> NDArray[np.int64]:
    cubes = np.floor(places / edge_m).astype(np.int64)
    cubes -= cubes.min(axis=0)
    size = cubes.max(axis=0) + 1
    return (cubes[:, 0] * size[1] + cubes[:, 1]) * size[2] + cubes[:, 2]


def _in_planes(places: Array, noise_m: float, spacing_m: float, shift_m: float) -> NDArray[np.bool_]:
    """Points of cubes whose points fill a thin, wide layer: floor, walls, sides of boxes."""
    if not len(places):
        return np.zeros(0, dtype=bool)
    _, cube = np.unique(_cube_numbers(places + shift_m, CUBE_M), return_inverse=True)
    count = np.bincount(cube)
    mean = np.stack([np.bincount(cube, p) for p in places.T], axis=1) / count[:, None]
    away = places - mean[cube]
    moments = np.empty((len(count), 3, 3))
    for i in range(3):
        for j in range(3):
            moments[:, i, j] = np.bincount(cube, away[:, i] * away[:, j]) / count
    spread = np.sqrt(np.maximum(np.linalg.eigvalsh(moments), 0))
    # of a full cube: a plane spreads by 0.29 of its edge; a layer of cubes of the search is a little thicker
    thin = spread[:, 0] < 1.3 * np.hypot(noise_m, 0.29 * spacing_m)
    flat = thin & (spread[:, 1] > 0.2 * CUBE_M) & (count > 7)
    return np.asarray(flat[cube])
