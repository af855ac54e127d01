"""The run of a long survey: which of its segments is shown, and where on the cable that one lies.

Such a run has a run folder for each segment, whose positions count from the segment's own first frame, and
whose azimuths from the robot as it hung there.  Read here, a segment lies at its place on the whole cable,
with the whole's report.  How its axis leans out of its neighbours' is told there and not drawn.
"""

import json
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pipeline.opened import OpenedRun, open_run, whole_of
from pipeline.segments.plan import SEGMENTS

if TYPE_CHECKING:
    from pipeline.cable.measure import Measurement
    from pipeline.cable.ring import Ring
    from pipeline.core.vocabulary import Array


@dataclass(frozen=True, kw_only=True)
class Place:
    """Where a run lies on the whole cable.

    Attributes:
        start_m: of its own origin, along the cable; 0 where that is not known yet, or the run is the whole.
        roll: added to its azimuths gives those of the whole, radians.
    """

    start_m: float = 0.0
    roll: float = 0.0

    @property
    def turned(self) -> "Array":
        """(2, 2): x and z across the cable, from the run to the whole (right-handed about +y)."""
        cos, sin = math.cos(self.roll), math.sin(self.roll)
        return np.array([[cos, sin], [-sin, cos]])

    @property
    def whole_from_run(self) -> "Array":
        """(4, 4), metres."""
        matrix = np.eye(4)
        matrix[np.ix_([0, 2], [0, 2])] = self.turned
        matrix[1, 3] = self.start_m
        return matrix


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


def place_of(folder: Path) -> Place:
    """Where a run, or a segment of one, lies on the whole cable."""
    told = _report(whole_of(folder)) if number_of(folder) else {}
    for row in told.get("segments", ()):
        if row["name"] == folder.name:
            return Place(start_m=float(row["start_m"]), roll=math.radians(row.get("roll_deg", 0.0)))
    return Place()


def read_run(folder: Path) -> OpenedRun:
    """Read what is finished of a run or of a segment, in the whole cable's places.

    Raises:
        StageError: as :func:`pipeline.opened.open_run`.
    """
    run = open_run(folder)
    if not number_of(run.folder):
        return run
    place = place_of(run.folder)
    whole_from_run = place.whole_from_run
    return replace(
        run,
        blocks=tuple(replace(b, cable_from_block=whole_from_run @ b.cable_from_block) for b in run.blocks),
        ring=run.ring and _moved_ring(run.ring, place),
        measurement=run.measurement and _moved(run.measurement, place),
        report=_report(whole_of(run.folder)) or run.report,
    )


def _moved_ring(ring: "Ring", place: Place) -> "Ring":
    return replace(
        ring,
        y_m=ring.y_m + place.start_m,
        azimuth=ring.azimuth + place.roll,
        picture_y_m=ring.picture_y_m + place.start_m,
        picture_azimuth=ring.picture_azimuth + place.roll,
    )


def _moved(measured: "Measurement", place: Place) -> "Measurement":
    relief, by_m, turned = measured.relief, place.start_m, place.turned.T
    sections = tuple(
        replace(
            s, position_m=s.position_m + by_m, centre_mm=s.centre_mm @ turned, points_mm=s.points_mm @ turned
        )
        for s in measured.sections
    )
    features = tuple(
        replace(
            f,
            position_m=f.position_m + by_m,
            azimuth_deg=math.remainder(f.azimuth_deg + math.degrees(place.roll), 360.0),
        )
        for f in relief.features
    )
    return replace(
        measured,
        sections=sections,
        profile_y_m=measured.profile_y_m + by_m,
        profile_centre_mm=measured.profile_centre_mm @ turned,
        relief=replace(relief, y_m=relief.y_m + by_m, azimuth=relief.azimuth + place.roll, features=features),
    )


def _report(folder: Path) -> dict:
    file = folder / "report.json"
    return json.loads(file.read_text(encoding="utf-8")) if file.is_file() else {}
