"""The cable's axis as a curve along y, and unrolled coordinates about it.

Surface coordinates about an axis are (azimuth, y, radius): a surface point is axis(y) + radius (cos a, 0,
-sin a).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial.polynomial import polyval
from numpy.typing import NDArray

from pipeline.core.fits.cylinder import Cylinder
from pipeline.core.vocabulary import Array


@dataclass(frozen=True, kw_only=True)
class AxisCurve:
    """A nearly straight axis: x and z as polynomials in y.

    Attributes:
        origin_y_m: where the polynomials have their origin.
        coefficients: (2, k) of x and z, metres, lowest order first, in (y - origin_y_m).
    """

    origin_y_m: float
    coefficients: Array

    def at(self, y_m: Array) -> Array:
        """Points of the axis, (n,) -> (n, 3) metres."""
        x, z = polyval(y_m - self.origin_y_m, self.coefficients.T)
        return np.stack([x, y_m, z], axis=1)

    def unroll(self, points: Array) -> tuple[Array, Array, Array]:
        """Azimuth (rad), y (m) and radius (m) of points (n, 3)."""
        away = points - self.at(points[:, 1])
        return np.arctan2(-away[:, 2], away[:, 0]), points[:, 1], np.hypot(away[:, 0], away[:, 2])

    def roll(self, azimuth: Array, y_m: Array, radius_m: Array) -> Array:
        """Points (n, 3) at surface coordinates (n,), (n,), (n,)."""
        out = np.stack(
            [radius_m * np.cos(azimuth), np.zeros_like(radius_m), -radius_m * np.sin(azimuth)], axis=1
        )
        return self.at(y_m) + out

    def roll_grid(self, azimuth: Array, y_m: Array, radius_m: NDArray[np.floating[Any]]) -> Array:
        """Points (n, m, 3) at radii (n, m) over azimuths (m,) and places along the cable (n,)."""
        points = np.empty((*radius_m.shape, 3))
        np.multiply(radius_m, np.cos(azimuth), out=points[..., 0])
        np.multiply(radius_m, -np.sin(azimuth), out=points[..., 2])
        x, points[..., 1], z = self.at(y_m).T[..., None]
        points[..., 0] += x
        points[..., 2] += z
        return points


def axis_of_cylinder(cylinder: Cylinder) -> AxisCurve:
    """The axis of a fitted cylinder that runs roughly along y."""
    slope = cylinder.direction / cylinder.direction[1]
    bow = cylinder.bow / cylinder.direction[1] ** 2
    return AxisCurve(
        origin_y_m=float(cylinder.point[1]),
        coefficients=np.array([[cylinder.point[0], slope[0], bow[0]], [cylinder.point[2], slope[2], bow[2]]]),
    )
