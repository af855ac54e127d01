"""What a tie point's measurement is worth in the joint adjustment, from how well it fitted.

Takes the residuals of an adjustment; gives the measurements their standard deviations anew, for each camera
and each direction of the image: on a sheath that water has streaked along the cable, a point's place across
the streaks is as good as ever, and its place along them is ten times worse.  Variance components in the
robust way: from the median of the residuals, by the redundancy that is left to them (W. Foerstner and
B. Wrobel, *Photogrammetric Computer Vision*, 2016, section 4.2.4).  Points that stand close together in a
frame are matched on texture that they share and err alike: so many count as one as the sum of a residual's
correlations, by which the variance of anything smooth that is drawn from them exceeds that of measurements
that err by themselves.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from pipeline.core.bundle import BundleResult
from pipeline.core.rig import Observations
from pipeline.core.vocabulary import Array

ALIKE_PX = 60.0
"""Measurements of one frame that are closer together than this may err alike: three templates."""
ALIKE_M = 0.024
"""Marks shared by two blocks that are closer together than this may err alike: three patches."""
CLIPPED = 3.0
"""Residuals count up to so many standard deviations when it is asked how alike they are."""
FRAMES = 8
"""So many frames of a camera are asked."""

NORMAL_PER_MAD = 1.4826


def weighed(
    measured: Observations, result: BundleResult, tied: int, sigma_px: float, least_px: float
) -> Observations:
    """Give the measurements the looseness that their residuals show.

    Shared marks are never made looser than they were: where all of one seam are off by the same (a rolling
    shutter shows the seam to its two cameras at different moments), they still close the ring.

    Args:
        measured: the measurements that were adjusted; tie points first, then shared marks.
        result: their adjustment.
        tied: number of measurements of tie points.
        sigma_px: standard deviation at looseness 1.
        least_px: the least standard deviation that is believed.
    """
    before = np.ones(len(measured)) if measured.looseness is None else measured.looseness
    looseness = before[:, None] * np.ones(2) if before.ndim == 1 else before.copy()
    residuals_px = np.nan_to_num(result.residuals * looseness)
    is_tie = np.arange(len(measured)) < tied
    for camera in np.unique(measured.camera[is_tie]):
        rows = np.flatnonzero(is_tie & (measured.camera == camera))
        spread_px = _spread(measured.point[rows], residuals_px[rows])
        clipped = _clipped(residuals_px[rows], spread_px)
        alike = alike_in_frame(measured.frame[rows], measured.pixels[rows], clipped)
        looseness[rows] = np.maximum(least_px, spread_px * np.sqrt(alike)) / sigma_px
    rows = np.flatnonzero(~is_tie)
    if len(rows):
        spread_px = _spread(measured.point[rows], residuals_px[rows])
        clipped = _clipped(residuals_px[rows], spread_px)
        alike = alike_marks(measured.camera[rows], measured.point[rows], result.rig.points, clipped)
        found = np.maximum(least_px, spread_px * np.sqrt(alike)) / sigma_px
        looseness[rows] = np.minimum(looseness[rows], found)
    return replace(measured, looseness=looseness)


def alike_in_frame(frame: NDArray[np.int64], pixels: Array, residuals_px: Array) -> Array:
    """How many measurements of a camera count as one, (2,) by image direction: see the module.

    Args:
        frame, pixels, residuals_px: (n,), (n, 2), (n, 2).
    """
    frames = np.unique(frame)
    own, others = np.zeros(2), np.zeros(2)
    for k in frames[:: max(len(frames) // FRAMES, 1)]:
        mine = frame == k
        errors = residuals_px[mine]
        own += np.sum(errors**2, axis=0)
        others += _neighbours(pixels[mine], ALIKE_PX, errors)
    return _count(own, others)


def alike_marks(
    camera: NDArray[np.int64], point: NDArray[np.int64], places: Array, residuals_px: Array
) -> Array:
    """The same for marks that two blocks share, (2,): all measurements of a mark by one camera share its
    matching's error, and so do marks whose patches overlap.

    Args:
        camera, point, residuals_px: (n,), (n,), (n, 2).
        places: (m, 3) of the points, metres.
    """
    marks, number = np.unique(point, return_inverse=True)
    own = np.sum(residuals_px**2, axis=0)
    together = -own
    for c in np.unique(camera):
        mine = camera == c
        sums = np.stack([np.bincount(number[mine], r, len(marks)) for r in residuals_px[mine].T], axis=1)
        together += np.sum(sums**2, axis=0) + _neighbours(places[marks], ALIKE_M, sums)
    return _count(own, together)


def _spread(point: NDArray[np.int64], residuals_px: Array) -> Array:
    """Standard deviation of measurements (2,), from the median of what the adjustment left of them."""
    redundancy = max(1 - 3 * len(np.unique(point)) / (2 * len(point)), 0.1)
    spread: Array = NORMAL_PER_MAD * np.median(np.abs(residuals_px), axis=0) / np.sqrt(redundancy)
    return spread


def _clipped(residuals_px: Array, spread_px: Array) -> Array:
    return np.clip(residuals_px, -CLIPPED * spread_px, CLIPPED * spread_px)


def _neighbours(places: Array, reach: float, errors: Array) -> Array:
    """Sum of the products of errors (n, 2) at places that are closer together than ``reach``, (2,)."""
    near = cKDTree(places).query_pairs(reach, output_type="ndarray")
    return np.asarray(2 * np.sum(errors[near[:, 0]] * errors[near[:, 1]], axis=0))


def _count(own: Array, others: Array) -> Array:
    return np.maximum(1 + others / np.maximum(own, 1e-300), 1.0)
