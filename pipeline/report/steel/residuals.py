"""The residuals of the points that were used, and the one figure that stands for the registration."""

import math

import numpy as np

from pipeline.core.vocabulary import Array
from pipeline.report.steel.records import SteelReport


def coordinate_residuals(report: SteelReport) -> Array:
    """(n, 3) residuals of all points that were used, mm, site frame."""
    used = [row.offset_mm for row in report.residuals if row.kind == "point" and row.weight > 0]
    return np.array(used, dtype=float).reshape(-1, 3)


def point_residual_mm(report: SteelReport) -> float:
    """Root mean square of their lengths; NaN without points."""
    offsets = coordinate_residuals(report)
    return float(np.sqrt(np.mean(np.sum(offsets**2, axis=1)))) if len(offsets) else math.nan
