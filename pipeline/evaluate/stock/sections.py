"""Diameters at stations from the sparse points of one strip.

Takes points in the cable frame; gives a diameter for each station: the axis by a robust cylinder through the
whole strip (bowed, since a strip bends), then a robust geometric circle, its centre free, through the points
near the station as seen along that axis.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pipeline.core.errors import StageError
from pipeline.core.fits import Cylinder, fit_circle, fit_cylinder
from pipeline.core.vocabulary import Array
from pipeline.evaluate.stock.records import StockOptions


def station_diameters_mm(
    points_in_cable: Array,
    azimuth_deg: float,
    standoff_m: float,
    positions_m: Sequence[float],
    options: StockOptions,
) -> tuple[float | None, ...]:
    """Measure the diameter at each position, None where too few points lie.

    Args:
        points_in_cable: (m, 3) metres.
        azimuth_deg: of the camera.
        standoff_m: points farther than this from the nominal axis are not looked at.
        positions_m: along the cable.
        options: see there.

    Raises:
        StageError: the points fit no cylinder.
    """
    points = points_in_cable[np.hypot(points_in_cable[:, 0], points_in_cable[:, 2]) < standoff_m]
    near = fit_cylinder(points, direction=(0.0, 1.0, 0.0), bowed=True)
    points = points[_within_limb(near, points, azimuth_deg, options.limb_deg)]
    axis = fit_cylinder(points, direction=(0.0, 1.0, 0.0), bowed=True)
    across, _ = _across(axis, points, azimuth_deg)
    return tuple(
        _diameter_mm(across[np.abs(points[:, 1] - position) <= options.slab_mm / 1000], options)
        for position in positions_m
    )


def _across(axis: Cylinder, points: Array, azimuth_deg: float) -> tuple[Array, Array]:
    """(m, 2) places square to the axis, the first towards the camera, and their angles (m,) in degrees."""
    a = np.radians(azimuth_deg)
    aside = np.cross(axis.direction, [np.cos(a), 0.0, -np.sin(a)])
    aside /= np.linalg.norm(aside)
    frame = np.stack([np.cross(aside, axis.direction), aside])
    flat = (points - axis.axis_at((points - axis.point) @ axis.direction)) @ frame.T
    return flat, np.degrees(np.arctan2(flat[:, 1], flat[:, 0]))


def _within_limb(axis: Cylinder, points: Array, azimuth_deg: float, limb_deg: float) -> NDArray[np.bool_]:
    return np.abs(_across(axis, points, azimuth_deg)[1]) <= limb_deg


def _diameter_mm(across: Array, options: StockOptions) -> float | None:
    if len(across) < options.least_points:
        return None
    try:
        return 2000 * fit_circle(across).radius
    except StageError:  # the few points there lie on a line
        return None
