"""Tiles: the registered points of all stations, dropped into cubes on disk and thinned, in bounded memory.

Takes the stations' clouds (station frame, memory-mapped) and poses; gives an index of tiles.  Each point
keeps the number of its station, because what one point is worth depends on the ray it came along.  Leaves out
what the points lie on, see segments.py.
"""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event
from pipeline.core.files import replacing
from pipeline.core.vocabulary import Array
from pipeline.steel.records import StationPose
from pipeline.steel.tile_records import RECORD, TileOptions, Tiles

STAGE = "members"


def build_tiles(
    stations: Sequence[tuple[str, Path, StationPose]], options: TileOptions, out: Path, emit: Emit
) -> Tiles:
    """Drop the points of all stations into tiles.

    Args:
        stations: name, cloud (.npy, float32 (n, 3), metres, station frame) and pose of each.
        options: sizes.
        out: folder for the tiles; replaced as a whole when all points are in.
        emit: progress, station by station.

    Raises:
        StageError: no station, or no point within reach of any.
    """
    if not stations:
        raise StageError(STAGE, "there is no registered station", "register at least one station first")
    read = 0
    sizes: dict[tuple[int, ...], int] = {}
    with replacing(out, STAGE) as folder:
        folder.mkdir(parents=True)
        for number, (name, path, pose) in enumerate(stations):
            cloud = np.load(path, mmap_mode="r")
            read += len(cloud)
            rng = np.random.default_rng(number)
            for first in range(0, max(len(cloud), 1), options.chunk_points):
                share = min(first / max(len(cloud), 1), 1.0)
                emit(
                    Event(
                        stage=STAGE, done=int(1000 * (number + share)), total=1000 * len(stations), block=name
                    )
                )
                part = cloud[first : first + options.chunk_points]
                _drop(_kept(part, pose, options, rng), number, options.tile_m, folder, sizes)
        _limit(folder, sizes, options)
    if not sizes:
        raise StageError(
            STAGE,
            f"none of the {read} points of {len(stations)} stations lies between {options.nearest_m:g} and "
            f"{options.farthest_m:g} m from its scanner",
            "check the clouds and the unit of each [[station]]",
        )
    cells = sorted(sizes)
    return Tiles(
        folder=out,
        tile_m=options.tile_m,
        stations=tuple(pose for _, _, pose in stations),
        cells=np.array(cells, dtype=np.int64),
        counts=np.array([sizes[cell] for cell in cells], dtype=np.int64),
        read_points=read,
    )


def _kept(
    part: NDArray[np.float32], pose: StationPose, options: TileOptions, rng: np.random.Generator
) -> Array:
    """The points of a part of a cloud that are kept, in the site frame."""
    points = np.asarray(part, dtype=float)
    return np.asarray(points[_thinned(points, options, rng)] @ pose.rotation.T + pose.translation)


def _thinned(points: Array, options: TileOptions, rng: np.random.Generator) -> NDArray[np.int64]:
    """One point of each small pencil of rays.

    By direction only: a choice by place (one point a voxel) would prefer points far off the surface, which
    share their voxel with few, and make the noise look larger and convex figures wider.
    """
    reach = np.linalg.norm(points, axis=1)
    good = np.flatnonzero((reach > options.nearest_m) & (reach < options.farthest_m))
    if not len(good):
        return good
    order = rng.permutation(good)
    x, y, z = (points[order] / reach[order, None]).T
    # the width of a pencil follows the range in steps of an eighth of an octave
    level = np.floor(8 * np.log2(reach[order])).astype(np.int64)
    width = options.spacing_m / 2.0 ** ((level + 0.5) / 8)
    elevation = np.floor(np.arcsin(z) / width).astype(np.int64)
    azimuth = np.floor(np.arctan2(y, x) * np.cos(elevation * width) / width).astype(np.int64)
    key = ((level + 64) << 52) ^ ((elevation + (1 << 25)) << 26) ^ (azimuth + (1 << 25))
    _, first = np.unique(key, return_index=True)
    return np.sort(order[first])


def _drop(
    places: Array, station: int, tile_m: float, folder: Path, sizes: dict[tuple[int, ...], int]
) -> None:
    """Append points to the files of their tiles."""
    if not len(places):
        return
    cells = np.floor(places / tile_m).astype(np.int32)
    low = cells.min(axis=0)
    x, y, z = (cells - low).T
    _, wide, high = (cells.max(axis=0) - low + 1).tolist()
    # one number a tile: sorting by it takes a third of the time of sorting by three
    number = (x.astype(np.int64) * wide + y) * high + z
    order = np.argsort(number, kind="stable")
    number, cells, places = number[order], cells[order], places[order]
    bounds = [0, *(np.flatnonzero(np.diff(number)) + 1).tolist(), len(cells)]
    for first, last in pairwise(bounds):
        if first == last:
            continue
        cell = tuple(cells[first].tolist())
        records = np.empty(last - first, dtype=RECORD)
        records["place"] = places[first:last] - cells[first] * tile_m
        records["station"] = station
        with (folder / ("_".join(map(str, cell)) + ".bin")).open("ab") as file:
            records.tofile(file)
        sizes[cell] = sizes.get(cell, 0) + len(records)


def _limit(folder: Path, sizes: dict[tuple[int, ...], int], options: TileOptions) -> None:
    """Thin at random the tiles that hold too many points to be worked on at once."""
    for cell, size in sizes.items():
        if size <= options.most_points:
            continue
        path = folder / ("_".join(map(str, cell)) + ".bin")
        records = np.memmap(path, dtype=RECORD, mode="r")
        rng = np.random.default_rng([size, *[n % 2**32 for n in cell]])
        chosen = np.sort(rng.choice(size, options.most_points, replace=False))
        kept = records[chosen]
        del records
        path.unlink()
        kept.tofile(path)
        sizes[cell] = options.most_points
