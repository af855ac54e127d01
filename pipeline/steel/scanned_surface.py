"""The surface that scanned points lie on, piece by piece: where it is nearest, and how far a place is off it.

Takes points (and where their stations stood); gives distances and normals at places.  Around each point its
neighbours carry a quadric, so that a thin rod is not flattened (a plane through 20 neighbours 25 mm wide lies
10 mm inside a rod of 60 mm).  Leaves out how clouds are moved.

Source: D. Levin, "The approximation power of moving least-squares", Math. Comp. 67, 1998 (a local polynomial
over a local plane), with one step of Tukey's weights against mixed pixels.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from pipeline.core.vocabulary import Array
from pipeline.steel.fuse_records import ScanCloud

NEIGHBOURS = 24
BATCH = 20_000
MIDDLE_SHARE = 0.5
"""A place is measured against a quadric within this share of its reach: beyond, it would be extrapolated."""


@dataclass(frozen=True, kw_only=True)
class Nearest:
    """What the surface says at m places.

    Attributes:
        distances: (m,) metres, positive outside; NaN where no surface is near.
        normals: (m, 3) of the surface, towards the scanner where known.
        roughness: (m,) metres, scatter of the neighbours about their quadric.
    """

    distances: Array
    normals: Array
    roughness: Array


@dataclass(frozen=True, kw_only=True)
class Thinned:
    """Means of points in cubes.

    Attributes:
        points: (n, 3) metres.
        towards: (n, 3) from each point to the place that it was seen from; (0, 3) where not known.
        counts: (n,) points in each mean.  They are the weights of a fit: with all cubes alike the few points
            far off a curved surface would pull it outwards, by the square of the noise over the radius.
        within: (n, 3, 3) their covariance, m^2: the mean of points on a curved surface lies inside it, which
            is made good.
        edge_m: of the cubes.
    """

    points: Array
    towards: Array
    counts: Array
    within: Array
    edge_m: float


def single(points: Array) -> Thinned:
    """Points as they are, sides unknown."""
    return Thinned(
        points=points,
        towards=np.zeros((0, 3)),
        counts=np.ones(len(points)),
        within=np.zeros((len(points), 3, 3)),
        edge_m=0.0,
    )


class ScannedSurface:
    """Thinned points with a tree over them; quadrics are fitted once, where they are asked for.

    Args:
        thin: the points; where it is not known from which side they were seen, normals have any sign.
    """

    def __init__(self, thin: Thinned) -> None:
        points = thin.points
        self.points, self._towards = points, thin.towards
        self._within, self._counts = thin.within, thin.counts
        self.tree = KDTree(points)
        count = len(points)
        self._known = np.zeros(count, dtype=bool)
        self._frames = np.empty((count, 3, 3), dtype=np.float32)
        self._shape = np.empty((count, 6), dtype=np.float32)
        self._origin = np.empty((count, 3))
        self._reach = np.empty(count)
        self._rough = np.empty(count)

    @property
    def signed(self) -> bool:
        """Whether normals point to where the surface was seen from."""
        return len(self._towards) > 0

    def roughness_m(self) -> float:
        """Usual scatter of points about their neighbours' quadric."""
        some = np.arange(0, len(self.points), len(self.points) // 3000 + 1)
        self._fit(some)
        return float(np.median(self._rough[some]))

    def at(self, places: Array, gate_m: float) -> Nearest:
        """Distances and normals at (m, 3) places no farther than ``gate_m`` from a scanned point."""
        found: tuple[Array, NDArray[np.int64]] = self.tree.query(places, distance_upper_bound=gate_m)  # type: ignore[assignment]
        away, index = found
        near = np.flatnonzero(np.isfinite(away))
        distances, normals = np.full(len(places), np.nan), np.zeros((len(places), 3))
        roughness = np.full(len(places), np.nan)
        self._fit(np.unique(index[near]))
        mine = index[near]
        local = np.einsum("nij,nj->ni", self._frames[mine], places[near] - self._origin[mine])
        a, b, c, d, e, f = self._shape[mine].T.astype(float)
        u, v, w = local.T
        rise_u, rise_v = b + 2 * d * u + e * v, c + e * u + 2 * f * v
        length = np.sqrt(1 + rise_u**2 + rise_v**2)
        height = a + b * u + c * v + d * u**2 + e * u * v + f * v**2
        # away from the middle of its neighbours a place lies at the edge of what was scanned
        inside = (np.hypot(u, v) < MIDDLE_SHARE * self._reach[mine]) & (length < 2)
        distances[near] = np.where(inside, (w - height) / length, np.nan)
        upright = np.stack([-rise_u, -rise_v, np.ones_like(u)], axis=1) / length[:, None]
        normals[near] = np.einsum("nij,ni->nj", self._frames[mine], upright)
        roughness[near] = self._rough[mine]
        return Nearest(distances=distances, normals=normals, roughness=roughness)

    def _fit(self, wanted: NDArray[np.intp]) -> None:
        new = wanted[~self._known[wanted]]
        for first in range(0, len(new), BATCH):
            self._fit_batch(new[first : first + BATCH])

    def _fit_batch(self, mine: NDArray[np.intp]) -> None:
        away, near = self.tree.query(self.points[mine], min(NEIGHBOURS, len(self.points)))
        around = self.points[near]
        origin = around.mean(axis=1)
        local = around - origin[:, None]
        _, vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", local, local))
        frames = np.swapaxes(vectors, 1, 2)[:, ::-1]  # rows u, v, normal
        if self.signed:
            outward = np.sum(frames[:, 2] * self._towards[mine], axis=1) >= 0
            frames = frames * np.where(outward, 1.0, -1.0)[:, None, None]
        u, v, w = np.moveaxis(np.einsum("nij,nkj->nki", frames, local), -1, 0)
        size = np.maximum(away[:, -1], 1e-9)
        rows = np.stack([np.ones_like(u), u, v, u * u, u * v, v * v], axis=-1)
        unit = np.stack([size**-p for p in (0, 1, 1, 2, 2, 2)], axis=-1)
        rows = rows * unit[:, None]
        # near neighbours count most: over the whole neighbourhood a thin rod is no quadric
        counts = self._counts[near] * np.exp(-2 * (u**2 + v**2) / size[:, None] ** 2)
        weight = counts
        for _ in range(3):
            normal = np.einsum("nk,nki,nkj->nij", weight, rows, rows) + 1e-6 * np.eye(6)
            right = np.einsum("nk,nki,nk->ni", weight, rows, w)
            shape = np.linalg.solve(normal, right[..., None])[..., 0]
            off = w - np.einsum("nki,ni->nk", rows, shape)
            # six of the neighbours' residuals are taken up by the quadric
            rough = 1.4826 * np.median(np.abs(off), axis=1) * np.sqrt(NEIGHBOURS / (NEIGHBOURS - 6))
            weight = (
                counts * np.clip(1 - (off / (4.685 * np.maximum(rough, 1e-9))[:, None]) ** 2, 0, None) ** 2
            )
        shape = shape * unit
        # means of points lie lower than the surface by its second derivatives times their covariance
        within = np.einsum("nia,nab,njb->nij", frames, self._within[near].mean(axis=1), frames)
        bends = shape[:, 3:]
        shape[:, 0] -= np.sum(
            bends * np.stack([within[:, 0, 0], within[:, 0, 1], within[:, 1, 1]], axis=1), axis=1
        )
        self._frames[mine], self._shape[mine] = frames, shape
        self._origin[mine], self._reach[mine], self._rough[mine] = origin, size, rough
        self._known[mine] = True


def towards_scanners(scan: ScanCloud) -> Array:
    """(n, 3) from each point to its scanner; (0, 3) where the stations' places are not known."""
    if not len(scan.scanners):
        return np.zeros((0, 3))
    return np.asarray(scan.scanners[scan.stations] - scan.points)


def cube_of(points: Array, edge: float) -> NDArray[np.int64]:
    """(n,) number of the cube with this edge that each point lies in, counted from 0 without gaps."""
    if not len(points):
        return np.zeros(0, dtype=np.int64)
    cubes = np.floor((points - points.min(axis=0)) / edge).astype(np.int64)
    size = cubes.max(axis=0) + 1
    flat = (cubes[:, 0] * size[1] + cubes[:, 1]) * size[2] + cubes[:, 2]
    return np.unique(flat, return_inverse=True)[1].astype(np.int64)


def means(values: Array, cube: NDArray[np.int64]) -> Array:
    """(k, d) mean of (n, d) values in each cube."""
    count = np.bincount(cube)
    return np.stack([np.bincount(cube, column) / count for column in values.T], axis=1)


def thinned(points: Array, towards: Array, finest_m: float, most: int) -> Thinned:
    """Means of points in cubes, their sides kept apart, with the edge that leaves at most ``most``.

    The edge starts at ``finest_m`` and doubles until there are few enough cubes and, up to eight times
    ``finest_m``, at least four points in each: a mean of several is worth more than one.
    """
    # where a tenth of the points fill too many cubes already, finer ones need not be tried
    edge, some = finest_m, points[:: max(len(points) // 300_000, 1)]
    while (
        len(some) < len(points)
        and len(np.unique(cube_of(some, edge))) > 0.5 * len(some)
        and edge < 4 * finest_m
    ):
        edge *= 2
    while True:
        cube = cube_of(points, edge)
        count = int(cube.max(initial=-1)) + 1
        if count <= most and (len(points) >= 4 * count or edge >= 8 * finest_m):
            break
        edge *= 2
    aside = means(towards, cube) if len(towards) else towards
    middle = means(points, cube)
    counts = np.bincount(cube)
    away = points - middle[cube]
    within = np.empty((len(middle), 3, 3))
    for i in range(3):
        for j in range(i + 1):
            within[:, i, j] = within[:, j, i] = np.bincount(cube, away[:, i] * away[:, j]) / counts
    return Thinned(
        points=middle,
        towards=aside,
        counts=counts.astype(float),
        within=within,
        edge_m=edge,
    )
