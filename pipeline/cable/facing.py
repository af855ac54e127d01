"""What ties neighbouring blocks together: corresponding points, and surface points with their feet.

Takes blocks and pairs; gives ties for the adjustment (:mod:`pipeline.cable.closest_fit`) and how well the
blocks fit where they meet.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from pipeline.cable.closest_fit import Fit, Placement, Tie
from pipeline.cable.mosaic_records import Join, MosaicBlock, MosaicOptions, PointPairs
from pipeline.cable.surface import BlockSurface, smoothed
from pipeline.core.vocabulary import Array


class Facing:
    """Ties between neighbouring blocks: corresponding points, and surface points with their feet."""

    def __init__(
        self, blocks: tuple[MosaicBlock, ...], pairs: tuple[PointPairs, ...], options: MosaicOptions
    ) -> None:
        self._pairs, self._options = pairs, options
        self._surfaces = [smoothed(b.surface, options.smooth_mm) for b in blocks]
        self._keep = [b.keep for b in blocks]
        self._sparse = [self._thin(s, k) for s, k in zip(self._surfaces, self._keep, strict=True)]
        # looked up at every step of the adjustment: masked once, in the precision that interpolation wants
        self._kept_radius = [
            np.where(k, s.radius_m, np.nan).astype(np.float64)
            for s, k in zip(self._surfaces, self._keep, strict=True)
        ]

    def pair_ties(self, placement: Placement) -> list[Tie]:
        """All corresponding points."""
        return [pair_tie(p, placement, self._options) for p in self._pairs]

    def surface_ties(self, placement: Placement) -> list[Tie]:
        """The surfaces of all blocks that have corresponding points, where they overlap."""
        return [
            t for p in self._pairs if len((t := self._surface_tie(p.first, p.second, placement)).points_first)
        ]

    def describe(self, pairs: PointPairs, held: PointPairs, fit: Fit) -> Join:
        """How well two blocks fit where they meet."""
        placement, options = fit.placement, self._options
        residuals = residuals_mm(pairs, placement, options)
        near = np.linalg.norm(residuals, axis=1) < 5 * np.median(np.linalg.norm(residuals, axis=1)) + 1e-9
        surface = self._surface_tie(pairs.first, pairs.second, placement)
        gaps = surface.residuals(placement)[:, 2] * options.surface_mm
        return Join(
            first=pairs.first,
            second=pairs.second,
            pairs=len(pairs.points_first),
            held=np.concatenate([held.points_first, held.points_second]),
            residual_mm=np.sqrt(np.mean(residuals[near] ** 2, axis=0)),
            surface_mm=float(np.sqrt(np.mean(gaps**2))) if len(gaps) else float("nan"),
        )

    def _thin(self, surface: BlockSurface, keep: NDArray[np.bool_]) -> Array:
        along_m, around_m = surface.cell_m
        step = self._options.surface_step_mm / 1000
        rows = slice(None, None, max(round(step / along_m), 1))
        columns = slice(None, None, max(round(step / around_m), 1))
        points = surface.points(rows, columns)
        return points[keep[rows, columns] & np.isfinite(points[..., 0])]

    def _surface_tie(self, first: int, second: int, placement: Placement) -> Tie:
        """Points of the first block and, at the same azimuth and y, the second block's surface."""
        points = self._sparse[first]
        inside = placement.undo(second, placement.apply(first, points))
        surface = self._surfaces[second]
        azimuth, y_m, _ = surface.axis.unroll(inside)
        radius = lookup(surface, self._kept_radius[second], azimuth, y_m)
        feet = surface.axis.roll(azimuth, y_m, radius)
        met = np.isfinite(feet).all(axis=1)
        points, feet = points[met], feet[met]
        whitening = np.zeros((len(points), 3, 3))
        if len(points):
            out = _directions(placement.apply(first, points))[2]
            whitening[:, 2] = out * 1000 / self._options.surface_mm
        return Tie(first=first, second=second, points_first=points, points_second=feet, whitening=whitening)


def residuals_mm(pairs: PointPairs, placement: Placement, options: MosaicOptions) -> Array:
    """How far the points of each pair lie apart where the blocks are placed, (k, 3): along, around, out."""
    sigmas = [options.sigma_along_mm, options.sigma_around_mm, options.sigma_radial_mm]
    return pair_tie(pairs, placement, options).residuals(placement) * sigmas


def pair_tie(pairs: PointPairs, placement: Placement, options: MosaicOptions) -> Tie:
    """Corresponding points as a tie, weighted along, around and out of the cable."""
    along, around, out = _directions(placement.apply(pairs.first, pairs.points_first))
    whitening = np.stack(
        [
            along * 1000 / options.sigma_along_mm,
            around * 1000 / options.sigma_around_mm,
            out * 1000 / options.sigma_radial_mm,
        ],
        axis=1,
    )
    return Tie(
        first=pairs.first,
        second=pairs.second,
        points_first=pairs.points_first,
        points_second=pairs.points_second,
        whitening=whitening,
    )


def _directions(points: Array) -> tuple[Array, Array, Array]:
    """Unit vectors along, around and out of the cable at points (n, 3)."""
    out = np.stack([points[:, 0], np.zeros(len(points)), points[:, 2]], axis=1)
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    along = np.broadcast_to([0.0, 1.0, 0.0], out.shape)
    return along, np.cross(along, out), out


def surface_at(surface: BlockSurface, keep: NDArray[np.bool_], places: Array) -> Array:
    """Surface points at places (k, 2) of azimuth and y, (k, 3) metres; NaN off the kept surface."""
    if not len(places):
        return np.zeros((0, 3))
    radius = lookup(surface, np.where(keep, surface.radius_m, np.nan), places[:, 0], places[:, 1])
    return surface.axis.roll(places[:, 0], places[:, 1], radius)


def lookup(surface: BlockSurface, values: NDArray[np.floating], azimuth: Array, y_m: Array) -> Array:
    """Bilinear values (k,) of an (n, m) map at azimuths and places along the cable; NaN outside."""
    middle = surface.azimuth.mean()
    turned = middle + np.angle(np.exp(1j * (azimuth - middle)))
    column = (turned - surface.azimuth[0]) / (surface.azimuth[1] - surface.azimuth[0])
    row = (y_m - surface.y_m[0]) / (surface.y_m[1] - surface.y_m[0])
    places = np.stack([row, column])
    return map_coordinates(np.asarray(values, dtype=np.float64), places, order=1, cval=np.nan)
