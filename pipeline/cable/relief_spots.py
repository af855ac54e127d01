"""Bulges and dents: compact areas that stand proud of the base or lie below it.

Takes the map of heights; an area belongs together where the smoothed map keeps above half of what stands out
of the noise.  The height is that of a local quadratic at the area's middle, over the part above some two
thirds of the height: averaging alone would flatten the peak.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.cable.relief_map import HeightMap, regions
from pipeline.core.vocabulary import Array

_REACH = 0.8  # the quadratic is fitted so far out, in units of the area's half extents at half height
_LEAST_REACH_MM = 2.5
_LEAST_MEASURED = 0.3  # of an area's cells


@dataclass(frozen=True, kw_only=True)
class Spot:
    """One bulge or dent.

    Attributes:
        azimuth, y_mm: its middle, rad and mm.
        height_mm: of the peak over the base, negative for a dent; sigma_mm: its standard deviation.
        length_mm, width_mm: along the cable and around, where it can be told from the noise.
    """

    azimuth: float
    y_mm: float
    height_mm: float
    sigma_mm: float
    length_mm: float
    width_mm: float


def find_spots(
    heights: HeightMap,
    smooth_mm: Array,
    level_mm: Array,
    taken: NDArray[np.bool_],
    least_area_mm2: float,
    window_mm: float,
) -> tuple[Spot, ...]:
    """All bulges and dents, the highest or deepest first.

    Args:
        heights: the map.
        smooth_mm: (n, m) the same, smoothed.
        level_mm: (n,) what stands out exceeds this.
        taken: (n, m) cells that belong to ridges.
        least_area_mm2: smaller areas are dropped.
        window_mm: side of the window that the map was matched with.
    """
    found = []
    measured = np.isfinite(heights.height_mm) & ~taken
    cell_mm2 = float(np.prod(heights.cell_mm))
    for sign in (1.0, -1.0):
        high = np.where(np.isfinite(smooth_mm) & ~taken, sign * smooth_mm, 0.0)
        labels, count = regions(high > level_mm[:, None] / 2)
        peaks = np.zeros(count + 1)
        np.maximum.at(peaks, labels.ravel(), (high / level_mm[:, None]).ravel())
        area = np.bincount(labels.ravel(), minlength=count + 1)
        seen = np.bincount(labels.ravel(), weights=measured.ravel(), minlength=count + 1)
        wanted = (peaks > 1) & (seen * cell_mm2 >= least_area_mm2) & (seen >= _LEAST_MEASURED * area)
        for label in np.flatnonzero(wanted[1:]) + 1:
            spot = _spot(heights, high, labels == label, measured, sign, window_mm)
            if spot is not None:
                found.append(spot)
    return tuple(sorted(found, key=lambda s: -abs(s.height_mm)))


def _spot(
    heights: HeightMap,
    high: Array,
    region: NDArray[np.bool_],
    measured: NDArray[np.bool_],
    sign: float,
    window_mm: float,
) -> Spot | None:
    peak = np.unravel_index(int(np.argmax(np.where(region, high, 0.0))), high.shape)
    arc = heights.arc_mm(float(heights.azimuth[peak[1]]))
    half, _ = regions(region & (high > high[peak] / 2))
    rows, columns = np.nonzero(half == half[peak])
    weight = high[rows, columns]
    y_mm = float(np.average(heights.y_mm[rows], weights=weight))
    middle = float(np.average(arc[columns], weights=weight))
    reach = [max(_REACH * extent / 2, _LEAST_REACH_MM) for extent in _extents(heights, rows, arc[columns])]
    first = _quadratic(heights, measured, (y_mm, middle), arc, reach, window_mm)
    if first is None:
        return None
    y_mm, middle = y_mm + first.vertex_mm[0], middle + first.vertex_mm[1]
    wide, narrow = (
        _quadratic(heights, measured, (y_mm, middle), arc, [factor * r for r in reach], window_mm)
        for factor in (1.0, 0.7)
    )
    if wide is None or sign * wide.height_mm <= 0:
        return None
    # what a smaller part gives tells how far the peak is from a quadratic
    model = abs(wide.height_mm - narrow.height_mm) if narrow is not None else 0.0
    height = wide.height_mm - wide.flat_mm
    rows, columns = np.nonzero(region)
    length, width = _extents(heights, rows, arc[columns])
    azimuth = float(heights.azimuth[peak[1]]) + middle / heights.radius_mm
    return Spot(
        azimuth=azimuth,
        y_mm=y_mm,
        height_mm=height,
        sigma_mm=float(np.sqrt(wide.sigma_mm**2 + heights.wave_mm**2 + (wide.flat_mm / 2) ** 2 + model**2)),
        length_mm=length,
        width_mm=width,
    )


def _extents(heights: HeightMap, rows: NDArray[np.intp], arcs_mm: Array) -> tuple[float, float]:
    along, around = heights.cell_mm
    return float(np.ptp(heights.y_mm[rows]) + along), float(np.ptp(arcs_mm) + around)


@dataclass(frozen=True, kw_only=True)
class _Fit:
    """A local quadratic: its height at the place, sigma, what the window adds to it (a window of side w
    averages c s^2 to c w^2 / 12 more than its middle: it takes off a peak's height), and where its vertex is
    from the place, along and around, at most half the reach away."""

    height_mm: float
    sigma_mm: float
    flat_mm: float
    vertex_mm: tuple[float, float]


def _quadratic(
    heights: HeightMap,
    measured: NDArray[np.bool_],
    place: tuple[float, float],
    arc: Array,
    reach: list[float],
    window_mm: float,
) -> _Fit | None:
    """The quadratic through the cells around a place; None where too few were seen."""
    along = (heights.y_mm[:, None] - place[0]) / reach[0]
    around = (arc[None, :] - place[1]) / reach[1]
    use = (along**2 + around**2 < 1) & measured
    if use.sum() < 30:
        return None
    s, t = (np.broadcast_to(a, use.shape)[use] for a in (along, around))
    values = heights.height_mm[use]
    design = np.column_stack([np.ones_like(s), s, t, s * s, s * t, t * t])
    weight = np.ones_like(s)
    for _ in range(4):  # Huber's weights
        solved = np.linalg.lstsq(design * weight[:, None], values * weight, rcond=None)[0]
        miss = np.abs(values - design @ solved)
        scale = max(1.4826 * float(np.median(miss)), 1e-4)
        weight = np.sqrt(np.minimum(1.0, 2 * scale / np.maximum(miss, 1e-9)))
    alike = max(window_mm**2 / float(np.prod(heights.cell_mm)), 1.0)  # cells that say one thing
    square = design.T @ design
    if np.linalg.cond(square) > 1e6:  # a thread of cells bears no quadratic
        return None
    spread = float(np.linalg.inv(square)[0, 0])
    flat = (solved[3] / reach[0] ** 2 + solved[5] / reach[1] ** 2) * window_mm**2 / 12
    bend = np.array([[2 * solved[3], solved[4]], [solved[4], 2 * solved[5]]])
    peaked = np.linalg.det(bend) > 0 and solved[0] * solved[3] < 0
    vertex = np.linalg.solve(bend, -solved[1:3]) if peaked else np.zeros(2)
    vertex = np.clip(vertex, -0.5, 0.5) * reach
    return _Fit(
        height_mm=float(solved[0]),
        sigma_mm=scale * float(np.sqrt(alike * spread)),
        flat_mm=float(flat),
        vertex_mm=(float(vertex[0]), float(vertex[1])),
    )
