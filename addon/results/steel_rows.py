"""What a finished steel run tells, as the scene and the panels take it: frozen rows.  Needs no bpy."""

from dataclasses import dataclass
from pathlib import Path

type Place = tuple[float, float, float]
"""Metres in the site frame."""
type Rows = tuple[Place, Place, Place]
"""A 3 x 3 matrix by its rows."""


@dataclass(frozen=True, kw_only=True)
class Station:
    """A scanner: ``rotation`` is site from station, ``covariance_mm2`` that of its position."""

    name: str
    place: Place
    rotation: Rows
    covariance_mm2: Rows
    sigma_mm: float


@dataclass(frozen=True, kw_only=True)
class Target:
    """A target where the adjustment put it; ``kind`` is point, line or plane."""

    name: str
    kind: str
    place: Place


@dataclass(frozen=True, kw_only=True)
class Gross:
    """Observations of one target that are wrong in one way; ``offset_mm`` is seen minus expected."""

    target: str
    kind: str
    stations: tuple[str, ...]
    offset_mm: Place
    size_mm: float
    fits: str


@dataclass(frozen=True, kw_only=True)
class Tube:
    """A rod or column by its axis."""

    name: str
    start: Place
    end: Place
    radius_m: float


@dataclass(frozen=True, kw_only=True)
class Node:
    """A ball, and how far its rods meet beside it; ``rods`` is NaN where too few were seen."""

    name: str
    ball: Place
    radius_m: float
    rods: Place
    eccentricity_mm: Place
    size_mm: float
    sigma_mm: float
    significant: bool


@dataclass(frozen=True, kw_only=True)
class Column:
    """A column against its limit; ``ratio`` is the n of 1/n, NaN where it does not lean."""

    name: str
    axis: Tube
    deviation_mm: float
    sigma_mm: float
    direction: str
    ratio: float
    limit_mm: float
    over: bool
    certain: bool


@dataclass(frozen=True, kw_only=True)
class Sag:
    """The grid's deflection against its limit."""

    largest_mm: float
    limit_mm: float
    node: str
    over: bool


@dataclass(frozen=True, kw_only=True)
class SteelRows:
    """Everything that the scene and the panels show of a steel run, but its clouds.

    Attributes:
        folder: absolute.
        balls: those of no node; ``uprights`` columns that no row judges.
    """

    folder: Path
    stations: tuple[Station, ...]
    targets: tuple[Target, ...]
    gross: tuple[Gross, ...]
    rods: tuple[Tube, ...]
    uprights: tuple[Tube, ...]
    nodes: tuple[Node, ...]
    columns: tuple[Column, ...]
    sag: Sag | None
    warnings: tuple[str, ...]
