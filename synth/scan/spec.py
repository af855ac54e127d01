"""The specification of a synthetic scan of a steel space frame: frozen records, units in the names.

Gives what SPEC.toml may say and its strict reading; leaves out what follows from it (see the other modules).
The hall's frame, in which places are given: metres, x east, y north, z up from the floor, origin at the
corner column of the frame.
"""

import tomllib
from dataclasses import dataclass, field, replace
from enum import StrEnum
from pathlib import Path

from pipeline.core.errors import StageError
from pipeline.core.options import build
from synth.scan.spec_hall import Box as Box
from synth.scan.spec_hall import CablePlace as CablePlace
from synth.scan.spec_hall import Eccentric as Eccentric
from synth.scan.spec_hall import Room as Room
from synth.scan.spec_hall import Structure as Structure
from synth.scan.spec_hall import Targets as Targets
from synth.scan.spec_photos import Photos as Photos

STAGE = "spec"


class Level(StrEnum):
    """How far the survey is played through."""

    TARGETS = "targets"
    CLOUDS = "clouds"


class CloudFormat(StrEnum):
    """File format of the stations' clouds."""

    E57 = "e57"
    LAS = "las"
    LAZ = "laz"
    PLY = "ply"
    PTS = "pts"
    XYZ = "xyz"


class Unit(StrEnum):
    """Unit of the coordinates in the clouds."""

    METRE = "m"
    MILLIMETRE = "mm"


@dataclass(frozen=True, kw_only=True)
class Stations:
    """Where the scanner stands.

    Attributes:
        count: stations along x and y, on a grid over the hall's floor, named S001... in the order of a walk
            that goes across (y) and back and slowly along (x).
        at_m: (x, y) of further ones, stated, at the end of the walk.
        jitter_m: each stands within so much of its place, in x and in y; farther where there is no room.
        height_m: of the scanner's centre over the floor; it varies by a tenth of a metre.
        level_sigma_arcsec: what the compensator leaves of tilt, about each of the horizontal axes.
        clear_m: least distance to a column's or target's surface.
    """

    count: tuple[int, int] = field(default=(2, 2), metadata={"minimum": 0})
    at_m: tuple[tuple[float, float], ...] = ()
    jitter_m: float = field(default=0.5, metadata={"minimum": 0.0})
    height_m: float = field(default=1.7, metadata={"above": 0.2})
    level_sigma_arcsec: float = field(default=0.0, metadata={"minimum": 0.0})
    clear_m: float = field(default=0.8, metadata={"minimum": 0.0})


@dataclass(frozen=True, kw_only=True)
class Scanner:
    """What the instrument does to a ray.

    Attributes:
        range_sigma_mm: noise of one range.
        angle_sigma_arcsec: noise of the horizontal and of the vertical angle.
        step_deg: between neighbouring rays, horizontally and vertically.
        elevation_deg: lowest and highest ray.
        min_range_m, max_range_m: nothing nearer or farther comes back.
        divergence_mrad: full opening angle of the beam; 0 makes every ray a line.
        sub_rays: of a beam that grazes an edge; their ranges are averaged to a mixed pixel.
        incidence_limit_deg: nothing comes back that is hit at a flatter angle off the normal.
        format, unit: of the clouds.
    """

    range_sigma_mm: float = field(default=2.0, metadata={"minimum": 0.0})
    angle_sigma_arcsec: float = field(default=8.0, metadata={"minimum": 0.0})
    step_deg: float = field(default=0.2, metadata={"minimum": 0.01, "maximum": 10.0})
    elevation_deg: tuple[float, float] = field(
        default=(-60.0, 90.0), metadata={"minimum": -90.0, "maximum": 90.0}
    )
    min_range_m: float = field(default=0.4, metadata={"minimum": 0.0})
    max_range_m: float = field(default=60.0, metadata={"above": 0.0})
    divergence_mrad: float = field(default=0.4, metadata={"minimum": 0.0, "maximum": 20.0})
    sub_rays: int = field(default=12, metadata={"minimum": 3, "maximum": 100})
    incidence_limit_deg: float = field(default=86.0, metadata={"above": 0.0, "maximum": 90.0})
    format: CloudFormat = CloudFormat.E57
    unit: Unit = Unit.METRE


@dataclass(frozen=True, kw_only=True)
class Moved:
    """Somebody knocks a target between two stations.

    Attributes:
        target: its name.
        by_mm: how far, in a seeded horizontal direction.
        from_station: number of the first station that sees it in its new place, counted from 1.
    """

    target: str
    by_mm: float = field(default=50.0, metadata={"above": 0.0})
    from_station: int = field(default=2, metadata={"minimum": 2})


