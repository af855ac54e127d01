"""A site as large as the paper's, to see what its tiles and members take.

``python -m tests.steel.large_site [--stations 134] [--points 5000000]``: many stations in a hall of rods,
columns and floor, sampled without occlusion.  A few clouds are written and used by all stations in turn, each
at its own pose, so that they need no disk of their own; the tiles do (9 GB), and are deleted.  Prints peak
memory and processor time.
"""

import argparse
import json
import shutil
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from pipeline.core.events import silent
from pipeline.core.memory import peak_memory_mb
from pipeline.steel.member_records import MemberOptions, NominalSizes
from pipeline.steel.members import find_members
from pipeline.steel.records import StationPose
from pipeline.steel.tile_records import TileOptions
from pipeline.steel.tiles import build_tiles

MODULE_M, HEIGHT_M, SCANNER_M, REACH_M = 3.0, 6.0, 1.7, 45.0
ROD_M, COLUMN_M = 0.045, 0.15


def write_cloud(path, count, seed):
    """One station's cloud (.npy float32): half floor, most of the rest rods above, some columns."""
    rng = np.random.default_rng(seed)
    out = np.lib.format.open_memmap(path, mode="w+", dtype=np.float32, shape=(count, 3))
    for first in range(0, count, 500_000):
        size = min(500_000, count - first)
        parts = [floor(rng, size // 2), columns(rng, size // 20)]
        parts.append(rods(rng, size - sum(map(len, parts))))
        out[first : first + size] = noisy(rng, np.concatenate(parts))


def floor(rng, count):
    """Even in angle, as a scanner's rays are."""
    down, around = rng.uniform(np.arctan(SCANNER_M / REACH_M), 1.2, count), rng.uniform(0, 2 * np.pi, count)
    away = SCANNER_M / np.tan(down)
    return np.column_stack([away * np.cos(around), away * np.sin(around), np.full(count, -SCANNER_M)])


def rods(rng, count):
    """Both ways of a square grid; near ones get more."""
    along = (REACH_M * rng.random(count) ** 2) * rng.choice([-1, 1], count)
    number = np.round(REACH_M * rng.random(count) ** 2 / MODULE_M) * rng.choice([-1, 1], count)
    axis = np.column_stack([along, (number + 0.5) * MODULE_M, np.full(count, HEIGHT_M)])
    # the lower side, seen from below
    turn = rng.uniform(np.pi, 2 * np.pi, count)
    axis += ROD_M * np.column_stack([np.zeros(count), np.cos(turn), np.sin(turn)])
    swap = rng.random(count) < 0.5
    axis[swap] = axis[swap][:, [1, 0, 2]]
    return axis


def columns(rng, count):
    number = np.round(rng.uniform(-2, 2, (count, 2))) + 0.5
    foot = 4 * MODULE_M * number
    turn = np.arctan2(-foot[:, 1], -foot[:, 0]) + rng.uniform(-1.4, 1.4, count)
    side = COLUMN_M * np.column_stack([np.cos(turn), np.sin(turn)])
    return np.column_stack([foot + side, rng.uniform(-SCANNER_M, HEIGHT_M - 0.3, count)])


def noisy(rng, places):
    away = np.linalg.norm(places, axis=1, keepdims=True)
    return places * (1 + rng.normal(0, 0.002, (len(places), 1)) / away)


def poses(count):
    """On a grid of 12 m, on the grid's own modules, so that all stations see the same steel."""
    wide = int(np.ceil(np.sqrt(1.2 * count)))
    return [
        StationPose(
            name=f"S{k + 1:03d}",
            rotation=np.eye(3),
            translation=np.array([4 * MODULE_M * (k % wide), 4 * MODULE_M * (k // wide), 0.0]),
            covariance=np.zeros((6, 6)),
        )
        for k in range(count)
    ]


def measure(folder, stations, points, clouds, tiles_searched):
    """Tiles of all stations, then members in the tiles that hold most; what both took."""
    files = []
    for k in range(clouds):
        files.append(folder / f"{k}.npy")
        write_cloud(files[-1], points, k)
    given = [(pose.name, files[k % clouds], pose) for k, pose in enumerate(poses(stations))]
    told = {"points": stations * points}
    tiles = build_tiles(given, TileOptions(), folder / "tiles", silent)
    told |= {"kept": int(tiles.counts.sum()), "tiles": len(tiles.counts), "fullest": int(tiles.counts.max())}
    told["after_tiles"] = spent()
    if not tiles_searched:
        return told
    # those that hold most take the most memory; those under the roof hold rods
    under_roof = tiles.cells[:, 2] == int(HEIGHT_M // tiles.tile_m)
    fullest = np.argsort(tiles.counts)
    fullest = np.union1d(fullest[-tiles_searched:], fullest[under_roof[fullest]][-tiles_searched:])
    some = replace(tiles, cells=tiles.cells[fullest], counts=tiles.counts[fullest])
    sizes = NominalSizes(rods_mm=(2000 * ROD_M,), columns_mm=(2000 * COLUMN_M,))
    found = find_members(some, sizes, MemberOptions(), silent)
    told |= {"rods": len(found.rods), "columns": len(found.columns), "after_members": spent()}
    return told


def spent():
    # of this process alone: getrusage would tell the peak of the tests that started it, if that is larger
    return {"peak_mb": round(peak_memory_mb()), "cpu_s": round(time.process_time())}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--stations", type=int, default=134)
    parser.add_argument("--points", type=int, default=5_000_000)
    parser.add_argument("--clouds", type=int, default=4)
    parser.add_argument("--tiles-searched", type=int, default=24, help="0: tiles alone")
    asked = parser.parse_args()
    folder = Path(tempfile.mkdtemp(prefix="large-site-"))
    try:
        told = measure(folder, asked.stations, asked.points, asked.clouds, asked.tiles_searched)
    finally:
        shutil.rmtree(folder)
    print(json.dumps(told))  # noqa: T201 - a command


if __name__ == "__main__":
    main()
