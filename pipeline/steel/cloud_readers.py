"""Points of one station out of a cloud file, run by run: E57, LAS, LAZ, PLY, PTS, XYZ.

Takes the path; gives runs of (n, 3) float64 coordinates as written, with intensities as a fourth column where
they are asked for, and how many the file announces.  Leaves out units, checks of the coordinates and colours.
The libraries are imported where they are used.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.core.vocabulary import Array
from pipeline.steel.cloud_texts import POINTS_PER_RUN, CloudRuns, open_text, with_bright
from pipeline.steel.cloud_texts import cloud_error as cloud_error

Errors = tuple[type[BaseException], ...]


_SPHERICAL = ("sphericalRange", "sphericalAzimuth", "sphericalElevation")
_CARTESIAN = ("cartesianX", "cartesianY", "cartesianZ")
_INVALID = ("cartesianInvalidState", "sphericalInvalidState")
_BRIGHT = ("intensity", "scalar_intensity", "scalar_Intensity", "Intensity", "reflectance")
"""What PLY files call it."""


@contextmanager
def open_cloud(path: Path, station: str, bright: bool = False) -> Iterator[CloudRuns]:
    """Open a cloud file by its ending; what the libraries raise about a broken file becomes one sentence.

    Args:
        path: of the file.
        station: whose it is, for what is said about it.
        bright: with intensities.

    Raises:
        StageError: the file cannot be read, is truncated, or holds no coordinates.
    """
    readers: dict[str, tuple[Callable[[Path, str, bool], Any], Callable[[], Errors]]] = {
        ".e57": (_e57, _e57_errors),
        ".las": (_las, _las_errors),
        ".laz": (_las, _las_errors),
        ".ply": (_ply, _ply_errors),
        ".pts": (open_text, lambda: ()),
        ".xyz": (open_text, lambda: ()),
    }
    reader, library_errors = readers[path.suffix.lower()]
    try:
        with reader(path, station, bright) as cloud:
            yield cloud
    except (OSError, EOFError, UnicodeDecodeError, *library_errors()) as error:  # type: ignore[misc]
        said = " ".join(str(error).split()).rstrip(".")
        raise cloud_error(
            station, f"{path.name} cannot be read to its end ({said[:150]})", "export or copy it again"
        ) from error


@contextmanager
def _e57(path: Path, station: str, bright: bool) -> Iterator[CloudRuns]:
    import pye57

    with path.open("rb"):
        pass  # a file that may not be read is told as such, and not as a broken one
    file = pye57.E57(str(path))
    try:
        if file.scan_count != 1:
            raise cloud_error(
                station, f"{path.name} holds {file.scan_count} scans", "export each station into its own file"
            )
        header = file.get_header(0)
        names = next((n for n in (_CARTESIAN, _SPHERICAL) if set(n) <= set(header.point_fields)), None)
        if names is None:
            raise cloud_error(station, f"{path.name} holds no coordinates", "export it with x, y and z")
        fields = [*names, *(n for n in _INVALID if n in header.point_fields)]
        if bright and "intensity" in header.point_fields:
            fields.append("intensity")
        yield CloudRuns(announced=header.point_count, runs=_e57_runs(file, header, fields, bright))
    finally:
        file.close()


def _e57_runs(
    file: Any,  # noqa: ANN401 - pye57 has no types
    header: Any,  # noqa: ANN401
    fields: list[str],
    bright: bool,
) -> Iterator[Array]:
    data, buffers = file.make_buffers(fields, POINTS_PER_RUN)
    reader = header.points.reader(buffers)
    while count := reader.read():
        points = np.column_stack([data[name][:count] for name in fields[:3]]).astype(float)
        if fields[0] == _SPHERICAL[0]:
            points = _cartesian(points)
        valid = np.ones(count, dtype=bool)
        for name in _INVALID:
            if name in fields:
                valid &= data[name][:count] == 0
        yield with_bright(points, data["intensity"][:count] if "intensity" in fields else None, bright)[valid]
    reader.close()


def _cartesian(spherical: Array) -> Array:
    """Range, azimuth, elevation (n, 3) of E57 to x, y, z."""
    distance, azimuth, elevation = spherical.T
    flat = distance * np.cos(elevation)
    return np.column_stack([flat * np.cos(azimuth), flat * np.sin(azimuth), distance * np.sin(elevation)])


def _e57_errors() -> Errors:
    import pye57
    from pye57.exception import PyE57Exception

    return (pye57.libe57.E57Exception, PyE57Exception)


@contextmanager
def _las(path: Path, station: str, bright: bool) -> Iterator[CloudRuns]:
    import laspy

    with laspy.open(path) as file:
        chunks = file.chunk_iterator(POINTS_PER_RUN)
        runs = (
            with_bright(np.column_stack([chunk.x, chunk.y, chunk.z]), chunk.intensity, bright)
            for chunk in chunks
        )
        yield CloudRuns(announced=file.header.point_count, runs=runs)


def _las_errors() -> Errors:
    import laspy
    import lazrs  # type: ignore[import-untyped]

    return (laspy.errors.LaspyException, lazrs.LazrsError, ValueError)


@contextmanager
def _ply(path: Path, station: str, bright: bool) -> Iterator[CloudRuns]:
    from plyfile import PlyData

    data = PlyData.read(str(path), mmap="c")
    elements = {element.name: element for element in data.elements}
    if "vertex" not in elements or not {"x", "y", "z"} <= {p.name for p in elements["vertex"].properties}:
        raise cloud_error(
            station, f"{path.name} has no vertex element with x, y and z", "export it as a point cloud"
        )
    vertices = elements["vertex"].data
    known = next((n for n in _BRIGHT if n in {p.name for p in elements["vertex"].properties}), None)

    def run(first: int) -> Array:
        rows = vertices[first : first + POINTS_PER_RUN]
        points = np.column_stack([rows[axis] for axis in "xyz"]).astype(float)
        return with_bright(points, None if known is None else rows[known], bright)

    runs = (run(first) for first in range(0, len(vertices), POINTS_PER_RUN))
    yield CloudRuns(announced=len(vertices), runs=runs)


def _ply_errors() -> Errors:
    from plyfile import PlyParseError

    return (PlyParseError, ValueError)
