"""The merged cloud: scanned and photo points together, each saying where it came from.

Takes both clouds and a placement; writes a binary PLY with, per point, ``origin`` (the scan station's number
from 0, or -1 for a photo point) and ``intensity`` (0 where none).  CloudCompare shows both as scalar fields.
"""

from pathlib import Path

import numpy as np

from pipeline.core.files import replacing
from pipeline.steel.fuse_records import PHOTO, Fusion, PhotoCloud, ScanCloud

_POINT = np.dtype(
    [
        ("x", "<f4"), ("y", "<f4"), ("z", "<f4"),
        ("red", "|u1"), ("green", "|u1"), ("blue", "|u1"),
        ("origin", "<i2"), ("intensity", "<f4"),
    ]
)  # fmt: skip
_NAMES = {"<f4": "float", "|u1": "uchar", "<i2": "short"}
CHUNK = 500_000
SCAN_GREY = 160


def write_merged(
    path: Path,
    photo: PhotoCloud,
    scan: ScanCloud,
    fusion: Fusion,
    station_names: tuple[str, ...] = (),
    frame: str = "site",
) -> None:
    """Write the merged cloud, metres, in the frame of the scan (called ``frame`` in the file's heading).

    Raises:
        StageError: the file cannot be written.
    """
    lines = ["ply", "format binary_little_endian 1.0", f"comment CableTwin; metres; {frame} frame"]
    lines += [
        f"comment origin {PHOTO} is a photo; {number} is station {name}"
        for number, name in enumerate(station_names)
    ]
    lines += [f"element vertex {len(photo) + len(scan)}"]
    lines += [f"property {_NAMES[_POINT[name].str]} {name}" for name in _POINT.names or ()]
    with replacing(path, "fuse") as temporary, temporary.open("wb") as file:
        file.write(("\n".join([*lines, "end_header"]) + "\n").encode())
        for first in range(0, len(scan), CHUNK):
            some = slice(first, first + CHUNK)
            rows = _rows(scan.points[some])
            rows["origin"] = scan.stations[some]
            if len(scan.intensities):
                rows["intensity"] = scan.intensities[some]
            for colour in ("red", "green", "blue"):
                rows[colour] = SCAN_GREY
            file.write(rows.tobytes())
        for first in range(0, len(photo), CHUNK):
            some = slice(first, first + CHUNK)
            rows = _rows(fusion.placement.apply(photo.points[some]))
            rows["origin"] = PHOTO
            for column, colour in enumerate(("red", "green", "blue")):
                rows[colour] = photo.colours[some, column]
            file.write(rows.tobytes())


def _rows(points: np.ndarray) -> np.ndarray:
    rows = np.zeros(len(points), dtype=_POINT)
    for column, axis in enumerate("xyz"):
        rows[axis] = points[:, column]
    return rows
