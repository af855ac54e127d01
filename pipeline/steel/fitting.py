"""Geometric fits to registered points: what one point is worth, and what all points of a station share.

Takes the points on a figure, roughly known; gives the cylinder or sphere with the covariance of the points'
noise and the figure's share in the errors of its stations.  Leaves out which points lie on what, and the
geometry of rays, see rays.py.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from pipeline.core.errors import StageError
from pipeline.core.fits import FitOptions, fit_cylinder
from pipeline.core.fits.robust import Estimate, solve
from pipeline.core.vocabulary import Array
from pipeline.steel.member_records import MemberOptions, StationShare
from pipeline.steel.rays import Meeting, Rays, meet_cylinder, meet_sphere, passes
from pipeline.steel.records import StationPose
from pipeline.steel.shares import share_of, with_stations
from pipeline.steel.tile_records import SitePoints

MOST_POINTS = 30_000
"""More points are thinned for the fit: the stations' own errors are larger than their noise by then."""
LEAST_RAYS = 6
"""Fewer determine neither a cylinder nor a sphere."""
ROUGH_POINTS = 3000
"""The start looks at this many."""
FLOOR_M = 0.0002
"""Nothing is known of the surface to better than this at one point: paint, rust, the footprint."""


@dataclass(frozen=True, kw_only=True)
class Fitted:
    """A figure through registered points.

    Attributes:
        place: (3,) on the axis next to the points' centroid, or the centre.
        direction: (3,), zeros for a sphere.
        frame: (3, 3) rows u, v, direction; the identity for a sphere.
        radius_m: of the surface.
        noise_covariance: (p, p) in the order of Cylinder or Sphere.
        share: in the stations' errors.
        covariance: (p, p), both.
        used: (n, 3) the points of the fit.
        weights: (n,) their robust weights.
        rms_m: of their distances from the surface, robustly weighted.
    """

    place: Array
    direction: Array
    frame: Array
    radius_m: float
    noise_covariance: Array
    share: StationShare
    covariance: Array
    used: Array
    weights: Array
    rms_m: float


def fit_rod(
    points: SitePoints, direction: Array, stations: tuple[StationPose, ...], options: MemberOptions
) -> Fitted:
    """Fit a cylinder to points on and around it.

    Args:
        points: near the surface.
        direction: (3,) of the axis, roughly.
        stations: that the points' numbers count.
        options: noise.

    Raises:
        StageError: the points determine no cylinder.
    """
    few = _some(points, MOST_POINTS)
    rough = fit_cylinder(_some(few, ROUGH_POINTS).places, direction=direction, options=_loss(options))
    place, frame, values = rough.point, rough.frame, np.array([0, 0, 0, 0, rough.radius])
    values[2:4] = (frame[:2] @ rough.direction) / (frame[2] @ rough.direction)
    all_rays = Rays.of(few, stations)
    for _ in range(2):
        axis = _unit(values[2] * frame[0] + values[3] * frame[1] + frame[2])
        place, frame, values = (
            place + values[:2] @ frame[:2],
            _frame_along(axis),
            np.array([0, 0, 0, 0, values[4]]),
        )
        across = all_rays.directions - (all_rays.directions @ axis)[:, None] * axis
        off = passes(_across(all_rays.origins - place, axis), across, values[4])
        meeting = meet_cylinder(values, all_rays, place, frame)
        rays, meeting = _chosen(all_rays, meeting, off, options)
        # parameters belong to the axis next to the points' centroid: there they are least correlated
        place = place + ((rays.places.mean(axis=0) - place) @ axis) * axis
        found, weight = _solve(
            "cylinder", partial(meet_cylinder, rays=rays, place=place, frame=frame), rays, values, options
        )
        values = found.values
    meeting = meet_cylinder(values, rays, place, frame)
    return _fitted(rays, meeting, found, weight, stations, options).at(
        place=place + values[:2] @ frame[:2],
        direction=_unit(values[2] * frame[0] + values[3] * frame[1] + frame[2]),
        frame=frame,
        radius_m=float(values[4]),
    )


