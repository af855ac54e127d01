"""Stage *mosaic*: all blocks to one model by points held together (paper, section 3.3).

Takes the blocks' cropped surfaces, unrolled pictures and datums; gives each block's place in the cable
frame.  For every pair of neighbours one pair of corresponding points is held together, and the surfaces are
brought as close as they go; the pair comes from matching the unrolled pictures or from the user.  All
neighbours, the last and the first included, are fitted at once, so the ring closes.
"""

from itertools import combinations

import numpy as np
from scipy.linalg import block_diag

from pipeline.cable.closest_fit import Fit, Placement, Tie, fit_pieces
from pipeline.cable.facing import Facing, lookup, pair_tie, residuals_mm, surface_at
from pipeline.cable.mosaic_records import Join, Mosaic, MosaicBlock, MosaicOptions, PointPairs
from pipeline.cable.unrolled_match import match_unrolled
from pipeline.core.events import Emit, Event
from pipeline.core.vocabulary import Array

__all__ = [
    "Join",
    "Mosaic",
    "MosaicBlock",
    "MosaicOptions",
    "PointPairs",
    "as_they_stand",
    "best_pair",
    "find_pairs",
    "lookup",
    "mosaic_blocks",
    "residuals_mm",
    "surface_at",
]


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
    pairs = given if given is not None else find_pairs(blocks, options, emit)
    start = as_they_stand(blocks)
    facing = Facing(blocks, pairs, options)
    if settled is not None and given is None:
        stay = Fit(placement=start, covariance=settled)
        held = [best_pair(p, start, options) for p in pairs]
        joins = tuple(facing.describe(p, h, stay) for p, h in zip(pairs, held, strict=True))
        return Mosaic(placement=start, covariance=settled, joins=joins)
    information = block_diag(*(b.datum_information for b in blocks))
    free = fit_pieces(start, information, lambda p: [*facing.pair_ties(p), *facing.surface_ties(p)])
    held = [best_pair(p, free.placement, options) if given is None else _pair(p, 0) for p in pairs]
    if options.single_point:
        facing = Facing(blocks, tuple(held), options)
    final = fit_pieces(
        free.placement if not options.single_point else start,
        information,
        lambda p: [*facing.pair_ties(p), *facing.surface_ties(p), *(_hold(h) for h in held)],
    )
    joins = tuple(facing.describe(p, h, final) for p, h in zip(pairs, held, strict=True))
    return Mosaic(placement=final.placement, covariance=final.covariance, joins=joins)


def as_they_stand(blocks: tuple[MosaicBlock, ...]) -> Placement:
    """Every block in its own place."""
    return Placement(
        origins=np.stack([b.datum_origin for b in blocks]),
        rotations=np.tile(np.eye(3), (len(blocks), 1, 1)),
        shifts=np.zeros((len(blocks), 3)),
        scales=np.ones(len(blocks)),
    )


def find_pairs(blocks: tuple[MosaicBlock, ...], options: MosaicOptions, emit: Emit) -> tuple[PointPairs, ...]:
    """Corresponding points of all blocks that meet, from their unrolled pictures; other blocks have none."""
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


def best_pair(pairs: PointPairs, placement: Placement, options: MosaicOptions) -> PointPairs:
    """The pair nearest to where all of them agree: holding it together bends nothing."""
    tie = pair_tie(pairs, placement, options)
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
