"""Sphere targets of known radius in the cloud of one station.

Takes the station's range image; gives fitted spheres.  Where a sphere of radius R has its nearest point, the
ranges on opposite sides of a ring about it are, on average, deeper by what the sphere falls off there, in all
four directions.  A wall does not fall off, a column in one direction only, and a slope cancels between
opposite sides.  What passes is fitted (``sphere_fit.py``), which turns all else away.
"""

from math import cos, sin

import numpy as np
from numpy.typing import NDArray

from pipeline.core.events import Emit, Event
from pipeline.core.vocabulary import Array
from pipeline.steel.range_image import RangeImage
from pipeline.steel.sphere_fit import FittedSphere, disc_angle_rad, fit_target
from pipeline.steel.survey_records import Scanner

RING = 0.7
"""Radius of the ring, of that of the visible disc."""
MOST_RING = 0.8
"""The same at most, after rounding to whole cells."""
DIRECTIONS = 4
LEAST_PAIRS = 3
"""Pairs of opposite places on the ring that must fall off as the sphere does; the others may be empty."""
TILT = 0.2
"""How much deeper one side of the ring may be, of the radius: a cell is not just the nearest point."""
NOISE_SIGMAS = 4.0
ROWS_PER_RUN = 48
LEAST_CELLS = 2.5
"""Radius of a disc in cells below which nothing is looked for: a ring of one cell falls off too little."""
MOST_CANDIDATES = 20_000


def find_spheres(
    image: RangeImage,
    radius_m: float,
    scanner: Scanner,
    emit: Emit,
    station: str = "",
    other_radii_m: tuple[float, ...] = (),
) -> tuple[FittedSphere, ...]:
    """Find all targets of a radius, the nearest first; ``other_radii_m`` are spheres that are none."""
    centres = _candidates(image, radius_m, scanner, emit, station)
    found: list[FittedSphere] = []
    for number, start in enumerate(centres):
        if number % 50 == 0:
            emit(Event(stage="targets", done=50 + 50 * number // len(centres), total=100, block=station))
        if any(np.linalg.norm(start - sphere.centre) < radius_m for sphere in found):
            continue
        near = image.near(start, 1.2 * disc_angle_rad(start, radius_m))
        points = np.asarray(image.points[near], dtype=float)
        sphere = fit_target(points, start, radius_m, scanner, other_radii_m)
        if sphere is not None and not any(
            np.linalg.norm(sphere.centre - other.centre) < 2 * radius_m for other in found
        ):
            found.append(sphere)
    return tuple(sorted(found, key=lambda sphere: float(np.linalg.norm(sphere.centre))))


def _candidates(image: RangeImage, radius_m: float, scanner: Scanner, emit: Emit, station: str) -> Array:
    """Rough centres (n, 3), those that most cells speak for first."""
    rows = image.ranges.shape[0]
    centres = [np.zeros((0, 3))]
    for first in range(0, rows, ROWS_PER_RUN):
        emit(Event(stage="targets", done=50 * first // rows, total=100, block=station))
        centres.append(_candidates_of_rows(image, first, min(first + ROWS_PER_RUN, rows), radius_m, scanner))
    return _merged(np.concatenate(centres), radius_m)


def _candidates_of_rows(image: RangeImage, first: int, last: int, radius_m: float, scanner: Scanner) -> Array:
    """Centres (n, 3) over the cells of some rows that could be a sphere's nearest point."""
    step, columns = image.step_rad, image.ranges.shape[1]
    row, column = np.nonzero(np.isfinite(image.ranges[first:last]))
    row += first
    elevation = image.lowest_rad + (row + 0.5) * step
    ranges = image.ranges[row, column].astype(np.float64)
    away = ranges + radius_m
    disc_cells = radius_m / away / step
    # near the zenith the columns run together
    usable = (disc_cells > LEAST_CELLS) & (np.abs(elevation) < 1.3)
    row, column, elevation = row[usable], column[usable], elevation[usable]
    ranges, away, disc_cells = ranges[usable], away[usable], disc_cells[usable]
    fitting, against = np.zeros(len(row), dtype=np.int64), np.zeros(len(row), dtype=np.int64)
    tolerance = NOISE_SIGMAS * scanner.range_sigma_m * np.sqrt(1.5)
    for k in range(DIRECTIONS):
        up = _cells(disc_cells * sin(k * np.pi / DIRECTIONS))
        right = _cells(disc_cells * cos(k * np.pi / DIRECTIONS) / np.cos(elevation))
        pair = [_at(image, row + sign * up, (column + sign * right) % columns) for sign in (1, -1)]
        angle = step * np.hypot(up, right * np.cos(elevation))
        chord = np.sqrt(np.maximum(radius_m**2 - (away * np.sin(angle)) ** 2, 0))
        fall = away * np.cos(angle) - chord - ranges
        deeper = [side - ranges - fall for side in pair]
        # a ray may lie anywhere in its cell, and the surface slopes about 1:1 on the ring
        in_cell = radius_m / disc_cells
        level = np.abs(deeper[0] + deeper[1]) / 2 < tolerance + 0.1 * fall + 0.05 * in_cell
        fits = level & (np.abs(deeper[0] - deeper[1]) / 2 < TILT * radius_m + 0.6 * in_cell)
        fitting += fits
        against += ~fits & np.isfinite(deeper[0] + deeper[1])
    good = (fitting >= LEAST_PAIRS) & (against == 0)
    row, column, elevation, away = row[good], column[good], elevation[good], away[good]
    azimuth = (column + 0.5) * step - np.pi
    flat = away * np.cos(elevation)
    return np.column_stack([flat * np.cos(azimuth), flat * np.sin(azimuth), away * np.sin(elevation)])


def _cells(disc_cells: Array) -> NDArray[np.int64]:
    """Whole cells nearest to the ring, but not so far out that the edge of the disc is near."""
    nearest = np.rint(RING * disc_cells)
    return np.where(
        np.abs(nearest) > MOST_RING * np.abs(disc_cells), np.trunc(RING * disc_cells), nearest
    ).astype(np.int64)


def _at(image: RangeImage, row: NDArray[np.int64], column: NDArray[np.int64]) -> Array:
    rows = image.ranges.shape[0]
    inside = (row >= 0) & (row < rows)
    values = image.ranges[np.clip(row, 0, rows - 1), column].astype(np.float64)
    values[~inside] = np.nan
    return values


def _merged(centres: Array, radius_m: float) -> Array:
    """One centre for all that fall into the same cube of half a radius, the fullest cubes first."""
    if not len(centres):
        return centres
    cubes = np.floor(centres / (0.5 * radius_m)).astype(np.int64)
    _, inverse, counts = np.unique(cubes, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(counts), 3))
    np.add.at(sums, inverse.ravel(), centres)
    order = np.argsort(-counts, kind="stable")[:MOST_CANDIDATES]
    merged: Array = (sums / counts[:, None])[order]
    return merged
