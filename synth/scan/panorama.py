"""Casting a panorama's rays: every surface is held against the rays of its window in azimuth and elevation.

Takes a :class:`~synth.scan.primitives.World` in the station's frame and rays on a regular grid (their true
directions may be off the grid by noise); gives the nearest hit of each ray.  No tessellation: the surfaces
are exact, so nothing is biased.  Leaves out what the instrument does with a hit (:mod:`synth.scan.scanner`).
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.core.vocabulary import Array
from synth.scan.hits import HIT, Hit
from synth.scan.primitives import World

Indices = NDArray[np.int64]

# a window's area grows with the square of a piece's length, its overhead is fixed: found by timing
PIECE_LENGTH_RADII = 6.0


@dataclass(frozen=True, kw_only=True)
class Grid:
    """Nominal angles of the rays: ``azimuth`` (w,) evenly over the full circle, ``elevation`` (h,); radians.

    Azimuth counts from x to y, elevation from the horizontal up.
    """

    azimuth: Array
    elevation: Array

    def rows(self, low: float, high: float) -> slice:
        """Rows between two elevations."""
        first, last = np.searchsorted(self.elevation, [low, high], side="left")
        return slice(int(first), int(last))

    def columns(self, middle: float, half: float) -> list[slice]:
        """Columns within ``half`` of an azimuth; two slices where they cross the seam."""
        count = len(self.azimuth)
        step = 2.0 * math.pi / count
        if 2.0 * half + 2.0 * step >= 2.0 * math.pi:
            return [slice(0, count)]
        start = (middle - half - float(self.azimuth[0])) / step
        first = math.ceil(start) % count
        wide = math.floor(start + 2.0 * half / step) - math.ceil(start) + 1
        parts = [slice(first, min(first + wide, count)), slice(0, max(0, first + wide - count))]
        return [part for part in parts if part.stop > part.start]


@dataclass(frozen=True, kw_only=True)
class Canvas:
    """What each ray of a grid met first, all (h, w): range (inf: nothing), owner (-1), cosine of incidence.

    ``edge`` marks rays whose beam grazes an outline.
    """

    range_m: Array
    owner: Indices
    cosine: Array
    edge: NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True)
class Pieces:
    """Surfaces cut into pieces with a bounding sphere each: ``centre`` (n, 3), ``bound`` (n,) its radius."""

    kind: tuple[str, ...]
    index: Indices
    centre: Array
    bound: Array


def cut(world: World, reach_m: float) -> Pieces:
    """Cut a world into pieces; those farther than ``reach_m`` are left out."""
    kinds: list[str] = []
    rows: list[tuple[int, float, float, float, float]] = []
    for number, row in enumerate(world.sphere):
        kinds.append("sphere")
        rows.append((number, *row))
    for number, row in enumerate(world.cylinder):
        start, along, radius = row[:3], row[3:6] - row[:3], row[6]
        length = float(np.linalg.norm(along))
        parts = max(1, round(length / (PIECE_LENGTH_RADII * radius)))
        for k in range(parts):
            kinds.append("cylinder")
            middle = start + (k + 0.5) / parts * along
            rows.append((number, *middle, math.hypot(length / parts / 2.0, radius)))
    for number, row in enumerate(world.rectangle):
        kinds.append("rectangle")
        middle = row[:3] + (row[3:6] + row[6:]) / 2.0
        half = max(np.linalg.norm(row[3:6] + row[6:]), np.linalg.norm(row[3:6] - row[6:])) / 2.0
        rows.append((number, *middle, float(half)))
    for number, row in enumerate(world.disc):
        kinds.append("disc")
        rows.append((number, *row[:3], row[6]))
    for number, relief in enumerate(world.relief):
        low, high = relief.ends_m
        parts = max(1, round((high - low) / (PIECE_LENGTH_RADII * relief.tube_m)))
        for k in range(parts):
            kinds.append("relief")
            middle = relief.origin + (low + (k + 0.5) / parts * (high - low)) * relief.rotation[:, 1]
            rows.append((number, *middle, math.hypot((high - low) / parts / 2.0, relief.tube_m)))
    table = np.array(rows, float).reshape(-1, 5)
    near = np.flatnonzero(np.linalg.norm(table[:, 1:4], axis=1) - table[:, 4] <= reach_m)
    return Pieces(
        kind=tuple(kinds[i] for i in near),
        index=table[near, 0].astype(np.int64),
        centre=table[near, 1:4],
        bound=table[near, 4],
    )


def cast(world: World, pieces: Pieces, grid: Grid, directions: Array, pad: float, beam: float) -> Canvas:
    """Cast one ray per cell.

    Args:
        world, pieces: in the station's frame.
        grid: nominal angles.
        directions: (h, w, 3) true unit directions.
        pad: radians; no true direction is farther from its nominal one.
        beam: half the beam's opening angle, radians.
    """
    shape = directions.shape[:2]
    canvas = Canvas(
        range_m=np.full(shape, np.inf),
        owner=np.full(shape, -1, np.int64),
        cosine=np.zeros(shape),
        edge=np.zeros(shape, bool),
    )
    for number, rows, columns in windows(pieces, grid, pad + beam):
        kind, index = pieces.kind[number], pieces.index[number]
        hit = _hit(world, kind, index, directions[rows, columns])
        here = canvas.range_m[rows, columns]
        nearer = hit.range_m < here
        owner = getattr(world, f"{kind}_owner")[index]
        here[nearer] = hit.range_m[nearer]
        canvas.owner[rows, columns][nearer] = owner
        canvas.cosine[rows, columns][nearer] = hit.cosine[nearer]
        if beam > 0.0:
            wide_m = beam * (np.linalg.norm(pieces.centre[number]) + pieces.bound[number])
            canvas.edge[rows, columns] |= np.abs(hit.inside_m) < wide_m
    return canvas


def cast_beams(
    world: World, pieces: Pieces, grid: Grid, edge: NDArray[np.bool_], directions: Array, pad: float
) -> Array:
    """Cast several rays for each marked cell.

    Args:
        world, pieces, grid: as for :func:`cast`.
        edge: (h, w) the marked cells, n of them, in row order.
        directions: (n, k, 3) true unit directions of their rays.
        pad: radians; no direction is farther from its cell's nominal one.

    Returns:
        (n, k) ranges, inf where nothing was met.
    """
    number_of = np.full(edge.shape, -1, np.int64)
    number_of[edge] = np.arange(len(directions))
    ranges = np.full(directions.shape[:2], np.inf)
    for number, rows, columns in windows(pieces, grid, pad):
        cells = number_of[rows, columns]
        cells = cells[cells >= 0]
        if cells.size:
            kind, index = pieces.kind[number], pieces.index[number]
            hit = _hit(world, kind, index, directions[cells])
            ranges[cells] = np.minimum(ranges[cells], hit.range_m)
    return ranges


def _hit(world: World, kind: str, index: int, directions: Array) -> Hit:
    if kind == "relief":
        return world.relief[index].hit(directions)
    return HIT[kind](getattr(world, kind)[index], directions)


def windows(pieces: Pieces, grid: Grid, pad: float) -> Iterator[tuple[int, slice, slice]]:
    """The pieces' windows in the grid: number of the piece, rows, columns."""
    away = np.linalg.norm(pieces.centre, axis=1)
    aside = np.hypot(pieces.centre[:, 0], pieces.centre[:, 1])
    azimuth = np.arctan2(pieces.centre[:, 1], pieces.centre[:, 0])
    elevation = np.arctan2(pieces.centre[:, 2], aside)
    with np.errstate(divide="ignore", invalid="ignore"):
        half = np.where(away > pieces.bound, np.arcsin(np.minimum(1.0, pieces.bound / away)), math.pi) + pad
        # of a cap about (azimuth, elevation): sin(half width) = sin(half) / cos(elevation)
        ratio = np.where(half < math.pi / 2.0, np.sin(half) / np.cos(elevation), np.inf)
        turn = np.where(ratio < 1.0, np.arcsin(np.minimum(1.0, ratio)) + pad, math.pi)
    for number in range(len(pieces.index)):
        rows = grid.rows(elevation[number] - half[number], elevation[number] + half[number])
        if rows.stop > rows.start:
            for columns in grid.columns(float(azimuth[number]), float(turn[number])):
                yield number, rows, columns
