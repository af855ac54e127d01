"""The points of a steel run, read from cloud.ply and merged.ply: one light cloud for each station.

Takes the run folder; gives objects that are in no collection yet, each in the colour of its station.  A file
is mapped, not read: only the points that are shown come into memory.
"""

from pathlib import Path

import bpy
import numpy as np

from pipeline.core.errors import StageError

from .clouds import cloud_object
from .materials import plain_material

POINT_M = 0.004
_TYPES = {"float": "<f4", "double": "<f8", "uchar": "u1", "char": "i1", "short": "<i2", "ushort": "<u2"}
_TYPES |= {"int": "<i4", "uint": "<u4"}
_LONGEST_HEADER = 20_000
_PHOTO = -1


def station_clouds(folder: Path, names: tuple[str, ...], most: int) -> list[bpy.types.Object]:
    """The registered cloud by stations, thinned evenly to at most ``most`` points; none without cloud.ply.

    Raises:
        StageError: the file is no such cloud, or cut off.
    """
    path = folder / "cloud.ply"
    if not path.is_file():
        return []
    rows = _thinned(path, most)
    found = []
    for number in np.unique(rows["station"]):
        own = rows[rows["station"] == number]
        name = names[number] if number < len(names) else str(number)
        colour = linear(*(int(own[key][0]) for key in ("red", "green", "blue")))
        made = cloud_object(f"{name} points", _points(own), None, POINT_M, len(own))
        made.data.materials[0] = plain_material(colour)
        made["cabletwin_name"] = name
        found.append(made)
    return found


def photo_cloud(folder: Path, most: int) -> list[bpy.types.Object]:
    """What the photos have added, in their own colours; none where nothing was fused.

    Raises:
        StageError: as for :func:`station_clouds`.
    """
    path = folder / "merged.ply"
    if not path.is_file():
        return []
    rows = _thinned(path, most)
    own = rows[rows["origin"] == _PHOTO]
    if not len(own):
        return []
    colours = np.stack([own[key] for key in ("red", "green", "blue")], axis=1)
    return [cloud_object("Photo points", _points(own), colours, POINT_M, len(own))]


def linear(red: int, green: int, blue: int) -> tuple[float, float, float, float]:
    """A material's colour of an sRGB one, 0 to 255 (IEC 61966-2-1)."""
    parts = [value / 255 for value in (red, green, blue)]
    r, g, b = (v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in parts)
    return r, g, b, 1.0


def _thinned(path: Path, most: int) -> np.ndarray:
    """Every n-th row of a binary PLY's vertices."""
    try:
        with path.open("rb") as file:
            head = file.read(_LONGEST_HEADER)
        end = head.index(b"end_header\n") + len(b"end_header\n")
        words = [line.split() for line in head[:end].decode("ascii").splitlines()]
        count = next(int(w[2]) for w in words if w[:2] == ["element", "vertex"])
        kind = np.dtype([(w[2], _TYPES[w[1]]) for w in words if w[0] == "property"])
        if ["format", "binary_little_endian", "1.0"] not in words or not count:
            raise ValueError(path)
        rows = np.memmap(path, dtype=kind, mode="r", offset=end, shape=(count,))
        return np.array(rows[:: max(-(-count // most), 1)])
    except (OSError, ValueError, KeyError, IndexError, StopIteration) as error:
        raise StageError("run", f"{path} is damaged or cut off", "run the reconstruction again") from error


def _points(rows: np.ndarray) -> np.ndarray:
    return np.stack([rows["x"], rows["y"], rows["z"]], axis=1)
