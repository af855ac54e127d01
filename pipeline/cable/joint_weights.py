"""What a tie point's measurement is worth in the joint adjustment, from how well it fitted.

Takes the residuals of an adjustment; gives the measurements their standard deviations anew, for each camera
and each direction of the image: on a sheath that water has streaked along the cable, a point's place across
the streaks is as good as ever, and its place along them is ten times worse.  Variance components in the
robust way: from the median of the residuals, by the redundancy that is left to them (W. Foerstner and
B. Wrobel, *Photogrammetric Computer Vision*, 2016, section 4.2.4).
"""

from dataclasses import replace

import numpy as np

from pipeline.core.bundle import BundleResult
from pipeline.core.rig import Observations

SHARED_TEXTURE = 2.0
"""Neighbouring points are matched on texture that they share: each is worth less than if it stood alone."""

NORMAL_PER_MAD = 1.4826


def weighed(measured: Observations, result: BundleResult, tied: int, sigma_px: float) -> Observations:
    """Give the first ``tied`` measurements the looseness that their residuals show.

    Args:
        measured: the measurements that were adjusted; tie points first, then shared marks, which stay.
        result: their adjustment.
        tied: number of measurements of tie points.
        sigma_px: standard deviation at looseness 1, which is the least that is believed.
    """
    before = np.ones(len(measured)) if measured.looseness is None else measured.looseness
    looseness = before[:, None] * np.ones(2) if before.ndim == 1 else before.copy()
    residuals_px = result.residuals * looseness
    is_tie = np.arange(len(measured)) < tied
    for camera in np.unique(measured.camera[is_tie]):
        rows = np.flatnonzero(is_tie & (measured.camera == camera))
        points = len(np.unique(measured.point[rows]))
        redundancy = max(1 - 3 * points / (2 * len(rows)), 0.1)
        spread_px = NORMAL_PER_MAD * np.nanmedian(np.abs(residuals_px[rows]), axis=0) / np.sqrt(redundancy)
        looseness[rows] = np.maximum(1.0, SHARED_TEXTURE * spread_px / sigma_px)
    return replace(measured, looseness=looseness)
