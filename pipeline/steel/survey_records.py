"""The records of a steel survey: scanner, targets, stations, structure and photos, as the user wrote them.

Frozen records with units in their names; frames as in :mod:`pipeline.steel.records`.  Leaves out reading and
checking the file (``survey.py``) and the clouds themselves (``clouds.py``).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from math import pi
from pathlib import Path

RADIANS_PER_ARCSEC = pi / (180 * 3600)


class LengthUnit(StrEnum):
    """Unit in which a cloud is written."""

    METRE = "m"
    MILLIMETRE = "mm"

    @property
    def in_metres(self) -> float:
        """Length of one unit."""
        return 1.0 if self is LengthUnit.METRE else 1e-3


@dataclass(frozen=True, kw_only=True)
class Scanner:
    """What one measured point is worth.

    Attributes:
        range_sigma_mm: standard deviation of a distance.
        angle_sigma_arcsec: of a direction, horizontally and vertically alike.
        levelled: a compensator keeps the station's z axis plumb.
        level_sigma_arcsec: standard deviation of that, about each horizontal axis.
    """

    range_sigma_mm: float = field(default=2.0, metadata={"above": 0.0})
    angle_sigma_arcsec: float = field(default=8.0, metadata={"above": 0.0})
    levelled: bool = False
    level_sigma_arcsec: float = field(default=5.0, metadata={"above": 0.0})

    @property
    def range_sigma_m(self) -> float:
        """Standard deviation of a distance, metres."""
        return self.range_sigma_mm / 1000

    @property
    def angle_sigma_rad(self) -> float:
        """Standard deviation of a direction, radians."""
        return self.angle_sigma_arcsec * RADIANS_PER_ARCSEC

    @property
    def level_sigma_rad(self) -> float:
        """Standard deviation of the plumb direction about each axis, radians."""
        return self.level_sigma_arcsec * RADIANS_PER_ARCSEC


@dataclass(frozen=True, kw_only=True)
class Targets:
    """The sphere targets.

    Attributes:
        radius_mm: of the spheres; None where targets are named by hand and none is looked for.
    """

    radius_mm: float | None = field(default=None, metadata={"above": 0.0})


@dataclass(frozen=True, kw_only=True)
class ScanStation:
    """One set-up of the scanner.

    Attributes:
        name: unique, usable as the name of a file.
        cloud: absolute path of its points in the station frame; None where only targets are known.
        unit: of the cloud.
        targets: absolute path of a table of targets named by hand; None without one.
        names: absolute path of a table that names targets, axes and planes of the cloud; None without one.
        base: the site frame is this station's.
    """

    name: str
    cloud: Path | None = None
    unit: LengthUnit = LengthUnit.METRE
    targets: Path | None = None
    names: Path | None = None
    base: bool = False


@dataclass(frozen=True, kw_only=True)
class ControlTarget:
    """A target whose place in the site frame is known.

    Attributes:
        name: of the target.
        position_m: in the site frame.
        sigma_mm: standard deviation of each coordinate.
    """

    name: str
    position_m: tuple[float, float, float]
    sigma_mm: float = field(default=1.0, metadata={"above": 0.0})


@dataclass(frozen=True, kw_only=True)
class Structure:
    """What is known of the structure; nominal values narrow searches and never enter a result.

    Attributes:
        north_deg: azimuth of north, counted clockwise from the site's +y.
        rod_diameters_mm, ball_diameters_mm, column_diameters_mm: nominal.
        span_m: of the grid; None where its deflection is not judged.
        deflection_limit: the deflection may be span / this.
        column_limit_mm: how far a column's top may be off its foot.
    """

    north_deg: float = 0.0
    rod_diameters_mm: tuple[float, ...] = field(default=(), metadata={"above": 0.0})
    ball_diameters_mm: tuple[float, ...] = field(default=(), metadata={"above": 0.0})
    column_diameters_mm: tuple[float, ...] = field(default=(), metadata={"above": 0.0})
    span_m: float | None = field(default=None, metadata={"above": 0.0})
    deflection_limit: float = field(default=250.0, metadata={"above": 0.0})
    column_limit_mm: float = field(default=35.0, metadata={"above": 0.0})


@dataclass(frozen=True, kw_only=True)
class ColumnSpec:
    """A column that is to be judged.

    Attributes:
        name: as on the drawing.
        place_m: roughly, site frame, within half a metre.
        bottom_m, top_m: heights (site z) between which the axis is judged.
    """

    name: str
    place_m: tuple[float, float]
    bottom_m: float
    top_m: float


@dataclass(frozen=True, kw_only=True)
class PhotoSet:
    """Photos of the structure.

    Attributes:
        source: absolute path of the folder of pictures.
        focal_px: starting value of the focal length.
    """

    source: Path
    focal_px: float = field(metadata={"above": 0.0})


@dataclass(frozen=True, kw_only=True)
class SteelSurvey:
    """The whole survey.

    Attributes:
        format: version of the file's layout, 1.
        kind: "steel".
        name: of the structure.
        scanner, targets, structure: what is known of them.
        stations: two at least.
        control: targets that define the site frame; empty: the base station's frame is the site's.
        columns: to be judged.
        photos: None without.
        options: stage to key to value, as written in ``[options.STAGE]``.
    """

    format: int
    kind: str
    name: str
    scanner: Scanner = field(default_factory=Scanner)
    targets: Targets = field(default_factory=Targets)
    stations: tuple[ScanStation, ...] = field(metadata={"key": "station"})
    control: tuple[ControlTarget, ...] = ()
    structure: Structure = field(default_factory=Structure)
    columns: tuple[ColumnSpec, ...] = field(default=(), metadata={"key": "column"})
    photos: PhotoSet | None = None
    options: Mapping[str, object] = field(default_factory=dict)

    @property
    def base(self) -> ScanStation:
        """The station whose frame is the site's, where no control targets define it."""
        return next((station for station in self.stations if station.base), self.stations[0])

    def stage_options(self, stage: str) -> Mapping[str, object]:
        """The table ``[options.STAGE]``, empty where the file has none."""
        table = self.options.get(stage, {})
        return table if isinstance(table, Mapping) else {}