def fit_ball(
    points: SitePoints,
    centre: Array,
    radius_m: float,
    stations: tuple[StationPose, ...],
    options: MemberOptions,
) -> Fitted:
    """Fit a sphere, its radius free, to points on and around it; ``centre`` (3,) and ``radius_m`` are rough.

    Raises:
        StageError: the points determine no sphere.
    """
    all_rays = Rays.of(_some(points, MOST_POINTS), stations)
    values = np.array([*centre, radius_m])
    place = np.zeros(3)
    for _ in range(2):
        place, values = place + values[:3], np.array([0, 0, 0, values[3]])
        off = passes(all_rays.origins - place, all_rays.directions, values[3])
        rays, meeting = _chosen(all_rays, meet_sphere(values, all_rays, place), off, options)
        found, weight = _solve("sphere", partial(meet_sphere, rays=rays, place=place), rays, values, options)
        values = found.values
    meeting = meet_sphere(values, rays, place)
    return _fitted(rays, meeting, found, weight, stations, options).at(
        place=place + values[:3], direction=np.zeros(3), frame=np.eye(3), radius_m=float(values[3])
    )


@dataclass(frozen=True)
class _Unplaced:
    """A fit without its place: see Fitted."""

    noise_covariance: Array
    share: StationShare
    covariance: Array
    used: Array
    weights: Array
    rms_m: float

    def at(self, *, place: Array, direction: Array, frame: Array, radius_m: float) -> Fitted:
        return Fitted(
            place=place,
            direction=direction,
            frame=frame,
            radius_m=radius_m,
            **vars(self),
        )


def _fitted(
    rays: Rays,
    meeting: Meeting,
    found: Estimate,
    weight: Array,
    stations: tuple[StationPose, ...],
    options: MemberOptions,
) -> _Unplaced:
    share = share_of(rays, meeting, found.robust_weights * weight, stations)
    distances = (rays.ranges - meeting.ranges) * meeting.cosines
    return _Unplaced(
        noise_covariance=found.covariance,
        share=share,
        covariance=with_stations(found.covariance, share, stations, options.range_bias_mm / 1000),
        used=rays.places,
        weights=found.robust_weights,
        rms_m=float(np.sqrt(np.average(distances**2, weights=np.maximum(found.robust_weights, 1e-12)))),
    )


def _solve(
    name: str, meet: Callable[[Array], Meeting], rays: Rays, start: Array, options: MemberOptions
) -> tuple[Estimate, Array]:
    """Robust least squares of ranges; the estimate and the rays' weights relative to a square one."""
    sigma_m, cosines = options.range_sigma_mm / 1000, meet(start).cosines
    angle_m = np.radians(options.angle_sigma_arcsec / 3600) * rays.ranges
    oblique = (1 - np.minimum(cosines, 1) ** 2) / cosines**2
    weight = sigma_m**2 / (sigma_m**2 + angle_m**2 * oblique + (FLOOR_M / cosines) ** 2)

    def residuals(values: Array) -> tuple[Array, Array]:
        met = meet(values)
        return rays.ranges - met.ranges, met.jacobian

    return solve(name, residuals, start, weights=weight, options=_loss(options)), weight


def _chosen(rays: Rays, meeting: Meeting, off: Array, options: MemberOptions) -> tuple[Rays, Meeting]:
    """The rays neither near the rim nor off the surface.

    How far the ray passes decides, not the point: the point's noise must not choose the points.

    Raises:
        StageError: too few are left.
    """
    reach = max(6 * options.range_sigma_mm / 1000, 0.008)
    keep = (off < np.sin(np.radians(options.rim_deg))) & (np.abs(rays.ranges - meeting.ranges) < reach)
    if np.count_nonzero(keep) < LEAST_RAYS:
        raise StageError(
            "members",
            f"only {np.count_nonzero(keep)} of {len(keep)} rays meet the figure",
            "scan it from more sides",
        )
    return rays.where(keep), Meeting(
        meeting.ranges[keep], meeting.normals[keep], meeting.cosines[keep], meeting.by_figure[keep]
    )


def _loss(options: MemberOptions) -> FitOptions:
    return FitOptions(least_noise_sigma=0.3 * options.range_sigma_mm / 1000)


def _some(points: SitePoints, most: int) -> SitePoints:
    if len(points) <= most:
        return points
    rng = np.random.default_rng(len(points))
    return points.where(np.sort(rng.choice(len(points), most, replace=False)))


def _across(vectors: Array, axis: Array) -> Array:
    return vectors - (vectors @ axis)[:, None] * axis


def _frame_along(axis: Array) -> Array:
    """Rows u, v, direction; right-handed."""
    u = _unit(np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))]))
    return np.stack([u, np.cross(axis, u), axis])


def _unit(vector: Array) -> Array:
    return np.asarray(vector / np.linalg.norm(vector))
