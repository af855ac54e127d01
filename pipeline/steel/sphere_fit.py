"""The centre of a sphere of known radius from the ranges that a scanner measured on it.

Takes points in the station frame near a rough centre; gives the centre with its covariance, or nothing where
the points are no such sphere.  The ranges are adjusted along the rays, not across the surface: the noise lies
along the ray, and a point is chosen by its direction, which noise does not change, so neither biases the
centre.  Points beyond ``RIM`` of the radius, seen from the scanner, are left out: there the beam is half on
the background (mixed pixels).
"""

from dataclasses import dataclass
from math import asin

import numpy as np

from pipeline.core.errors import StageError
from pipeline.core.fits import FitOptions, Loss
from pipeline.core.fits.robust import Estimate, solve
from pipeline.core.vocabulary import Array
from pipeline.steel.survey_records import Scanner

RIM = 0.8
"""Part of the visible disc that is used, by its radius."""
LEAST_POINTS = 12
LEAST_FILLED = 0.75
"""Part of the points within the rim that must lie on the sphere."""
LEAST_QUARTERS = 3
"""Quarters of the disc, each with its share of points."""
CHI_SLACK, ROUGH_CHI_SLACK, CHI_SIGMAS = 0.2, 0.8, 2.5
"""Noise of the points over that of the scanner may exceed 1 by so much, and so many of its own sigmas."""
RADIUS_SIGMAS, RADIUS_SLACK = 3.0, 0.03
"""A radius fitted freely may differ by so many sigmas and this part of it."""
WIDE_SIGMAS = 6.0
"""Points farther off than this are not on the sphere."""
PASSES = 4
ROUGH_BOUNDS = (0.5, 0.3, 0.15, 0.1)
"""Points farther off than this part of the radius are not taken to be on the sphere, pass by pass."""
ROUGH_FILLED, NEAR_SIGMAS = 0.6, 4.0


@dataclass(frozen=True, kw_only=True)
class FittedSphere:
    """A sphere target of one station.

    Attributes:
        centre: (3,) metres, station frame.
        covariance: (3, 3).
        points: how many it was fitted to.
        rms_m: of the ranges.
        chi: the same over what the scanner's noise would give.
    """

    centre: Array
    covariance: Array
    points: int
    rms_m: float
    chi: float


def fit_target(
    points: Array, start: Array, radius_m: float, scanner: Scanner, other_radii_m: tuple[float, ...] = ()
) -> FittedSphere | None:
    """Fit a target to the points (n, 3) of a window about a rough centre (3,); None where it is none.

    Args:
        points: station frame, metres.
        start: within a radius of the centre.
        radius_m: of the target.
        scanner: its noise.
        other_radii_m: of spheres that are no targets: what is nearer to one of these is none.
    """
    centre = _rough(points, start, radius_m, scanner)
    if centre is None:
        return None
    found: Estimate | None = None
    for _ in range(PASSES):
        chosen = _on_disc(points, centre, radius_m, RIM)
        if len(chosen) < LEAST_POINTS:
            return None
        found = _fit(chosen, centre, radius_m, scanner)
        if found is None or np.linalg.norm(found.values - start) > radius_m:
            return None
        step = float(np.linalg.norm(found.values - centre))
        centre = found.values
        if step < 1e-5:
            break
    judged = _judged(points, centre, radius_m, scanner, CHI_SLACK)
    if found is None or judged is None:
        return None
    if not _has_radius(judged[0], centre, radius_m, scanner, other_radii_m):
        return None
    chosen, residuals, chi = judged
    return FittedSphere(
        centre=centre,
        covariance=found.covariance,
        points=len(chosen),
        rms_m=float(np.sqrt(np.mean(residuals**2))),
        chi=chi,
    )


def disc_angle_rad(centre: Array, radius_m: float) -> float:
    """Angular radius of a sphere as the scanner sees it."""
    return asin(min(radius_m / max(float(np.linalg.norm(centre)), 1e-9), 1.0))


def _rough(points: Array, start: Array, radius_m: float, scanner: Scanner) -> Array | None:
    """A quick centre on the points that lie near the sphere; None where most of the disc lies elsewhere.

    Thousands of places in a space frame look a little like a sphere; this costs a tenth of the fit.
    """
    centre = start
    for bound in ROUGH_BOUNDS:
        disc = _on_disc(points, centre, radius_m, RIM)
        if len(disc) < LEAST_POINTS:
            return None
        off, sigma, by_centre = _ranges(centre, disc, radius_m, scanner)
        on = np.abs(off) < np.maximum(bound * radius_m, NEAR_SIGMAS * sigma)
        if on.sum() < max(LEAST_POINTS, ROUGH_FILLED * len(disc)):
            return None
        A = by_centre[on]
        try:
            centre = centre - np.linalg.solve(A.T @ A + 1e-6 * np.eye(3), A.T @ off[on])
        except np.linalg.LinAlgError:
            return None
        if np.linalg.norm(centre - start) > radius_m:
            return None
    return None if _judged(points, centre, radius_m, scanner, ROUGH_CHI_SLACK) is None else centre


