"""Corresponding points chosen by hand: the file given with ``--pairs``.

CSV with the columns block_a, x_a, y_a, z_a, block_b, x_b, y_b, z_b: two blocks and the same mark on both, in
metres, as the blocks' own meshes (``blocks/NAME/mesh.ply``) show it.  The first line of each two blocks is
the pair that is held together; further lines help.  Two more columns may follow, adjustment_a and
adjustment_b: which adjustment had placed the blocks when the marks were picked.
"""

import csv
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from pipeline.cable.adjust import Orientation
from pipeline.cable.mosaic import MosaicBlock, PointPairs
from pipeline.core.errors import StageError
from pipeline.core.files import write_csv
from pipeline.core.store import stamp

COLUMNS = ("block_a", "x_a", "y_a", "z_a", "block_b", "x_b", "y_b", "z_b")
ADJUSTMENTS = ("adjustment_a", "adjustment_b")
"""Columns that may be missing: a person who writes the file by hand knows no stamps."""

FARTHEST_M = 0.02
"""A point farther than this from its block's surface is a slip, not a mark at its edge."""


@dataclass(frozen=True, kw_only=True)
class HandPair:
    """One line of the file: a mark on one block and the same on another.

    Attributes:
        block_a, block_b: numbers of two blocks, in any order.
        point_a, point_b: (x, y, z), metres as the blocks stand.
        adjustment_a, adjustment_b: stamp of the adjustment that placed the block (:func:`adjustment_stamp`);
            "" unknown.
    """

    block_a: int
    block_b: int
    point_a: tuple[float, float, float]
    point_b: tuple[float, float, float]
    adjustment_a: str = ""
    adjustment_b: str = ""


def adjustment_stamp(orientation: Orientation) -> str:
    """Short digest of where a block's cameras stand and how they see: equal for an equal adjustment only."""
    return stamp(orientation.poses, orientation.lens)[:12]


def read_pairs(path: Path, blocks: tuple[str, ...]) -> tuple[HandPair, ...]:
    """Read the pairs, line by line.

    Args:
        path: the file.
        blocks: names of the blocks, in the survey's order.

    Raises:
        StageError: the file is missing or empty, a column, a block's name or a number is wrong.
    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            rows = list(csv.DictReader(file))
    except OSError as error:
        raise StageError("mosaic", f"cannot read {path} ({error.strerror})", "correct --pairs") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise StageError("mosaic", f"{path} is no CSV in UTF-8", "correct --pairs") from error
    if not rows:
        raise StageError("mosaic", f"{path} holds no pairs", "write one line for each two neighbours")
    found = []
    for line, row in enumerate(rows, start=2):
        first, second = (_block(path, line, row, side, blocks) for side in "ab")
        if first == second:
            raise StageError("mosaic", f"line {line} of {path} pairs a block with itself", "name two blocks")
        points = [[_number(path, line, row, f"{axis}_{side}") for axis in "xyz"] for side in "ab"]
        (xa, ya, za), (xb, yb, zb) = points
        stamps = [(row.get(column) or "").strip() for column in ADJUSTMENTS]
        found.append(
            HandPair(
                block_a=first,
                block_b=second,
                point_a=(xa, ya, za),
                point_b=(xb, yb, zb),
                adjustment_a=stamps[0],
                adjustment_b=stamps[1],
            )
        )
    return tuple(found)


def write_pairs(path: Path, pairs: Sequence[HandPair], blocks: tuple[str, ...]) -> None:
    """Write pairs so that :func:`read_pairs` gives the same ones, to the last digit.

    Raises:
        StageError: the file cannot be written.
    """
    rows = [
        [
            *(blocks[p.block_a], *map(float, p.point_a)),
            *(blocks[p.block_b], *map(float, p.point_b)),
            *(p.adjustment_a, p.adjustment_b),
        ]
        for p in pairs
    ]
    write_csv(path, (*COLUMNS, *ADJUSTMENTS), rows, "mosaic")


def group_pairs(pairs: Iterable[HandPair]) -> tuple[PointPairs, ...]:
    """The pairs of each two blocks together, in the order in which they were chosen."""
    found: dict[tuple[int, int], list[tuple[tuple[float, ...], tuple[float, ...]]]] = defaultdict(list)
    for pair in pairs:
        if pair.block_a < pair.block_b:
            found[pair.block_a, pair.block_b].append((pair.point_a, pair.point_b))
        else:
            found[pair.block_b, pair.block_a].append((pair.point_b, pair.point_a))
    return tuple(
        PointPairs(
            first=first,
            second=second,
            points_first=np.array([p[0] for p in pairs]),
            points_second=np.array([p[1] for p in pairs]),
        )
        for (first, second), pairs in sorted(found.items())
    )


def check_adjustments(
    path: Path, pairs: Sequence[HandPair], blocks: Sequence[str], stamps: Sequence[str]
) -> None:
    """Refuse marks that were picked before the blocks were adjusted anew: they lie elsewhere by now.

    Args:
        path: the file, for the message.
        pairs: as read from it; those without a stamp pass.
        blocks, stamps: names and present :func:`adjustment_stamp` of the blocks, in the survey's order.

    Raises:
        StageError: a pair is of another adjustment.
    """
    for number, pair in enumerate(pairs, start=1):
        for block, picked in ((pair.block_a, pair.adjustment_a), (pair.block_b, pair.adjustment_b)):
            if picked and picked != stamps[block]:
                raise StageError(
                    "mosaic",
                    f"pair {number} of {path} was picked on {blocks[block]} before it was adjusted anew",
                    "pick it again on the new mesh, or join the blocks automatically",
                )


def check_pairs(path: Path, pairs: tuple[PointPairs, ...], blocks: tuple[MosaicBlock, ...]) -> None:
    """Refuse points that are on no surface: millimetres for metres, or a mark of another block's mesh.

    Args:
        path: the file, for the message.
        pairs: as read from it.
        blocks: in the survey's order.

    Raises:
        StageError: a point lies farther than 20 mm from its block.
    """
    for pair in pairs:
        for number, points in ((pair.first, pair.points_first), (pair.second, pair.points_second)):
            surface, name = blocks[number].surface, blocks[number].name
            some = surface.points(slice(None, None, 8), slice(None, None, 8)).reshape(-1, 3)
            away_m = np.asarray(cKDTree(some[np.isfinite(some).all(axis=1)]).query(points)[0])
            if away_m.max() > FARTHEST_M:
                x, y, z = points[away_m.argmax()]
                raise StageError(
                    "mosaic",
                    f"the point ({x:g}, {y:g}, {z:g}) of {name} in {path} lies {1000 * away_m.max():.0f} mm "
                    "off its surface",
                    f"pick it on blocks/{name}/mesh.ply and give it in metres",
                )


def _block(path: Path, line: int, row: dict[str, str], side: str, blocks: tuple[str, ...]) -> int:
    name = (row.get(f"block_{side}") or "").strip()
    if name not in blocks:
        raise StageError(
            "mosaic",
            f'line {line} of {path} names the block "{name}", which the survey does not have',
            f"use one of {', '.join(blocks)} under the columns {', '.join(COLUMNS)}",
        )
    return blocks.index(name)


def _number(path: Path, line: int, row: dict[str, str], column: str) -> float:
    text = (row.get(column) or "").strip()
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not np.isfinite(value):
        raise StageError("mosaic", f'{column} in line {line} of {path} is "{text}"', "give it in metres")
    return value
