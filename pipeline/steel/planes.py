"""Large planes in the cloud of one station: floors, walls, sides of boxes and girders.

Takes the station's points; gives fitted planes, the largest first.  Small cubes whose points fill a thin
layer vote: of many seeds the plane that most cubes lie on is taken, its cubes are set aside, and so on
until what is left is small.  Leaves out the exact fit (``plane_fit.py``).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.core.vocabulary import Array
from pipeline.steel.plane_fit import FittedPlane, fit_plane, frame_along
from pipeline.steel.survey_records import Scanner

CUBE_M = 0.4
LEAST_POINTS = 10
"""A cube with fewer tells no plane."""
WIDE = 0.15
"""The points of a cube spread over it by this part of its edge at least, both ways."""
MOST_POINTS = 1_000_000
SEEDS = 80
"""Cubes tried as the beginning of the next plane."""
FACING = np.cos(np.radians(10))
"""Cosine up to which a cube's normal agrees with a plane's."""
NEAR_M = (0.05, 0.02, 0.02)
"""How far the middle of a cube may be off the plane, pass by pass."""
MOST_PLANES = 40


@dataclass(frozen=True)
class _Layers:
    """Cubes that hold a thin layer: middles (n, 3), normals (n, 3), points (n,), second moments (n, 3, 3)."""

    middles: Array
    normals: Array
    counts: Array
    moments: Array

    def where(self, chosen: NDArray[np.bool_]) -> "_Layers":
        return _Layers(*(part[chosen] for part in (self.middles, self.normals, self.counts, self.moments)))


def find_planes(
    points: NDArray[np.float32],
    scanner: Scanner,
    least_area_m2: float,
    floor_m: float,
    tick: Callable[[int, int], None],
) -> tuple[FittedPlane, ...]:
    """Find the planes of at least an area in a station's points (n, 3), metres; the largest first.

    Args:
        points: station frame.
        scanner: its noise.
        least_area_m2: smaller ones are left.
        floor_m: no plane is taken to be better known than this.
        tick: called with (done, total) before each plane.
    """
    few = np.asarray(points[:: len(points) // MOST_POINTS + 1], dtype=float)
    left = _layers(few, scanner)
    rng = np.random.default_rng(len(few))
    found = []
    for number in range(MOST_PLANES):
        tick(number, MOST_PLANES)
        if len(left.counts) * CUBE_M**2 < least_area_m2:
            break
        plane = _largest(left, rng)
        if plane is None or plane[2].sum() * CUBE_M**2 < 0.7 * least_area_m2:
            break
        place, normal, on = plane
        fitted = fit_plane(
            few,
            place,
            frame_along(-np.sign(normal @ place) * normal),
            left.middles[on],
            CUBE_M,
            scanner,
            floor_m,
        )
        if fitted is not None and fitted.area_m2 >= least_area_m2:
            found.append(fitted)
        left = left.where(~on)
    return tuple(sorted(found, key=lambda plane: -plane.area_m2))


def _layers(points: Array, scanner: Scanner) -> _Layers:
    cubes = np.floor(points / CUBE_M).astype(np.int64)
    cubes -= cubes.min(axis=0)
    size = cubes.max(axis=0) + 1
    _, cube, counts = np.unique(
        (cubes[:, 0] * size[1] + cubes[:, 1]) * size[2] + cubes[:, 2], return_inverse=True, return_counts=True
    )
    middles = np.stack([np.bincount(cube, column) for column in points.T], axis=1) / counts[:, None]
    away = points - middles[cube]
    moments = np.empty((len(counts), 3, 3))
    for i in range(3):
        for j in range(3):
            moments[:, i, j] = np.bincount(cube, away[:, i] * away[:, j])
    values, vectors = np.linalg.eigh(moments / counts[:, None, None])
    spread = np.sqrt(np.maximum(values, 0))
    noise = np.hypot(scanner.range_sigma_m, np.linalg.norm(middles, axis=1) * scanner.angle_sigma_rad)
    thin = spread[:, 0] < np.maximum(2.0 * noise, 0.004)
    good = (counts >= LEAST_POINTS) & thin & (spread[:, 1] > WIDE * CUBE_M)
    return _Layers(middles, vectors[:, :, 0], counts.astype(float), moments).where(good)


def _largest(layers: _Layers, rng: np.random.Generator) -> tuple[Array, Array, NDArray[np.bool_]] | None:
    """Place, normal and cubes of the plane that most cubes lie on."""
    seeds = rng.choice(len(layers.counts), min(SEEDS, len(layers.counts)), replace=False)
    facing = np.abs(layers.normals @ layers.normals[seeds].T) > FACING
    off = layers.middles @ layers.normals[seeds].T - np.sum(
        layers.middles[seeds] * layers.normals[seeds], axis=1
    )
    # a cube's own normal is good to a degree or so: the plane may run off with the distance
    away = np.linalg.norm(layers.middles[:, None] - layers.middles[seeds][None], axis=2)
    on = facing & (np.abs(off) < NEAR_M[0] + 0.01 * away)
    seed = int(np.argmax(on.sum(axis=0)))
    chosen = on[:, seed]
    for near_m in NEAR_M:
        if chosen.sum() < 3:
            return None
        place, normal = _through(layers.where(chosen))
        chosen = (np.abs(layers.normals @ normal) > FACING) & (
            np.abs((layers.middles - place) @ normal) < near_m
        )
    return place, normal, chosen


def _through(layers: _Layers) -> tuple[Array, Array]:
    """The plane through the points of some cubes, all cubes counting alike."""
    place = layers.middles.mean(axis=0)
    away = layers.middles - place
    moments = away.T @ away + np.einsum("nij,n->ij", layers.moments, 1 / layers.counts)
    return place, np.linalg.eigh(moments)[1][:, 0]