def _judged(
    points: Array, centre: Array, radius_m: float, scanner: Scanner, chi_slack: float
) -> tuple[Array, Array, float] | None:
    """The points on the sphere, their residuals and chi; None where they do not fill the disc."""
    disc = _on_disc(points, centre, radius_m, RIM)
    if len(disc) < LEAST_POINTS:
        return None
    residuals, sigma, _ = _ranges(centre, disc, radius_m, scanner)
    on = np.abs(residuals) < WIDE_SIGMAS * sigma
    count = int(on.sum())
    if count < max(LEAST_POINTS, LEAST_FILLED * len(disc)) or not _is_all_round(disc[on], centre):
        return None
    chi = float(np.sqrt(np.mean((residuals[on] / sigma[on]) ** 2)))
    if chi > 1 + chi_slack + CHI_SIGMAS / np.sqrt(2 * count):
        return None
    return disc[on], residuals[on], chi


def _on_disc(points: Array, centre: Array, radius_m: float, rim: float) -> Array:
    """The points whose rays pass the centre within ``rim`` of the radius, and that lie near the sphere."""
    rays = points / np.linalg.norm(points, axis=1, keepdims=True)
    passing = np.linalg.norm(np.cross(rays, centre), axis=1)
    return points[(passing < rim * radius_m) & (rays @ centre > 0)]


def _ranges(centre: Array, points: Array, radius_m: float, scanner: Scanner) -> tuple[Array, Array, Array]:
    """Computed minus measured ranges (n,), their standard deviation, and the derivative by the centre.

    Where the ray u meets the sphere, |r u - c| = R; so dr = n . dc / (n . u) with the outward normal n.
    """
    measured = np.linalg.norm(points, axis=1)
    rays = points / measured[:, None]
    along = rays @ centre
    half_chord = np.sqrt(np.maximum(radius_m**2 - (centre @ centre - along**2), (0.1 * radius_m) ** 2))
    computed = along - half_chord
    normal = (computed[:, None] * rays - centre) / radius_m
    facing = np.minimum(np.sum(normal * rays, axis=1), -0.1)
    slope = np.sqrt(np.maximum(1 - facing**2, 0)) / -facing
    sigma = np.hypot(scanner.range_sigma_m, slope * measured * scanner.angle_sigma_rad)
    return computed - measured, sigma, normal / facing[:, None]


def _fit(points: Array, start: Array, radius_m: float, scanner: Scanner) -> Estimate | None:
    _, sigma, _ = _ranges(start, points, radius_m, scanner)

    def residuals(centre: Array) -> tuple[Array, Array]:
        off, _, by_centre = _ranges(centre, points, radius_m, scanner)
        return off, by_centre

    options = FitOptions(loss=Loss.TUKEY, noise_sigma=1.0, iterations=15)
    try:
        return solve("sphere", residuals, start, weights=sigma**-2, options=options)
    except StageError:  # the points do not determine a centre: no target
        return None


def _is_all_round(points: Array, centre: Array) -> bool:
    """Whether the points lie around the middle of the disc, not in one half of it."""
    along = centre / np.linalg.norm(centre)
    right = np.cross([0.0, 0.0, 1.0], along)
    right = right / max(float(np.linalg.norm(right)), 1e-9)
    across, up = points @ right - centre @ right, (points - centre) @ np.cross(along, right)
    quarter = (across > 0).astype(int) + 2 * (up > 0).astype(int)
    enough = np.bincount(quarter, minlength=4) >= len(points) / 12
    return int(enough.sum()) >= LEAST_QUARTERS


def _has_radius(
    points: Array, centre: Array, radius_m: float, scanner: Scanner, other_radii_m: tuple[float, ...]
) -> bool:
    """Whether a radius that is free comes out as the target's: a ball node is larger, a bolt smaller."""
    _, sigma, _ = _ranges(centre, points, radius_m, scanner)

    def residuals(values: Array) -> tuple[Array, Array]:
        off, _, by_centre = _ranges(values[:3], points, abs(float(values[3])), scanner)
        # a larger sphere about the same centre is nearer: dr = dR / (n . u)
        rays = points / np.linalg.norm(points, axis=1, keepdims=True)
        facing = np.einsum("ni,ni->n", by_centre, rays)
        by_radius = np.linalg.norm(by_centre, axis=1) * -np.sign(facing)
        return off, np.column_stack([by_centre, by_radius])

    options = FitOptions(loss=Loss.HUBER, noise_sigma=1.0, iterations=15)
    try:
        found = solve("sphere", residuals, np.append(centre, radius_m), weights=sigma**-2, options=options)
    except StageError:
        return False
    off, sigma_radius = abs(float(found.values[3]) - radius_m), float(np.sqrt(found.covariance[3, 3]))
    nearer = any(abs(float(found.values[3]) - other) < off for other in other_radii_m)
    return not nearer and off < RADIUS_SIGMAS * sigma_radius + RADIUS_SLACK * radius_m
