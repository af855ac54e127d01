"""Pairs of the scene's list to the pipeline's records and to the run folder's file, and back."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import bpy

from pipeline.core.errors import StageError

from .gather import gather_survey
from .properties.mosaic import CableTwinMosaic
from .segments import segments_of

if TYPE_CHECKING:
    from pipeline.cable.pairs import HandPair


def gather_pairs(mosaic: CableTwinMosaic, blocks: Sequence[str]) -> list["HandPair"]:
    """The list as records.

    Args:
        mosaic: holds the list.
        blocks: names of the blocks, in the survey's order.

    Raises:
        StageError: a pair is of a block that is not there.
    """
    from pipeline.cable.pairs import HandPair

    for number, pair in enumerate(mosaic.pairs, start=1):
        for name in (pair.block_a, pair.block_b):
            if name not in blocks:
                raise StageError("mosaic", f"pair {number} is of {name}, which is not there", "remove it")
    return [
        HandPair(
            block_a=blocks.index(pair.block_a),
            block_b=blocks.index(pair.block_b),
            point_a=tuple(pair.point_a),
            point_b=tuple(pair.point_b),
            adjustment_a=pair.adjustment_a,
            adjustment_b=pair.adjustment_b,
        )
        for pair in mosaic.pairs
    ]


def add_pairs(
    mosaic: CableTwinMosaic, pairs: Sequence["HandPair"], blocks: Sequence[str], found: bool
) -> None:
    """Append records to the list.

    Args:
        mosaic: holds the list.
        pairs: what to add.
        blocks: names of the blocks, in the survey's order.
        found: automatically, not by a person.
    """
    for pair in pairs:
        item = mosaic.pairs.add()
        item.block_a, item.block_b = blocks[pair.block_a], blocks[pair.block_b]
        item.point_a, item.point_b = pair.point_a, pair.point_b
        item.adjustment_a, item.adjustment_b = pair.adjustment_a, pair.adjustment_b
        item.found = found


def outdated(scene: bpy.types.Scene) -> list[bool]:
    """For each pair of the list whether it was picked before one of its blocks was adjusted anew."""
    data = scene.cabletwin
    now = {block.name: block.adjustment for block in data.results.blocks}
    ends = [((p.block_a, p.adjustment_a), (p.block_b, p.adjustment_b)) for p in data.mosaic.pairs]
    return [any(picked and now.get(block) not in (None, picked) for block, picked in two) for two in ends]


def pairs_words(scene: bpy.types.Scene, folder: Path) -> list[str]:
    """Write the pairs into the run folder if the scene joins by hand; the words that say so.

    Raises:
        StageError: a pair is of a block that is not there, the run was worked off in segments, or the file
            cannot be written.
    """
    mosaic = scene.cabletwin.mosaic
    if mosaic.way != "BY_HAND" or not mosaic.pairs:
        return []
    if segments_of(folder):
        raise StageError(
            "mosaic",
            "pairs picked by hand join a cable in one piece, and this run was worked off in segments",
            "choose Automatic in the panel Mosaic",
        )
    from pipeline.cable.pairs import write_pairs
    from pipeline.joining import PAIRS_FILE

    names = tuple(b.name for b in gather_survey(scene).blocks)
    write_pairs(folder / PAIRS_FILE, gather_pairs(mosaic, names), names)
    return ["--pairs", str(folder / PAIRS_FILE)]
