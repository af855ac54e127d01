"""cloud.ply: the registered points of all stations, thinned evenly, each in the colour of its station.

Takes the tiles; writes the file piece by piece, one tile in memory at a time.
"""

from pathlib import Path

import numpy as np

from pipeline.core.events import Emit, Event
from pipeline.core.files import replacing
from pipeline.report.steel import colours
from pipeline.steel.tile_reader import TileReader
from pipeline.steel.tile_records import Tiles

MOST_POINTS = 2_000_000
_ROW = np.dtype(
    [
        ("x", "<f4"),
        ("y", "<f4"),
        ("z", "<f4"),
        ("red", "u1"),
        ("green", "u1"),
        ("blue", "u1"),
        ("station", "<u2"),
    ]
)


def write_cloud(path: Path, tiles: Tiles, emit: Emit, most_points: int = MOST_POINTS) -> int:
    """Write at most ``most_points`` points and give their number; metres, site frame.

    ``station`` counts the stations in the survey's order, from 0.

    Raises:
        StageError: the path cannot be written, or a tile is not there.
    """
    kept = _kept(tiles.counts, most_points)
    paint = np.array([colours.of_station(n) for n in range(len(tiles.stations))], dtype=np.uint8)
    reader = TileReader(tiles, most_points=1)
    with replacing(path, "report") as temporary, temporary.open("wb") as file:
        file.write(_header(int(kept.sum())))
        for number, (cell, count, wanted) in enumerate(zip(tiles.cells, tiles.counts, kept, strict=True)):
            if wanted:
                points = reader.tile(tuple(cell.tolist()))
                chosen = points.where(np.arange(wanted, dtype=np.int64) * int(count) // wanted)
                file.write(_rows(chosen.places, chosen.stations, paint))
            emit(Event(stage="report", done=number, total=len(tiles.cells)))
    return int(kept.sum())


def _kept(counts: np.ndarray, most_points: int) -> np.ndarray:
    """How many points of each tile stay: the same share of each, in whole numbers that sum up."""
    share = min(1.0, most_points / max(int(counts.sum()), 1))
    return np.diff(np.floor(share * np.concatenate([[0], np.cumsum(counts)]) + 1e-6)).astype(np.int64)


def _rows(places: np.ndarray, stations: np.ndarray, paint: np.ndarray) -> bytes:
    rows = np.empty(len(places), dtype=_ROW)
    for axis, name in enumerate(("x", "y", "z")):
        rows[name] = places[:, axis]
    for axis, name in enumerate(("red", "green", "blue")):
        rows[name] = paint[stations, axis]
    rows["station"] = stations
    return rows.tobytes()


def _header(count: int) -> bytes:
    lines = [
        *("ply", "format binary_little_endian 1.0", "comment CableTwin; metres; site frame, z up"),
        f"element vertex {count}",
        *("property float x", "property float y", "property float z"),
        *("property uchar red", "property uchar green", "property uchar blue", "property ushort station"),
        "end_header\n",
    ]
    return "\n".join(lines).encode()
