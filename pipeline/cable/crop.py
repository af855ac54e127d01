"""Stage *crop*: cut away the limb and ragged edges of one block, so that blocks can be joined (paper, 3.3).

Takes a block's surface; gives the mask of the cells that stay.  Points near the limb are outline and not
surface: they are cut by the angle between line of sight and normal, the rest by quality and by being
connected.
"""

import math
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.cable.surface import BlockSurface
from pipeline.core.errors import StageError
from pipeline.core.vocabulary import Array


@dataclass(frozen=True, kw_only=True)
class CropOptions:
    """What is cut.

    Attributes:
        incidence_deg: largest angle between the line of sight and the surface's normal.
        least_score: smallest agreement of the frames.
        fringe_mm: protrusions and islands narrower than this are cut.
        from_m, to_m: places along the cable, from the first frame, between which the surface stays; None
            cuts nothing there.
    """

    incidence_deg: float = field(default=62.0, metadata={"above": 0.0, "maximum": 85.0})
    least_score: float = field(default=0.2, metadata={"minimum": 0.0, "maximum": 1.0})
    fringe_mm: float = field(default=3.0, metadata={"minimum": 0.0})
    from_m: float | None = None
    to_m: float | None = None


@dataclass(frozen=True, kw_only=True)
class Crop:
    """What stays of one block.

    Attributes:
        keep: (n, m) bool.
        incidence_deg: (m,) angle between line of sight and normal at each azimuth.
    """

    keep: NDArray[np.bool_]
    incidence_deg: Array


def crop_block(
    block: str, surface: BlockSurface, azimuth_deg: float, standoff_m: float, options: CropOptions
) -> Crop:
    """Decide which cells of a block stay.

    Raises:
        StageError: nothing stays, or the stations are in the wrong order.
    """
    start_m, end_m = _stretch(options)
    incidence = incidence_deg(surface.azimuth - np.deg2rad(azimuth_deg), surface.median_radius_m, standoff_m)
    good = np.isfinite(surface.radius_m) & (incidence <= options.incidence_deg)
    good &= ~surface.measured | (np.nan_to_num(surface.score, nan=-1) >= options.least_score)
    good &= ((surface.y_m >= start_m) & (surface.y_m <= end_m))[:, None]
    along_m, around_m = surface.cell_m
    size = [max(round(options.fringe_mm / 1000 / side), 1) | 1 for side in (around_m, along_m)]
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, size)
    keep = cv2.morphologyEx(good.astype(np.uint8), cv2.MORPH_OPEN, kernel) > 0
    if not keep.any():
        shorter = options.from_m is not None or options.to_m is not None
        raise StageError(
            "crop",
            f"nothing of {block} is left",
            "raise crop.incidence_deg or lower crop.least_score"
            + (", or move crop.from_m and crop.to_m apart" if shorter else ""),
        )
    return Crop(keep=keep, incidence_deg=incidence)


def _stretch(options: CropOptions) -> tuple[float, float]:
    """Where along the cable the surface stays, metres."""
    start_m = -math.inf if options.from_m is None else options.from_m
    end_m = math.inf if options.to_m is None else options.to_m
    if not start_m < end_m:
        raise StageError(
            "crop",
            f"crop.from_m is {start_m:g} and crop.to_m is {end_m:g}",
            "let the stretch that stays end behind its beginning",
        )
    return start_m, end_m


def incidence_deg(azimuth: Array, radius_m: float, standoff_m: float) -> Array:
    """Angle at the surface between its normal and the line to the camera, degrees.

    Args:
        azimuth: (m,) radians from the camera's own azimuth.
        radius_m: of the cable.
        standoff_m: from the camera to the axis.
    """
    towards = standoff_m - radius_m * np.cos(azimuth)
    return np.rad2deg(np.abs(azimuth) + np.arctan2(radius_m * np.abs(np.sin(azimuth)), towards))