@dataclass(frozen=True, kw_only=True)
class Misnamed:
    """A target noted under a wrong name in one station's list.

    Attributes:
        station: its name.
        target: the true name; None takes one of the station's list.
        called: the wrong name; None takes the nearest that is not in the station's list.
    """

    station: str
    target: str | None = None
    called: str | None = None


@dataclass(frozen=True, kw_only=True)
class Gross:
    """Gross errors."""

    moved: tuple[Moved, ...] = ()
    misnamed: tuple[Misnamed, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Claims:
    """What survey.toml says beyond the data.

    Attributes:
        lists: the targets' lists are written though there are clouds.
        named_sigma: the lists carry the targets' true sigma_mm.
        control: names of targets whose places are known, in the base station's true frame.
        control_sigma_mm: of each of their coordinates, true and stated.
        nominal: diameters of rods, balls and columns are stated.
        deflection_limit: span over this.
        column_limit_mm: of a column's deviation.
    """

    lists: bool = False
    named_sigma: bool = False
    control: tuple[str, ...] = ()
    control_sigma_mm: float = field(default=1.0, metadata={"above": 0.0})
    nominal: bool = True
    deflection_limit: float = field(default=250.0, metadata={"above": 0.0})
    column_limit_mm: float = field(default=35.0, metadata={"above": 0.0})


@dataclass(frozen=True, kw_only=True)
class ScanSpec:
    """A whole synthetic survey of a steel structure.

    Attributes:
        name: of the survey.
        seed: of everything random.
        level: targets (lists only, seconds) or clouds.
        cable: a stay cable in the hall, or none.
        photos: a flight above the frame, or none.
    """

    name: str
    seed: int = field(default=1, metadata={"minimum": 0})
    level: Level = Level.CLOUDS
    structure: Structure = field(default_factory=Structure)
    room: Room = field(default_factory=Room)
    stations: Stations = field(default_factory=Stations)
    targets: Targets = field(default_factory=Targets)
    scanner: Scanner = field(default_factory=Scanner)
    gross: Gross = field(default_factory=Gross)
    survey: Claims = field(default_factory=Claims)
    cable: CablePlace | None = None
    photos: Photos | None = None


def read_scan_spec(path: Path) -> ScanSpec:
    """Read and check a specification.

    Args:
        path: a TOML file.

    Raises:
        StageError: the file is missing, no TOML, or says something unknown or impossible.
    """
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise StageError(STAGE, f"{path} cannot be read ({error})", "name an existing SPEC.toml") from error
    except tomllib.TOMLDecodeError as error:
        raise StageError(STAGE, f"{path} is not TOML ({error})", "correct that line") from error
    spec = build(ScanSpec, table, stage=STAGE)
    if spec.cable is not None:
        spec = replace(spec, cable=replace(spec.cable, spec=str(path.parent / spec.cable.spec)))
    check_scan_spec(spec)
    return spec


def check_scan_spec(spec: ScanSpec) -> None:
    """Refuse what only a look at several keys can refuse; raises StageError naming the key."""
    low_deg, high_deg = spec.scanner.elevation_deg
    if low_deg >= high_deg:
        raise StageError(STAGE, f"scanner.elevation_deg is {low_deg} to {high_deg}", "give the lower first")
    if spec.stations.count[0] * spec.stations.count[1] + len(spec.stations.at_m) == 0:
        raise StageError(STAGE, "stations.count leaves no station", "give some, or stations.at_m")
    if spec.scanner.min_range_m >= spec.scanner.max_range_m:
        raise StageError(STAGE, "scanner.min_range_m is not below max_range_m", "give the lower first")
    if spec.gross.misnamed and spec.level == Level.CLOUDS and not spec.survey.lists:
        raise StageError(STAGE, "gross.misnamed needs the targets' lists", "set survey.lists = true")
    least, most = spec.structure.tilt_mm
    if least > most:
        raise StageError(STAGE, f"structure.tilt_mm is {least} to {most}", "give the lower first")
    thickest_mm = max(spec.structure.chord_diameter_mm, spec.structure.diagonal_diameter_mm)
    shift_mm = max([spec.structure.eccentric_mm, *(_length(e.offset_mm) for e in spec.structure.eccentric)])
    if thickest_mm / 2.0 + shift_mm >= spec.structure.ball_diameter_mm / 2.0:
        raise StageError(
            STAGE, "structure.ball_diameter_mm leaves no room for the rods", "give thicker balls"
        )
    if spec.targets.least > spec.targets.nearest:
        raise StageError(STAGE, "targets.least is above targets.nearest", "lower it")


def _length(vector: tuple[float, float, float]) -> float:
    return float(sum(v * v for v in vector)) ** 0.5
