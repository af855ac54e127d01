"""Stage *clouds*: the points of one station, whatever its file's format, as RUN/stations/NAME.npy.

Takes a station of the survey; writes float32 (n, 3) metres in the station frame, streamed: memory does not
grow with the cloud.  :func:`station_points` reads it back memory-mapped.  Leaves out intensities and colours.
Points at the scanner itself (exactly 0, 0, 0) are returns that never came, and are dropped.
"""

from dataclasses import dataclass
from io import BufferedWriter
from pathlib import Path

import numpy as np
from numpy.lib.format import write_array_header_1_0
from numpy.typing import NDArray

from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event
from pipeline.core.files import replacing
from pipeline.core.vocabulary import Array
from pipeline.steel.cloud_readers import cloud_error, open_cloud
from pipeline.steel.survey_records import LengthUnit, ScanStation

FARTHEST_MEDIAN_M = 500.0
"""Half of a station's points are never farther off than this: such coordinates are millimetres."""
NEAREST_MEDIAN_M = 0.5
"""Nor all nearer than this: such coordinates were metres."""
SAMPLED = 1000
"""Distances noted of each run, to judge the unit."""


@dataclass(frozen=True, kw_only=True)
class StationCloud:
    """What was imported.

    Attributes:
        station: name.
        points: how many.
        path: of the .npy file.
        median_range_m: half of the points are nearer.
    """

    station: str
    points: int
    path: Path
    median_range_m: float


def import_cloud(station: ScanStation, out: Path, emit: Emit) -> StationCloud:
    """Write the cloud of a station to ``out`` / NAME.npy, float32 (n, 3) metres, whole or not at all.

    Args:
        station: with a cloud.
        out: folder, RUN/stations.
        emit: progress.

    Raises:
        StageError: the file is empty, truncated, unreadable, has too few columns or coordinates that are no
            numbers, or is plainly in another unit than said.
    """
    if station.cloud is None:
        raise cloud_error(station.name, "no cloud is named", "give station.cloud in the survey")
    path = out / f"{station.name}.npy"
    with replacing(path, "clouds") as temporary, temporary.open("wb") as file:
        count, sampled = _write(file, station, station.cloud, emit)
    median = float(np.median(sampled))
    return StationCloud(station=station.name, points=count, path=path, median_range_m=median)


def station_points(path: Path) -> NDArray[np.float32]:
    """The points of a station (n, 3), station frame, metres; memory-mapped, read-only.

    Raises:
        StageError: the file is gone or none of ours.
    """
    try:
        points: NDArray[np.float32] = np.load(path, mmap_mode="r", allow_pickle=False)
    except (OSError, ValueError, EOFError) as error:
        raise StageError("clouds", f"{path} cannot be read", "import the station's cloud again") from error
    return points


def _write(file: BufferedWriter, station: ScanStation, source: Path, emit: Emit) -> tuple[int, Array]:
    _write_header(file, 0)
    count, read, sampled = 0, 0, [np.zeros(0)]
    with open_cloud(source, station.name) as cloud:
        for run in cloud.runs:
            read += len(run)
            points = _checked(run * station.unit.in_metres, station)
            file.write(np.ascontiguousarray(points, dtype=np.float32).tobytes())
            count += len(points)
            sampled.append(np.linalg.norm(points[:: max(len(points) // SAMPLED, 1)], axis=1))
            total = max(cloud.announced, read, 1)
            emit(Event(stage="clouds", done=read, total=total, block=station.name))
        announced = cloud.announced
    ranges = np.concatenate(sampled)
    if count == 0:
        raise cloud_error(station.name, f"{source.name} has no points", "export it again")
    if source.suffix.lower() in (".las", ".laz", ".pts") and read < announced:
        raise cloud_error(
            station.name,
            f"{source.name} breaks off after {read} of {announced} points",
            "export or copy it again",
        )
    _check_unit(float(np.median(ranges)), station, source)
    file.seek(0)
    _write_header(file, count)
    return count, ranges


def _write_header(file: BufferedWriter, count: int) -> None:
    # numpy pads the header so that the first dimension may grow in place
    write_array_header_1_0(file, {"descr": "<f4", "fortran_order": False, "shape": (count, 3)})


def _checked(points: Array, station: ScanStation) -> Array:
    bad = ~np.isfinite(points).all(axis=1)
    name = station.cloud.name if station.cloud else ""
    if bad.any():
        raise cloud_error(
            station.name,
            f"{name} has coordinates that are no numbers, {int(bad.sum())} of {len(points)} points read",
            "export it without invalid points",
        )
    return points[points.any(axis=1)]


def _check_unit(median_m: float, station: ScanStation, source: Path) -> None:
    key = f"station[{station.name}].unit"
    far = f"half of the points of {source.name} are over {median_m:.0f} m away"
    if median_m / 1000 > FARTHEST_MEDIAN_M or (
        median_m > FARTHEST_MEDIAN_M and station.unit is LengthUnit.MILLIMETRE
    ):
        raise cloud_error(station.name, far, "export it in the scanner's own frame")
    if median_m > FARTHEST_MEDIAN_M:
        raise cloud_error(
            station.name,
            f"{far}: these are millimetres",
            f'give {key} = "mm", or export it in the scanner\'s own frame',
        )
    if median_m < NEAREST_MEDIAN_M and station.unit is LengthUnit.MILLIMETRE:
        raise cloud_error(
            station.name,
            f"half of the points of {source.name} are within {median_m * 1000:.3g} mm: these are metres",
            f'give {key} = "m"',
        )
