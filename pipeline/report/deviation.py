"""How far the measured surface lies from what it should be: a circle of given diameter, or its own base.

Takes points of the model, a section, or the profile along the cable; gives signed distances in millimetres
(positive outwards) and their colours.  Draws nothing: the report does that, and the Blender extension.
"""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pipeline.cable.measure import Measurement
from pipeline.cable.relief_map import HeightMap, smoothed
from pipeline.cable.ring import Ring
from pipeline.core.vocabulary import Array

SMOOTH_MM = 0.5  # standard deviation, as the model's own surface is averaged

RED_TO_BLUE = (
    *((103, 0, 31), (178, 24, 43), (214, 96, 77), (244, 165, 130), (253, 219, 199), (247, 247, 247)),
    *((209, 229, 240), (146, 197, 222), (67, 147, 195), (33, 102, 172), (5, 48, 97)),
)
"""ColorBrewer's diverging scheme RdBu (Harrower & Brewer 2003), sRGB: safe for the colour-blind."""

NOT_MEASURED = (128, 128, 128)


def mean_diameter_mm(measurement: Measurement) -> float:
    """Mean over the stations."""
    return float(np.mean([s.diameter_mm for s in measurement.sections]))


def circle_deviation_mm(points: Array, measurement: Measurement, diameter_mm: float) -> Array:
    """Distances (n,) of points from a tube of one diameter that follows the cable's own axis.

    Args:
        points: (n, 3) cable frame, metres.
        measurement: its profile's centres are the axis, held beyond its ends.
        diameter_mm: of the tube.
    """
    good = np.isfinite(measurement.profile_centre_mm[:, 0])
    away = 1000 * points[:, [0, 2]]
    if good.any():
        along, centres = measurement.profile_y_m[good], measurement.profile_centre_mm[good]
        away = away - np.column_stack([np.interp(points[:, 1], along, centres[:, k]) for k in (0, 1)])
    return np.asarray(np.hypot(away[:, 0], away[:, 1]) - diameter_mm / 2)


def base_deviation_mm(points: Array, measurement: Measurement) -> Array:
    """Heights (n,) over the base surface at the places of points (n, 3), cable frame, metres: the relief.

    NaN where nothing was measured.  Averaged as the model's surface is.
    """
    relief = measurement.relief
    around = HeightMap(
        azimuth=relief.azimuth,
        y_mm=1000 * relief.y_m,
        height_mm=relief.height_mm.astype(np.float64),
        radius_mm=mean_diameter_mm(measurement) / 2,
        wave_mm=0.0,
    )
    return smoothed(around, SMOOTH_MM)[_cells(points, relief.azimuth, relief.y_m)]


def is_measured(points: Array, ring: Ring) -> NDArray[np.bool_]:
    """Whether the surface was seen at the places of points (n, 3), cable frame, or only closed there."""
    return np.asarray(ring.measured[_cells(points, ring.azimuth, ring.y_m)])


def section_deviation_mm(
    points_mm: Array, centre_mm: Array, radius_mm: float, step_deg: float = 1.0
) -> tuple[Array, Array]:
    """A section as distances from its circle, direction by direction.

    Args:
        points_mm: (n, 2) x and z.
        centre_mm: (2,) of the circle.
        radius_mm: of the circle.
        step_deg: width of a direction; must divide the turn.

    Returns:
        Angles (k,) in degrees in the x-z plane, from x to z, and the median distance (k,) there; NaN where
        the section has no points, so that a drawn line breaks at a gap.
    """
    offset = points_mm - np.asarray(centre_mm)
    angle_deg = np.degrees(np.arctan2(offset[:, 1], offset[:, 0])) % 360
    distance = np.hypot(offset[:, 0], offset[:, 1]) - radius_mm
    count = round(360 / step_deg)
    bins = np.minimum((angle_deg / step_deg).astype(int), count - 1)
    order = np.argsort(bins, kind="stable")
    groups = pairwise(np.searchsorted(bins[order], np.arange(count + 1)))
    medians = [np.median(distance[order[start:end]]) if end > start else np.nan for start, end in groups]
    centres_deg: Array = (np.arange(count, dtype=np.float64) + 0.5) * step_deg
    return centres_deg, np.asarray(medians, dtype=np.float64)


def profile_at(measurement: Measurement, position_m: float) -> tuple[float, float]:
    """Diameter and its standard deviation at any place, mm, between the neighbours of the profile.

    A first answer before a station is measured there; NaN outside the travel and next to an unseen place.
    """
    along = measurement.profile_y_m
    if not len(along) or not along[0] <= position_m <= along[-1]:
        return float("nan"), float("nan")
    diameter, sigma = (
        float(np.interp(position_m, along, values))
        for values in (measurement.profile_diameter_mm, measurement.profile_sigma_mm)
    )
    return diameter, sigma


def diverging_colours(deviation_mm: Array, limit_mm: float) -> NDArray[np.uint8]:
    """sRGB (n, 3) from blue at -limit over white at 0 to red at +limit; grey where nothing was measured."""
    table = np.array(RED_TO_BLUE[::-1], dtype=np.float64)
    share = np.clip(deviation_mm / limit_mm, -1, 1) / 2 + 0.5
    place = np.where(np.isnan(share), 0.5, share) * (len(table) - 1)
    colours = np.column_stack([np.interp(place, np.arange(len(table)), table[:, k]) for k in range(3)])
    return np.where(np.isnan(share)[:, None], NOT_MEASURED, np.rint(colours)).astype(np.uint8)


def _cells(points: Array, azimuth: Array, y_m: Array) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows and columns of the cells in which points lie, of a map that closes around the cable."""
    turn = np.arctan2(-points[:, 2], points[:, 0])
    column = np.rint((turn - azimuth[0]) / (azimuth[1] - azimuth[0])).astype(np.int64) % len(azimuth)
    row = np.rint((points[:, 1] - y_m[0]) / (y_m[1] - y_m[0])).astype(np.int64)
    return np.clip(row, 0, len(y_m) - 1), column
