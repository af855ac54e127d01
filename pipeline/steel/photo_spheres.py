"""Spheres in a cloud whose unit is unknown: balls and targets in a photo model.

Takes points with normals; gives centres and radii in the cloud's own unit.  On a sphere, and on nothing else,
the normals of a small neighbourhood all pass through one point.  The neighbourhood's size doubles over the
whole range that the cloud can show.  Leaves out what the spheres are.

Source: the point nearest to a bundle of lines in the least-squares sense, (sum (I - n n^T)) c = sum (I - n
n^T) p; the spheres are then fitted by distances (:func:`pipeline.core.fits.fit_sphere`).
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from pipeline.core.errors import StageError
from pipeline.core.fits import fit_sphere
from pipeline.core.vocabulary import Array
from pipeline.steel.scanned_surface import cube_of, means

NEIGHBOURS = 40
MOST_SEEDS = 60_000
LEAST_SPREAD = 0.04
"""Smallest eigenvalue of the mean n n^T: a cap of 24 degrees has this much, a cylinder only its noise."""
LEAST_COVER = 0.10
"""Share of the sphere's surface that must be seen."""


def find_spheres(points: Array, normals: Array, tick: Callable[[], None]) -> Array:
    """(k, 4) centre and radius of spheres, the best covered first.

    Args:
        points, normals: (n, 3) in any unit; the sign of the normals does not matter.
        tick: called every half second or so.
    """
    spacing = _spacing(points)
    extent = float(np.linalg.norm(np.percentile(points, 98, axis=0) - np.percentile(points, 2, axis=0)))
    found: list[tuple[float, Array]] = []
    reach = 4 * spacing
    while reach < extent / 12:
        tick()
        found.extend(_of_size(points, normals, reach, tick))
        reach *= 1.5
    kept: list[Array] = []
    for _, sphere in sorted(found, key=lambda item: -item[0]):
        if all(np.linalg.norm(sphere[:3] - other[:3]) > 0.5 * max(sphere[3], other[3]) for other in kept):
            kept.append(sphere)
    return np.array(kept).reshape(-1, 4)


def _of_size(
    points: Array, normals: Array, reach: float, tick: Callable[[], None]
) -> list[tuple[float, Array]]:
    """Spheres about as large as the neighbourhood, each with the share of its surface that was seen."""
    edge = reach / 3.5
    cube = cube_of(points, edge)
    # a cube may hold two sides of something thin: its first point's normal decides which side it stands for
    first = np.zeros(int(cube.max()) + 1, dtype=np.int64)
    first[cube[::-1]] = np.arange(len(cube))[::-1]
    cosine = np.sum(normals * normals[first][cube], axis=1)
    same = np.abs(cosine) > 0.7
    places = means(points[same], cube[same])
    upright = means((normals * np.sign(cosine)[:, None])[same], cube[same])
    upright /= np.maximum(np.linalg.norm(upright, axis=1, keepdims=True), 1e-12)
    tree = KDTree(places)
    seeds = np.arange(len(places))[:: len(places) // MOST_SEEDS + 1]
    tick()
    centres, radii = _proposals(places, upright, tree, seeds, reach)
    tick()
    found = []
    while len(centres):
        near = KDTree(centres)
        votes = near.query_ball_point(centres, 0.15 * float(np.median(radii)), return_length=True)
        if votes.max() < 4:
            break
        top = int(np.argmax(votes))
        close = np.linalg.norm(centres - centres[top], axis=1) < 0.3 * radii[top]
        tick()
        fitted = _fitted(
            places, upright, tree, np.append(centres[close].mean(axis=0), np.median(radii[close])), edge
        )
        if fitted is not None:
            found.append(fitted)
        gone = np.linalg.norm(centres - centres[top], axis=1) < 0.6 * radii[top]
        centres, radii = centres[~gone], radii[~gone]
    return found


def _proposals(
    places: Array, normals: Array, tree: KDTree, seeds: NDArray[np.int64], reach: float
) -> tuple[Array, Array]:
    """Where the normals about each seed meet, and how far away, where they do meet."""
    centres, radii = [], []
    for begin in range(0, len(seeds), 10_000):
        mine = seeds[begin : begin + 10_000]
        away, near = tree.query(places[mine], NEIGHBOURS, distance_upper_bound=reach)
        inside = np.isfinite(away)
        near = np.where(inside, near, 0)
        p, n, weight = places[near] - places[mine][:, None], normals[near], inside.astype(float)
        count = weight.sum(axis=1)
        spread = np.einsum("mk,mki,mkj->mij", weight, n, n) / count[:, None, None]
        good = (count >= NEIGHBOURS // 3) & (np.linalg.eigvalsh(spread)[:, 0] > LEAST_SPREAD)
        p, n, weight, count, spread = (part[good] for part in (p, n, weight, count, spread))
        across = p - n * np.sum(p * n, axis=2, keepdims=True)
        right = np.einsum("mk,mki->mi", weight, across) / count[:, None]
        centre = np.linalg.solve(np.eye(3) - spread, right[..., None])[..., 0]
        along = np.sum((p - centre[:, None]) * n, axis=2)
        side = np.sign(np.sum(along * weight, axis=1))[:, None]
        radius = np.sum(side * along * weight, axis=1) / count
        scatter = np.sqrt(np.sum(weight * (side * along - radius[:, None]) ** 2, axis=1) / count)
        fits = (scatter < 0.12 * radius) & (radius > 0.6 * reach) & (radius < 2.0 * reach)
        centres.append((centre + places[mine][good])[fits])
        radii.append(radius[fits])
    return np.concatenate(centres), np.concatenate(radii)


def _fitted(
    places: Array, normals: Array, tree: KDTree, sphere: Array, edge: float
) -> tuple[float, Array] | None:
    for share in (0.25, 0.15, 0.12):
        near = np.array(tree.query_ball_point(sphere[:3], (1 + share) * sphere[3]), dtype=np.int64)
        if len(near) < 12:
            return None
        away = places[near] - sphere[:3]
        length = np.linalg.norm(away, axis=1)
        radial = np.abs(np.sum(away * normals[near], axis=1)) / np.maximum(length, 1e-12)
        on = (np.abs(length - sphere[3]) < share * sphere[3]) & (radial > 0.85)
        if on.sum() < 12:
            return None
        try:
            fit = fit_sphere(places[near[on]])
        except StageError:
            return None
        if not 0.5 * sphere[3] < fit.radius < 2 * sphere[3]:
            return None
        sphere = np.append(fit.centre, fit.radius)
    cover = _cover(places[near[on]] - sphere[:3])
    if cover < LEAST_COVER or fit.noise_sigma > 0.1 * fit.radius:
        return None
    return cover, sphere


def _cover(away: Array) -> float:
    """Share of the directions, in 100 equal patches of the sphere, that hold a point."""
    unit = away / np.linalg.norm(away, axis=1, keepdims=True)
    number = np.arange(100) + 0.5
    # Fibonacci's lattice: patches of equal size all around
    height, turn = 1 - 2 * number / 100, np.pi * (1 + np.sqrt(5)) * number
    flat = np.sqrt(1 - height**2)
    patches = np.stack([flat * np.cos(turn), flat * np.sin(turn), height], axis=1)
    return len(np.unique(KDTree(patches).query(unit)[1])) / 100


def _spacing(points: Array) -> float:
    """Usual distance between neighbours."""
    some = points[:: max(len(points) // 2000, 1)]
    return float(np.median(KDTree(points).query(some, 2)[0][:, 1]))
