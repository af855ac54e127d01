"""The run of a long survey: which of its segments is shown, and where along the cable that one lies.

Such a run has a run folder for each segment, whose positions count from the segment's own first frame.  Read
here, a segment lies at its place on the whole cable, with the whole's report.
"""

import json
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pipeline.opened import OpenedRun, open_run, whole_of
from pipeline.segments.plan import SEGMENTS

if TYPE_CHECKING:
    from pipeline.cable.measure import Measurement


def segments_of(folder: Path) -> tuple[Path, ...]:
    """The run folders of the segments, in order; none where the run was not cut."""
    if (folder / "products" / "all-mosaic.npz").exists():
        return ()
    return tuple(sorted(p.parent for p in (folder / SEGMENTS).glob("*/products")))


def chosen(folder: Path, number: int) -> Path:
    """The segment with this number, from 1, or the one nearest to it; of a run without segments itself."""
    parts = segments_of(folder)
    return parts[min(max(number, 1), len(parts)) - 1] if parts else folder


def number_of(folder: Path) -> int:
    """Which segment of its run this folder is, from 1; 0 where it is none."""
    parts = segments_of(whole_of(folder))
    return parts.index(folder) + 1 if folder in parts else 0


def start_m(folder: Path) -> float:
    """Place of a run's own origin along the whole cable; 0 where that is not known yet."""
    told = _report(whole_of(folder)) if number_of(folder) else {}
    return next((float(s["start_m"]) for s in told.get("segments", ()) if s["name"] == folder.name), 0.0)


def read_run(folder: Path) -> OpenedRun:
    """Read what is finished of a run or of a segment, in the whole cable's places.

    Raises:
        StageError: as :func:`pipeline.opened.open_run`.
    """
    run = open_run(folder)
    if not number_of(run.folder):
        return run
    by_m = start_m(run.folder)
    return replace(
        run,
        blocks=tuple(replace(b, cable_from_block=along(by_m) @ b.cable_from_block) for b in run.blocks),
        ring=run.ring and replace(run.ring, y_m=run.ring.y_m + by_m, picture_y_m=run.ring.picture_y_m + by_m),
        measurement=run.measurement and _moved(run.measurement, by_m),
        report=_report(whole_of(run.folder)) or run.report,
    )


def along(by_m: float) -> np.ndarray:
    """(4, 4): moved along the cable."""
    matrix = np.eye(4)
    matrix[1, 3] = by_m
    return matrix


def _moved(measured: "Measurement", by_m: float) -> "Measurement":
    relief = measured.relief
    features = tuple(replace(f, position_m=f.position_m + by_m) for f in relief.features)
    return replace(
        measured,
        sections=tuple(replace(s, position_m=s.position_m + by_m) for s in measured.sections),
        profile_y_m=measured.profile_y_m + by_m,
        relief=replace(relief, y_m=relief.y_m + by_m, features=features),
    )


def _report(folder: Path) -> dict:
    file = folder / "report.json"
    return json.loads(file.read_text(encoding="utf-8")) if file.is_file() else {}
