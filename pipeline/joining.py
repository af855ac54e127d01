"""Blocks of an opened run joined anew, without the command line: what a person tries before it is applied.

Takes an opened run and pairs chosen by hand; gives each block's place in the cable frame, as the stages
*mosaic* and *ring* give it for the same pairs.  Writes nothing.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline.cable.mosaic import Mosaic, MosaicBlock, PointPairs, mosaic_blocks, residuals_mm
from pipeline.cable.pairs import HandPair, adjustment_stamp, check_adjustments, check_pairs, group_pairs
from pipeline.cable.ring import align
from pipeline.core.errors import StageError
from pipeline.core.events import silent
from pipeline.core.vocabulary import Array
from pipeline.opened import OpenedBlock, OpenedRun
from pipeline.report.block_model import cable_from_block

PAIRS_FILE = "pairs.csv"
"""Where a run folder keeps the pairs that it was joined by."""


@dataclass(frozen=True, kw_only=True)
class Joined:
    """The blocks in their new places.

    Attributes:
        mosaic: as the stage gives it.
        cable_from_block: (b, 4, 4), metres.
        residuals_mm: (k, 3) of the pairs, along, around and out of the cable, in the order given.
    """

    mosaic: Mosaic
    cable_from_block: Array
    residuals_mm: Array


def join_run(run: OpenedRun, pairs: Sequence[HandPair] | None) -> Joined:
    """Join the blocks of a run.

    Args:
        run: cropped at least.
        pairs: chosen by hand; the first of each two blocks is held together.  None joins automatically.

    Raises:
        StageError: a block is not cropped yet, there are no pairs, one was picked before the blocks were
            adjusted anew, or lies off its block.
    """
    blocks = _blocks(run)
    given = None if pairs is None else group_pairs(pairs)
    if given is not None:
        if not given:
            raise StageError("mosaic", "there are no pairs", "pick one for each two neighbours")
        check_adjustments(Path(PAIRS_FILE), pairs or (), [b.name for b in run.blocks], _stamps(run))
        check_pairs(Path(PAIRS_FILE), given, blocks)
    mosaic = _mosaic(run, blocks, given)
    alignment = align(blocks, mosaic)
    one_by_one = [group_pairs([p])[0] for p in pairs or ()]
    found = [residuals_mm(p, mosaic.placement, run.options.mosaic) for p in one_by_one]
    return Joined(
        mosaic=mosaic,
        cable_from_block=np.stack([cable_from_block(n, mosaic, alignment) for n in range(len(blocks))]),
        residuals_mm=np.concatenate(found) if found else np.zeros((0, 3)),
    )


def closing_pairs(run: OpenedRun, pairs: Sequence[HandPair]) -> tuple[HandPair, ...]:
    """A pair for every two neighbours that have none yet, so that the ring closes.

    Neighbours are blocks whose unrolled pictures share marks, the last and the first included.  Of those
    marks the one is taken that agrees best with all of them.

    Raises:
        StageError: a block is not cropped yet, or there is nothing to add.
    """
    known = {(p.first, p.second) for p in group_pairs(pairs)}
    joins, stamps = _mosaic(run, _blocks(run), None).joins, _stamps(run)
    found = tuple(
        HandPair(
            block_a=j.first,
            block_b=j.second,
            point_a=(float(j.held[0, 0]), float(j.held[0, 1]), float(j.held[0, 2])),
            point_b=(float(j.held[1, 0]), float(j.held[1, 1]), float(j.held[1, 2])),
            adjustment_a=stamps[j.first],
            adjustment_b=stamps[j.second],
        )
        for j in joins
        if (j.first, j.second) not in known
    )
    if not found and not joins:
        raise StageError("mosaic", "no marks that two blocks share were found", "pick pairs by hand")
    return found


def _stamps(run: OpenedRun) -> list[str]:
    """Of each block; "" where it is not adjusted yet."""
    return ["" if b.orientation is None else adjustment_stamp(b.orientation) for b in run.blocks]


def _mosaic(run: OpenedRun, blocks: tuple[MosaicBlock, ...], given: tuple[PointPairs, ...] | None) -> Mosaic:
    settled = None if run.together is None else run.together.covariance
    return mosaic_blocks(blocks, given, settled, run.options.mosaic, silent)


def _blocks(run: OpenedRun) -> tuple[MosaicBlock, ...]:
    return tuple(_block(b) for b in run.blocks)


def _block(block: OpenedBlock) -> MosaicBlock:
    if block.orientation is None or block.surface is None or block.picture is None or block.crop is None:
        raise StageError("mosaic", f"{block.name} is not cropped yet", "run the reconstruction first")
    return MosaicBlock(
        name=block.name,
        surface=block.surface,
        keep=block.crop.keep,
        picture=block.picture,
        datum_origin=block.orientation.datum_origin,
        datum_information=block.orientation.datum_information,
    )
