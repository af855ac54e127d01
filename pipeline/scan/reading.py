"""A laser scan of a cable, read and cut down to the cable: what is joined with a photo model.

Takes cloud files that share one frame, and the cable's radius; gives the points on and near the cable with
their intensities, without each scan's limb (``limb.py``).  Files are read twice: thinned, to find the cable,
then in full, near it alone, so that memory stays bounded by what lies on the cable.  Leaves out bringing the
two together (:mod:`pipeline.scan.join`).
"""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event
from pipeline.core.vocabulary import Array
from pipeline.scan.limb import off_limb
from pipeline.scan.tube import FoundCable, find_cable
from pipeline.steel.cloud_readers import open_cloud
from pipeline.steel.fuse_records import ScanCloud
from pipeline.steel.survey_records import LengthUnit

STAGE = "scan"
ENDINGS = (".e57", ".las", ".laz", ".ply", ".pts", ".xyz")
SEARCHED = 3_000_000
"""The cable is looked for among so many points."""
MOST_NEAR = 6_000_000
"""More points on the cable are thinned."""
ASIDE = 0.35
"""Points up to this part of the radius off the surface are kept."""
SPARE_M = 0.05
"""The cable may go on so far beyond where the thinned points showed it."""
FARTHEST_M, NEAREST_M = 2000.0, 0.02
"""Scans in metres are not wider or narrower: the unit is another one."""


def read_scan(paths: Sequence[Path], unit: LengthUnit, radius_m: float, emit: Emit) -> ScanCloud:
    """Read the part of a scan that shows the cable.

    Args:
        paths: cloud files in one frame: one scan, or several that are registered.
        unit: of their coordinates.
        radius_m: of the cable, nearly.
        emit: progress of the stage *scan*.

    Returns:
        Points (metres, as scanned), the number of each one's file, and intensities where every file has them.

    Raises:
        StageError: a file is missing, of an unknown kind, broken or empty, the unit is wrong, or no cable of
            that radius is in it.
    """
    for path in paths:
        if not path.is_file():
            raise StageError(STAGE, f"{path} does not exist", "name a cloud file after --scan")
        if path.suffix.lower() not in ENDINGS:
            raise StageError(
                STAGE, f"{path} is no cloud that is known here", f"give one of {', '.join(ENDINGS)}"
            )
    some = np.concatenate([_thinned(path, unit, len(paths), emit) for path in paths])
    _check_unit(some, unit, paths[0])
    cable = find_cable(some, radius_m, lambda done: emit(Event(stage=STAGE, done=300 + done, total=1000)))
    if cable is None:
        raise StageError(
            STAGE,
            f"no cable of about {2000 * radius_m:.0f} mm diameter is in {', '.join(p.name for p in paths)}",
            "check --unit, or cut the scan down to the cable",
        )
    parts = [_near(path, unit, cable, number, len(paths), emit) for number, path in enumerate(paths)]
    parts = [part[off_limb(part[:, :3], cable)] for part in parts]
    points = np.concatenate(parts)
    files = np.concatenate([np.full(len(part), n) for n, part in enumerate(parts)])
    if len(points) > MOST_NEAR:
        chosen = np.sort(np.random.default_rng(len(points)).choice(len(points), MOST_NEAR, replace=False))
        points, files = points[chosen], files[chosen]
    bright = points[:, 3]
    return ScanCloud(
        points=points[:, :3],
        stations=files.astype(np.int64),
        scanners=np.zeros((0, 3)),
        intensities=bright if np.isfinite(bright).all() and np.ptp(bright) > 0 else np.zeros(0),
    )


def _runs(path: Path, unit: LengthUnit) -> Iterator[tuple[int, Array]]:
    """Announced points, and runs (n, 4) in metres without returns that never came."""
    with open_cloud(path, path.stem, bright=True) as cloud:
        for run in cloud.runs:
            points = run * [unit.in_metres, unit.in_metres, unit.in_metres, 1.0]
            yield cloud.announced, points[np.isfinite(points[:, :3]).all(axis=1) & points[:, :3].any(axis=1)]


def _thinned(path: Path, unit: LengthUnit, files: int, emit: Emit) -> Array:
    """(n, 3) every so many points of a file."""
    parts, read, most = [np.zeros((0, 3))], 0, SEARCHED // files
    for announced, run in _runs(path, unit):
        read += len(run)
        every = max(announced // most, 1)
        parts.append(run[::every, :3])
        emit(
            Event(
                stage=STAGE, done=min(300 * read // max(announced, read, 1), 300), total=1000, block=path.stem
            )
        )
    if read == 0:
        raise StageError(STAGE, f"{path} has no points", "export it again")
    return np.concatenate(parts)


def _near(path: Path, unit: LengthUnit, cable: FoundCable, number: int, files: int, emit: Emit) -> Array:
    """(n, 4) the points of a file on and near the cable."""
    parts, read = [np.zeros((0, 4))], 0
    for announced, run in _runs(path, unit):
        read += len(run)
        parts.append(run[cable.holds(run[:, :3], ASIDE * cable.radius_m, SPARE_M)])
        share = (number + min(read / max(announced, read, 1), 1.0)) / files
        emit(Event(stage=STAGE, done=600 + round(400 * share), total=1000, block=path.stem))
    return np.concatenate(parts)


def _check_unit(points: Array, unit: LengthUnit, path: Path) -> None:
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    if size > FARTHEST_M:
        raise StageError(STAGE, f"{path.name} is {size:.0f} m wide: these are millimetres", "give --unit mm")
    if size < NEAREST_M:
        other = "m" if unit is LengthUnit.MILLIMETRE else "mm"
        raise StageError(STAGE, f"{path.name} is {1000 * size:.2g} mm wide", f"give --unit {other}")
