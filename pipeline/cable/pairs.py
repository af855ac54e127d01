"""Corresponding points chosen by hand: the file given with ``--pairs``.

CSV with the columns block_a, x_a, y_a, z_a, block_b, x_b, y_b, z_b: two blocks and the same mark on both, in
metres, as the blocks' own meshes (``blocks/NAME/mesh.ply``) show it.  The first line of each two blocks is
the pair that is held together; further lines help.
"""

import csv
from collections import defaultdict
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from pipeline.cable.mosaic import MosaicBlock, PointPairs
from pipeline.core.errors import StageError

COLUMNS = ("block_a", "x_a", "y_a", "z_a", "block_b", "x_b", "y_b", "z_b")

FARTHEST_M = 0.02
"""A point farther than this from its block's surface is a slip, not a mark at its edge."""


def read_pairs(path: Path, blocks: tuple[str, ...]) -> tuple[PointPairs, ...]:
    """Read the pairs.

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
    found: dict[tuple[int, int], list[tuple[list[float], list[float]]]] = defaultdict(list)
    for line, row in enumerate(rows, start=2):
        first, second = (_block(path, line, row, side, blocks) for side in "ab")
        if first == second:
            raise StageError("mosaic", f"line {line} of {path} pairs a block with itself", "name two blocks")
        points = [[_number(path, line, row, f"{axis}_{side}") for axis in "xyz"] for side in "ab"]
        key, pair = ((first, second), (points[0], points[1]))
        if first > second:
            key, pair = (second, first), (points[1], points[0])
        found[key].append(pair)
    return tuple(
        PointPairs(
            first=first,
            second=second,
            points_first=np.array([p[0] for p in pairs]),
            points_second=np.array([p[1] for p in pairs]),
        )
        for (first, second), pairs in sorted(found.items())
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
