"""Stage *mosaic*: all blocks to one model by points held together (paper, section 3.3).

Takes the blocks' cropped surfaces, unrolled pictures and datums; gives each block's place in the cable
frame.  For every pair of neighbours one pair of corresponding points is held together, and the surfaces are
brought as close as they go; the pair comes from matching the unrolled pictures or from the user.  All
neighbours, the last and the first included, are fitted at once, so the ring closes.
"""

from dataclasses import dataclass, field
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag
from scipy.ndimage import map_coordinates

from pipeline.cable.closest_fit import Fit, Placement, Tie, fit_pieces
from pipeline.cable.surface import BlockSurface, smoothed
from pipeline.cable.texture import UnrolledPicture
from pipeline.cable.unrolled_match import UnrolledMatchOptions, match_unrolled
from pipeline.core.events import Emit, Event
from pipeline.core.vocabulary import Array


@dataclass(frozen=True, kw_only=True)
class MosaicOptions:
    """How blocks are joined.

    Attributes:
        match: how corresponding points are found.
        single_point: use one pair of neighbours only (the paper's way), not every pair that was found.
        sigma_along_mm, sigma_around_mm, sigma_radial_mm: of the difference of two corresponding points.
        surface_mm: of the distance of two surfaces.
        surface_step_mm: distance between the surface points that are compared.
        smooth_mm: surfaces are averaged over this width before they are compared.
    """

    match: UnrolledMatchOptions = field(default_factory=UnrolledMatchOptions)
    single_point: bool = False
    sigma_along_mm: float = field(default=0.06, metadata={"above": 0.0})
    sigma_around_mm: float = field(default=0.1, metadata={"above": 0.0})
    sigma_radial_mm: float = field(default=0.1, metadata={"above": 0.0})
    surface_mm: float = field(default=0.2, metadata={"above": 0.0})
    surface_step_mm: float = field(default=4.0, metadata={"above": 0.0})
    smooth_mm: float = field(default=2.0, metadata={"minimum": 0.0})


@dataclass(frozen=True, kw_only=True)
class PointPairs:
    """Corresponding points of two blocks, (k, 3) each, in metres as the blocks stand."""

    first: int
    second: int
    points_first: Array
    points_second: Array


@dataclass(frozen=True, kw_only=True)
class MosaicBlock:
    """What the mosaic needs to know of one block."""

    name: str
    surface: BlockSurface
    keep: NDArray[np.bool_]
    picture: UnrolledPicture
    datum_origin: Array
    datum_information: Array


@dataclass(frozen=True, kw_only=True)
class Join:
    """How two neighbours fit.

    Attributes:
        first, second: the blocks' numbers.
        pairs: corresponding points found or given.
        held: (2, 3) the pair that is held together, metres as the blocks stand.
        residual_mm: (3,) root mean square difference of the pairs along, around and out of the cable.
        surface_mm: root mean square distance of the surfaces where they overlap.
    """

    first: int
    second: int
    pairs: int
    held: Array
    residual_mm: Array
    surface_mm: float


@dataclass(frozen=True, kw_only=True)
class Mosaic:
    """All blocks in one frame.

    Attributes:
        placement: of each block, in the order of the blocks given.
        covariance: (7 b, 7 b) of rotation vectors (rad), shifts (m) and log scales.
        joins: neighbours that were tied.
    """

    placement: Placement
    covariance: Array
    joins: tuple[Join, ...]


def mosaic_blocks(
    blocks: tuple[MosaicBlock, ...],
    given: tuple[PointPairs, ...] | None,
    settled: Array | None,
    options: MosaicOptions,
    emit: Emit,
) -> Mosaic:
    """Join the blocks.

    Args:
        blocks: in any order.
        given: pairs chosen by hand, in place of automatic ones; the first of each two blocks is held.
        settled: (7 b, 7 b) covariance of blocks that were adjusted together: they stay where they are, unless
            pairs are given, and it is only told how well they fit.
        options: see there.
        emit: progress, one event a pair of neighbours.
    """
    pairs = given if given is not None else _find_pairs(blocks, options, emit)
    start = Placement(
        origins=np.stack([b.datum_origin for b in blocks]),
        rotations=np.tile(np.eye(3), (len(blocks), 1, 1)),
        shifts=np.zeros((len(blocks), 3)),
        scales=np.ones(len(blocks)),
    )
    facing = _Facing(blocks, pairs, options)
    if settled is not None and given is None:
        stay = Fit(placement=start, covariance=settled)
        held = [_best_pair(p, start, options) for p in pairs]
        joins = tuple(facing.describe(p, h, stay) for p, h in zip(pairs, held, strict=True))
        return Mosaic(placement=start, covariance=settled, joins=joins)
    information = block_diag(*(b.datum_information for b in blocks))
    free = fit_pieces(start, information, lambda p: [*facing.pair_ties(p), *facing.surface_ties(p)])
    held = [_best_pair(p, free.placement, options) if given is None else _pair(p, 0) for p in pairs]
    if options.single_point:
        facing = _Facing(blocks, tuple(held), options)
    final = fit_pieces(
        free.placement if not options.single_point else start,
        information,
        lambda p: [*facing.pair_ties(p), *facing.surface_ties(p), *(_hold(h) for h in held)],
    )
    joins = tuple(facing.describe(p, h, final) for p, h in zip(pairs, held, strict=True))
    return Mosaic(placement=final.placement, covariance=final.covariance, joins=joins)


