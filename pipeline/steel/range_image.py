"""The cloud of one station as its scanner saw it: ranges over azimuth and elevation.

Takes points in the station frame; gives an image with about one point a cell, and all points of a small part
of the view.  Leaves out what the picture shows.  Memory: about 30 bytes a point.
"""

from dataclasses import dataclass
from math import ceil, pi

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from pipeline.core.vocabulary import Array

WINDOW_RAD = 0.03
"""Half width of the windows in which the step is measured."""
WINDOWS = 40
POINTS_PER_RUN = 1_000_000
LEAST_STEP_RAD = 1e-4
"""Finer images would not fit into memory: 20 arc seconds, 31 000 columns."""


@dataclass(frozen=True, kw_only=True)
class RangeImage:
    """Ranges over azimuth (columns, all around) and elevation (rows).

    Attributes:
        step_rad: size of a cell, about the step of the scanner.
        lowest_rad: elevation of the lower edge of row 0.
        ranges: (rows, columns) float32 metres, NaN where nothing came back; single gaps are filled.
        order: (n,) points sorted by cell.
        starts: (rows * columns + 1,) where each cell's points begin in ``order``.
        points: (n, 3) as given.
    """

    step_rad: float
    lowest_rad: float
    ranges: NDArray[np.float32]
    order: NDArray[np.int32]
    starts: NDArray[np.int32]
    points: NDArray[np.float32]

    def near(self, direction: Array, angle_rad: float) -> NDArray[np.int32]:
        """Numbers of the points in a window about a direction (3,), at least ``angle_rad`` to each side."""
        rows, columns = self.ranges.shape
        azimuth, elevation = angles_of(direction[None])
        row = int((elevation[0] - self.lowest_rad) / self.step_rad)
        column = int((azimuth[0] + pi) / self.step_rad)
        high = ceil(angle_rad / self.step_rad) + 1
        wide = min(ceil(angle_rad / self.step_rad / max(np.cos(elevation[0]), 0.05)) + 1, columns // 2 - 1)
        found = []
        for i in range(max(row - high, 0), min(row + high, rows - 1) + 1):
            for first, last in _wrapped(column - wide, column + wide, columns):
                begin, end = self.starts[i * columns + first], self.starts[i * columns + last + 1]
                found.append(self.order[begin:end])
        return np.concatenate(found) if found else np.zeros(0, dtype=np.int32)


def range_image(points: NDArray[np.float32]) -> RangeImage:
    """Sort a station's points (n, 3) into cells; of several in one cell the last is the cell's range."""
    count = len(points)
    azimuth, elevation = np.empty(count, np.float32), np.empty(count, np.float32)
    ranges = np.empty(count, np.float32)
    for first in range(0, count, POINTS_PER_RUN):
        run = slice(first, first + POINTS_PER_RUN)
        part = np.asarray(points[run], dtype=float)
        azimuth[run], elevation[run] = angles_of(part)
        ranges[run] = np.linalg.norm(part, axis=1)
    step = max(_step(azimuth, elevation), LEAST_STEP_RAD)
    columns = max(ceil(2 * pi / step), 8)
    lowest = float(elevation.min())
    rows = int((float(elevation.max()) - lowest) / step) + 1
    row = np.minimum(((elevation - lowest) / step).astype(np.int32), rows - 1)
    column = np.minimum(((azimuth + pi) / step).astype(np.int32), columns - 1)
    cell = row * columns + column
    del azimuth, elevation, row, column
    image = np.full(rows * columns, np.nan, dtype=np.float32)
    image[cell] = ranges
    order = np.argsort(cell, kind="stable").astype(np.int32)
    starts = np.zeros(rows * columns + 1, dtype=np.int32)
    np.cumsum(np.bincount(cell, minlength=rows * columns), out=starts[1:])
    return RangeImage(
        step_rad=step,
        lowest_rad=lowest,
        ranges=_without_pinholes(image.reshape(rows, columns)),
        order=order,
        starts=starts,
        points=points,
    )


def angles_of(points: Array) -> tuple[Array, Array]:
    """Azimuth from +x towards +y and elevation of (n, 3) points, radians."""
    azimuth = np.arctan2(points[:, 1], points[:, 0])
    return azimuth, np.arctan2(points[:, 2], np.hypot(points[:, 0], points[:, 1]))


def _step(azimuth: NDArray[np.float32], elevation: NDArray[np.float32]) -> float:
    """Spacing of the points over azimuth and elevation, from their density in small windows."""
    rng = np.random.default_rng(0)
    chosen = rng.integers(0, len(azimuth), WINDOWS)
    spacings = []
    for n in chosen:
        inside = (np.abs(azimuth - azimuth[n]) < WINDOW_RAD) & (np.abs(elevation - elevation[n]) < WINDOW_RAD)
        window = np.column_stack([azimuth[inside], elevation[inside]]).astype(float)
        if len(window) < 12:
            continue
        tree = cKDTree(window)
        centre = np.array([azimuth[n], elevation[n]], dtype=float)
        # the ninth nearest of a grid of step s is about 1.6 s away
        distance = tree.query(centre, k=10)[0][-1]
        around = len(tree.query_ball_point(centre, 2.5 * distance))
        spacings.append(np.sqrt(pi * (2.5 * distance) ** 2 / max(around, 1)))
    return float(np.percentile(spacings, 25)) if spacings else 0.01


def _without_pinholes(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """Single empty cells between two filled ones get their mean: cells and rays do not quite keep step."""
    for axis in (1, 0):
        before, after = np.roll(image, 1, axis=axis), np.roll(image, -1, axis=axis)
        if axis == 0:
            before[0], after[-1] = np.nan, np.nan
        image = np.where(np.isnan(image), (before + after) / 2, image)
    return image


def _wrapped(first: int, last: int, columns: int) -> list[tuple[int, int]]:
    """A run of columns that may pass the seam, as one or two runs."""
    if first < 0:
        return [(first + columns, columns - 1), (0, last)]
    if last >= columns:
        return [(first, columns - 1), (0, last - columns)]
    return [(first, last)]
