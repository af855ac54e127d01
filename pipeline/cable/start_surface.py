"""Where a finer sweep begins: the surface of the sweep before, free of outliers, at the new cells.

Windows are warped about this surface, each cell at its own radius, so it must follow relief (else a window
straddles crest and flank) and be free of noise (what it carries, the next sweep keeps a part of).
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.cable.surface_view import Image, SweepGrid
from pipeline.cable.sweep import SweepResult

LEAST_SCORE = 0.3
AGREEMENT_M = 1e-3
"""Cells whose two half-results differ by more are no start."""
OUTLIER_M = 0.5e-3
"""Cells further from the median of their surroundings are outliers; a ridge 8 mm wide stays below."""
EDGE_MM = 0.15
"""Steps that are small against it are smoothed as noise, larger ones are kept as relief."""
EDGE_CELLS = 3.0


def smooth_start(found: SweepResult, swept: SweepGrid, wanted: SweepGrid, radius_m: float) -> Image:
    """The surface without its relief: after the coarsest sweep, whose windows cannot tell relief.

    Args:
        found: the sweep before, (n, m).
        swept: its cells.
        wanted: the cells of the next one, (k, l).
        radius_m: taken where nothing is known at all.

    Returns:
        Radii (k, l), metres.
    """
    known = _known(found)
    middle = np.median(found.radius_m[known]) if known.any() else radius_m
    filled = np.where(known, found.radius_m, middle).astype(np.float32)  # a wrong neighbour must not spread
    steady = cv2.medianBlur(filled, 5)
    return _at(cv2.GaussianBlur(steady, (0, 0), 1.5), swept, wanted)


def edge_keeping_start(found: SweepResult, swept: SweepGrid, wanted: SweepGrid, radius_m: float) -> Image:
    """The surface with its relief: outliers dropped, then a bilateral filter (Tomasi and Manduchi, 1998).

    Arguments and result as in :func:`smooth_start`.
    """
    known = _known(found)
    with np.errstate(invalid="ignore"):
        known &= ~(np.abs(found.radius_ahead_m - found.radius_behind_m) > AGREEMENT_M)
    filled = _fill(found.radius_m, known, radius_m)
    known &= np.abs(filled - cv2.medianBlur(filled, 5)) < OUTLIER_M
    steady = cv2.medianBlur(_fill(found.radius_m, known, radius_m), 3)
    excess_mm = (1000 * (steady - np.float32(radius_m))).astype(np.float32)
    smooth_mm = cv2.bilateralFilter(excess_mm, -1, EDGE_MM, EDGE_CELLS)
    return _at(np.asarray(smooth_mm / 1000 + np.float32(radius_m), dtype=np.float32), swept, wanted)


def _known(found: SweepResult) -> NDArray[np.bool_]:
    return np.isfinite(found.radius_m) & (np.nan_to_num(found.score, nan=-1) > LEAST_SCORE)


def _fill(radius_m: Image, known: NDArray[np.bool_], default_m: float) -> Image:
    """Holes closed from their surroundings: means over wider and wider ones, the nearest that tell."""
    middle = np.float32(np.median(radius_m[known]) if known.any() else default_m)
    filled = np.where(known, radius_m, np.nan).astype(np.float32)
    excess, weight = np.where(known, radius_m - middle, 0).astype(np.float32), known.astype(np.float32)
    for sigma in (2.0, 4.0, 8.0, 16.0):
        if np.isfinite(filled).all():
            break
        total = cv2.GaussianBlur(excess, (0, 0), sigma)
        share = np.asarray(cv2.GaussianBlur(weight, (0, 0), sigma))
        near = ~np.isfinite(filled) & (share > 0.05)
        filled[near] = middle + total[near] / share[near]
    return np.where(np.isfinite(filled), filled, middle).astype(np.float32)


def _at(radius_m: Image, swept: SweepGrid, wanted: SweepGrid) -> Image:
    """The surface at other cells, bilinear."""
    column = np.interp(wanted.azimuth, swept.azimuth, np.arange(len(swept.azimuth))).astype(np.float32)
    row = np.interp(wanted.y_m, swept.y_m, np.arange(len(swept.y_m))).astype(np.float32)
    places = np.meshgrid(column, row)
    return np.asarray(cv2.remap(radius_m, places[0], places[1], cv2.INTER_LINEAR), dtype=np.float32)
