"""What a weak surface prior would change: diameters from the tie points without and with it.

Takes the tie points of both adjustments, intersected from the images alone; gives a diameter at every station
for each, by the same fit.  Neither is the measured diameter (that comes from the dense surface): their
difference tells what the prior does to the cameras and lenses.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.core.bundle import BundleResult
from pipeline.core.errors import StageError
from pipeline.core.fits.circle import fit_circle
from pipeline.core.smooth_surface import SurfacePrior, surface_prior
from pipeline.core.vocabulary import Array

SECTION_HALF_M = 0.01
"""Tie points so near a station along the cable make its section."""

LEAST_POINTS = 20
LEAST_COVERAGE_DEG = 180.0


@dataclass(frozen=True, kw_only=True)
class SurfaceEffect:
    """The ring adjusted without and with the surface prior.

    Attributes:
        sigma_mm: of the prior.
        used: whether the result with the prior is the run's.
        names: of the stations.
        without_mm, with_mm: (n,) diameters from the tie points, NaN where too few were seen.
        without_sigma_mm, with_sigma_mm: (n,) their standard deviation from orientations and lenses.
    """

    sigma_mm: float
    used: bool
    names: tuple[str, ...]
    without_mm: Array
    with_mm: Array
    without_sigma_mm: Array
    with_sigma_mm: Array


def prior_for(result: BundleResult, sigma_mm: float, patch_mm: float) -> SurfacePrior:
    """The prior for the points of an adjustment; a departure of one sigma halves a point's weight."""
    return surface_prior(result.rig.points, sigma_mm / 1000, sigma_mm / 1000, patch_mm / 1000)


def tie_point_diameters(points: Array, positions_m: Array) -> Array:
    """Diameters (n,) in mm of robust circles through the tie points (m, 3) around places (n,)."""
    return np.array([_diameter_mm(points[np.abs(points[:, 1] - y) < SECTION_HALF_M]) for y in positions_m])


def _diameter_mm(points: Array) -> float:
    if len(points) < LEAST_POINTS:
        return float("nan")
    flat = 1000 * points[:, [0, 2]]
    try:
        circle = fit_circle(flat)
    except StageError:  # on a line: too little of the section was seen
        return float("nan")
    seen = circle.robust_weights > 0
    azimuth = np.arctan2(flat[seen, 1] - circle.centre[1], flat[seen, 0] - circle.centre[0])
    bins = np.unique(np.floor(np.rad2deg(azimuth) / 10))
    return 2 * circle.radius if 10 * len(bins) >= LEAST_COVERAGE_DEG else float("nan")