def _find_pairs(
    blocks: tuple[MosaicBlock, ...], options: MosaicOptions, emit: Emit
) -> tuple[PointPairs, ...]:
    candidates = list(combinations(range(len(blocks)), 2))
    found = []
    for number, (first, second) in enumerate(candidates):
        emit(Event(stage="mosaic", done=number, total=len(candidates) + 1))
        a, b = blocks[first], blocks[second]
        radius_m = float(np.nanmedian(a.surface.radius_m))
        matches = match_unrolled(a.picture, b.picture, radius_m, options.match)
        points = [surface_at(s.surface, s.keep, m) for s, m in ((a, matches.first), (b, matches.second))]
        good = np.isfinite(points[0]).all(axis=1) & np.isfinite(points[1]).all(axis=1)
        if good.any():
            found.append(
                PointPairs(
                    first=first, second=second, points_first=points[0][good], points_second=points[1][good]
                )
            )
    return tuple(found)


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
    return map_coordinates(values.astype(np.float64), places, order=1, cval=np.nan)


def _best_pair(pairs: PointPairs, placement: Placement, options: MosaicOptions) -> PointPairs:
    """The pair nearest to where all of them agree: holding it together bends nothing."""
    tie = _pair_tie(pairs, placement, options)
    return _pair(pairs, int(np.argmin(np.sum(tie.residuals(placement) ** 2, axis=1))))


def _pair(pairs: PointPairs, number: int) -> PointPairs:
    return PointPairs(
        first=pairs.first,
        second=pairs.second,
        points_first=pairs.points_first[number : number + 1],
        points_second=pairs.points_second[number : number + 1],
    )


def _hold(pair: PointPairs) -> Tie:
    """A pair that stays together to a micrometre."""
    return Tie(
        first=pair.first,
        second=pair.second,
        points_first=pair.points_first,
        points_second=pair.points_second,
        whitening=np.eye(3)[None] * 1e6,
    )


def _pair_tie(pairs: PointPairs, placement: Placement, options: MosaicOptions) -> Tie:
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


class _Facing:
    """Ties between neighbouring blocks: corresponding points, and surface points with their feet."""

    def __init__(
        self, blocks: tuple[MosaicBlock, ...], pairs: tuple[PointPairs, ...], options: MosaicOptions
    ) -> None:
        self._pairs, self._options = pairs, options
        self._surfaces = [smoothed(b.surface, options.smooth_mm) for b in blocks]
        self._keep = [b.keep for b in blocks]
        self._sparse = [self._thin(s, k) for s, k in zip(self._surfaces, self._keep, strict=True)]

    def pair_ties(self, placement: Placement) -> list[Tie]:
        return [_pair_tie(p, placement, self._options) for p in self._pairs]

    def surface_ties(self, placement: Placement) -> list[Tie]:
        return [
            t for p in self._pairs if len((t := self._surface_tie(p.first, p.second, placement)).points_first)
        ]

    def describe(self, pairs: PointPairs, held: PointPairs, fit: Fit) -> Join:
        """How well two blocks fit where they meet."""
        placement, options = fit.placement, self._options
        sigmas = [options.sigma_along_mm, options.sigma_around_mm, options.sigma_radial_mm]
        residuals = _pair_tie(pairs, placement, options).residuals(placement) * sigmas
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
        feet = surface_at(surface, self._keep[second], np.stack([azimuth, y_m], axis=1))
        met = np.isfinite(feet).all(axis=1)
        points, feet = points[met], feet[met]
        whitening = np.zeros((len(points), 3, 3))
        if len(points):
            out = _directions(placement.apply(first, points))[2]
            whitening[:, 2] = out * 1000 / self._options.surface_mm
        return Tie(first=first, second=second, points_first=points, points_second=feet, whitening=whitening)
