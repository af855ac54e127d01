"""Where texture is thin: cells that narrow windows cannot measure are measured in broad ones.

A clean sheath shows a speck here and there, and one that water has streaked hardly changes along the cable.
A window of 3 mm then says nothing or, worse, anything; one of 24 mm still holds enough.  It flattens relief,
so it only fills what the narrow windows leave open.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.cable.surface_view import Image, SweepGrid
from pipeline.cable.sweep import SweepResult

CELLS, WINDOW = 2, 35
"""Broad windows: side of a cell in fine cells, and of a window in those."""
DETAIL_CELLS = 1.5
"""Brightness is counted from that of surroundings so wide: wider than for fine cells, as streaks are dull."""
LEAST_SCORE = 0.2
"""Between specks there is only the sensor's noise, which agrees with nothing: a broad window's agreement is
low where its specks agree perfectly.  That both halves tell the same radius is what vouches for it."""
SURROUNDINGS, LEAST_SHARE = 31, 0.7
"""Fine cells around a fine cell, and the share of them that must stand for it to be believed."""
SEARCH_M = 2e-3
"""A sheath without texture of its own lies this close to the cylinder through its tie points."""


def trusted(found: SweepResult, least_score: float, consistency_mm: float) -> NDArray[np.bool_]:
    """Cells that agree well and whose half-results tell the same; (n, m).

    A cell seen from one side only has no second half: it must agree twice as well.
    """
    with np.errstate(invalid="ignore"):
        differs_mm = 1000 * (found.radius_ahead_m - found.radius_behind_m)
        one_sided = ~np.isfinite(differs_mm)
        good = found.score > np.where(one_sided, (1 + least_score) / 2, least_score)
        return np.asarray(good & (one_sided | (np.abs(differs_mm) < consistency_mm)))


def vouched(stands: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Cells whose surroundings stand as well, (n, m): where most do not, those that do agree by chance."""
    share = cv2.blur(stands.astype(np.float32), (SURROUNDINGS, SURROUNDINGS))
    return stands & (share > LEAST_SHARE)


def filled(
    fine: SweepResult, grid: SweepGrid, stands: NDArray[np.bool_], broad: SweepResult, broad_grid: SweepGrid
) -> SweepResult:
    """The fine cells that stand, and the broad ones (nearest) in place of the others."""
    row = _nearest(broad_grid.y_m, grid.y_m)
    column = _nearest(broad_grid.azimuth, grid.azimuth)

    def joined(name: str) -> Image:
        return np.asarray(np.where(stands, getattr(fine, name), getattr(broad, name)[np.ix_(row, column)]))

    return SweepResult(
        radius_m=joined("radius_m"),
        score=joined("score"),
        radius_ahead_m=joined("radius_ahead_m"),
        radius_behind_m=joined("radius_behind_m"),
    )


def _nearest(places: NDArray[np.floating], wanted: NDArray[np.floating]) -> NDArray[np.int64]:
    step = (places[-1] - places[0]) / (len(places) - 1)
    return np.clip(np.rint((wanted - places[0]) / step), 0, len(places) - 1).astype(np.int64)
