"""Cylinder and sphere through laser rays: residuals of the measured ranges, not of the points' distances.

Takes rays and a figure's parameters; gives measured minus computed ranges with their Jacobian, for
pipeline.core.fits.robust.  Leaves out the choice of rays.

Why ranges: a scanner's direction is far better than its range.  Taken as a point, a ray's noise turns the
surface's normal at that point with it, and on an arc seen from one side this correlation of the design with
the noise makes the fit too small and pulls it towards the scanner: 0.1 to 0.4 mm for a rod of 60 to 90 mm at
2 mm noise, many of its sigmas.  Held against the place where the ray meets the figure, the noise only adds.
Formulas: the ray-figure intersections and implicit differentiation, ds/dtheta = -(dF/dtheta) / (n . w).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.core.vocabulary import Array
from pipeline.steel.records import StationPose
from pipeline.steel.tile_records import SitePoints
from pipeline.steel.vectors import dots, lengths

STEEPEST = 0.15
"""Rays that meet the figure at a smaller cosine, or miss it, are treated as meeting it at this one."""


@dataclass(frozen=True)
class Rays:
    """Rays: scanners' centres (n, 3), unit directions (n, 3), ranges (n,) metres, stations' numbers (n,)."""

    origins: Array
    directions: Array
    ranges: Array
    stations: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.ranges)

    @staticmethod
    def of(points: SitePoints, stations: tuple[StationPose, ...]) -> "Rays":
        """The rays that measured the points."""
        origins = np.array([pose.translation for pose in stations])[points.stations]
        away = points.places - origins
        ranges = lengths(away)
        return Rays(origins, away / ranges[:, None], ranges, points.stations)

    @property
    def places(self) -> Array:
        """(n, 3) the measured points."""
        return self.origins + self.ranges[:, None] * self.directions

    def where(self, chosen: NDArray[np.bool_] | NDArray[np.int64]) -> "Rays":
        """Some of the rays."""
        return Rays(self.origins[chosen], self.directions[chosen], self.ranges[chosen], self.stations[chosen])


@dataclass(frozen=True)
class Meeting:
    """Where rays meet a figure.

    Attributes:
        ranges: (n,) computed.
        normals: (n, 3) outward unit normals there.
        cosines: (n,) of the incidence, positive.
        by_figure: (n, p) derivative of a fixed point's distance from the surface by the figure's parameters.
    """

    ranges: Array
    normals: Array
    cosines: Array
    by_figure: Array

    @property
    def jacobian(self) -> Array:
        """(n, p) derivative of measured minus computed ranges."""
        return -self.by_figure / self.cosines[:, None]


def meet_cylinder(values: Array, rays: Rays, place: Array, frame: Array) -> Meeting:
    """Meet a cylinder.

    Args:
        values: (5,) offset along u, along v, slope towards u, towards v, radius.
        rays: n of them.
        place: (3,) origin of the parameters.
        frame: (3, 3) rows u, v, direction, to which offsets and slopes belong.
    """
    scale = float(np.sqrt(1 + values[2] ** 2 + values[3] ** 2))
    axis = (values[2] * frame[0] + values[3] * frame[1] + frame[2]) / scale
    away = rays.origins - (place + values[0] * frame[0] + values[1] * frame[1])
    away_across = away - (away @ axis)[:, None] * axis
    across = rays.directions - (rays.directions @ axis)[:, None] * axis
    ranges, normals, cosines = _meet_round(away_across, across, float(values[4]))
    along = away @ axis + ranges * (rays.directions @ axis)
    n_u, n_v = normals @ frame[0], normals @ frame[1]
    by_figure = -np.column_stack([n_u, n_v, along * n_u / scale, along * n_v / scale, np.ones(len(rays))])
    return Meeting(ranges, normals, cosines, by_figure)


def meet_sphere(values: Array, rays: Rays, place: Array) -> Meeting:
    """Meet a sphere: ``values`` (4,) centre relative to ``place`` (3,), and radius."""
    ranges, normals, cosines = _meet_round(
        rays.origins - place - values[:3], rays.directions, float(values[3])
    )
    return Meeting(ranges, normals, cosines, -np.column_stack([normals, np.ones(len(rays))]))


def _meet_round(away: Array, across: Array, radius: float) -> tuple[Array, Array, Array]:
    """Ranges, normals and cosines where rays ``away + s across`` (n, 3) first meet |.| = radius."""
    a = np.maximum(dots(across, across), 1e-12)
    b = dots(across, away)
    c = dots(away, away) - radius**2
    root = np.sqrt(np.maximum(b * b - a * c, (STEEPEST * radius) ** 2 * a))
    ranges = (-b - root) / a
    met = away + ranges[:, None] * across
    normals = met / np.maximum(lengths(met), 1e-12)[:, None]
    return ranges, normals, np.maximum(-dots(normals, across), STEEPEST * np.sqrt(a))


def passes(away: Array, across: Array, radius: float) -> Array:
    """How far rays pass a figure's centre or axis, in radii: (n,), over 1 where they miss it."""
    unit = across / np.maximum(lengths(across), 1e-12)[:, None]
    return np.asarray(lengths(np.cross(unit, away)) / radius)
