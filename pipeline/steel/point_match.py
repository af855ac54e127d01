"""A photo cloud laid onto the scanned surface by its points: seven parameters, robust.

Takes evenly spread photo points with normals, a start and the scanned surface; gives the placement at which
the distances from points to surface are smallest, with each point's distance and its two normals.  Spheres
that were fitted to the scans stand for the sides that no scanner saw: a flight sees balls from above, a
scanner from below.  Leaves out sigmas (:mod:`pipeline.steel.fuse_sigma`).

Source: Y. Chen and G. Medioni, "Object modelling by registration of multiple range images", Image and Vision
Computing 10(3), 1992 (point to tangent plane), with a scale as seventh parameter; Tukey's weights.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pipeline.core.rotations import rotation_from_vector
from pipeline.core.vocabulary import Array
from pipeline.steel.fuse_records import Placement
from pipeline.steel.scanned_surface import Nearest, ScannedSurface

TUKEY = 4.685
LEAST_COSINE = 0.6
"""Normals of partners differ by at most 53 degrees: opposite sides of a thin rod are no partners."""
STILL = 1e-7
"""A step shorter than this, as a share of the cloud's size, ends the search."""


@dataclass(frozen=True, kw_only=True)
class Laid:
    """Photo points on the scanned surface.

    Attributes:
        placement: seven parameters.
        centre: (3,) weighted mean of the places.
        chosen: (m,) int64, numbers of the photo points that have a partner.
        places: (m, 3) metres.
        distances: (m,) metres.
        scan_normals, photo_normals: (m, 3) of either cloud, the same side.
        weights: (m,) robust, 0 to 1.
        noise_m: robust standard deviation of a distance.
        share: of all photo points that have a partner.
    """

    placement: Placement
    centre: Array
    chosen: np.ndarray
    places: Array
    distances: Array
    scan_normals: Array
    photo_normals: Array
    weights: Array
    noise_m: float
    share: float


def lay(
    points: Array,
    normals: Array,
    surface: ScannedSurface,
    spheres: Array,
    start: Placement,
    gate_m: float,
    iterations: int,
    least_gate_m: float,
    held: Array,
    tick: Callable[[int], None],
) -> Laid:
    """Move the cloud until it lies on the surface.

    Args:
        points, normals: (n, 3) photo frame.
        surface: the scans'.
        spheres: (k, 4) centre and radius of spheres fitted to the scans, metres.
        start: placement to start from, right to within the gate.
        gate_m: largest distance of partners at first.
        iterations: most steps.
        least_gate_m: the gate never shrinks below this.
        held: (7, h) orthonormal motions (see :func:`unit_jacobian`) that the points must not make.
        tick: called with the number of each step.
    """
    placement, gate = start, gate_m
    for step in range(iterations):
        tick(step)
        laid = partners(points, normals, surface, spheres, placement, gate)
        if len(laid.chosen) < 20:
            return laid
        unit = extent(laid)
        rows = unit_jacobian(laid.places - laid.centre, laid.scan_normals, unit)
        normal = (rows * laid.weights[:, None]).T @ rows
        right = -(rows * laid.weights[:, None]).T @ laid.distances
        free = _complement(held)
        motion = free @ np.linalg.lstsq(free.T @ normal @ free, free.T @ right, rcond=1e-9)[0]
        placement = moved(placement, laid.centre, motion / unit_of(unit))
        shrunk = max(0.75 * gate, TUKEY * laid.noise_m, least_gate_m)
        if np.linalg.norm(motion) < STILL * unit and shrunk >= 0.98 * gate:
            break
        gate = min(gate, shrunk)
    return partners(points, normals, surface, spheres, placement, gate)


def partners(
    points: Array,
    normals: Array,
    surface: ScannedSurface,
    spheres: Array,
    placement: Placement,
    gate_m: float,
) -> Laid:
    """Which photo points have a partner at this placement, and how far they are off."""
    places = placement.apply(points)
    turned = normals @ placement.rotation.T
    found = _with_spheres(surface.at(places, gate_m), places, spheres, gate_m)
    cosine = np.sum(found.normals * turned, axis=1)
    if not surface.signed:
        # the scan's normals have no side: the photo's decide
        flip = np.where(cosine < 0, -1.0, 1.0)
        found = Nearest(
            distances=found.distances * flip,
            normals=found.normals * flip[:, None],
            roughness=found.roughness,
        )
        cosine = np.abs(cosine)
    good = np.isfinite(found.distances) & (np.abs(found.distances) < gate_m) & (cosine > LEAST_COSINE)
    chosen = np.flatnonzero(good)
    off = found.distances[chosen]
    noise = 1.4826 * float(np.median(np.abs(off))) if len(off) else float("nan")
    weights = np.clip(1 - (off / max(TUKEY * noise, 1e-12)) ** 2, 0, None) ** 2 if len(off) else off
    centre = np.average(places[chosen], axis=0, weights=weights) if weights.sum() > 0 else places.mean(axis=0)
    return Laid(
        placement=placement,
        centre=centre,
        chosen=chosen,
        places=places[chosen],
        distances=off,
        scan_normals=found.normals[chosen],
        photo_normals=turned[chosen],
        weights=weights,
        noise_m=noise,
        share=len(chosen) / max(len(points), 1),
    )


def _with_spheres(found: Nearest, places: Array, spheres: Array, gate_m: float) -> Nearest:
    """Places next to a fitted sphere are measured against it, not against the points around them."""
    distances, normals, roughness = found.distances.copy(), found.normals.copy(), found.roughness.copy()
    for *centre, radius in spheres:
        away = places - np.asarray(centre)
        length = np.linalg.norm(away, axis=1)
        mine = np.abs(length - radius) < min(gate_m, 0.3 * radius)
        distances[mine] = length[mine] - radius
        normals[mine] = away[mine] / length[mine][:, None]
        roughness[mine] = 0.0
    return Nearest(distances=distances, normals=normals, roughness=roughness)


def extent(laid: Laid) -> float:
    """Root mean square distance of the partners from their centre, metres."""
    return float(np.sqrt(np.mean(np.sum((laid.places - laid.centre) ** 2, axis=1))))


def unit_of(extent_m: float) -> Array:
    """(7,) what turns (rotation, translation, relative scale) into metres at the cloud's edge."""
    return np.array([extent_m, extent_m, extent_m, 1.0, 1.0, 1.0, extent_m])


def unit_jacobian(away: Array, normals: Array, extent_m: float) -> Array:
    """(m, 7) derivative of the distances by the seven motions, each in metres at the cloud's edge."""
    rows = np.column_stack([np.cross(away, normals), normals, np.sum(away * normals, axis=1)])
    return rows / unit_of(extent_m)


def moved(placement: Placement, centre: Array, motion: Array) -> Placement:
    """The placement after (rotation vector, translation, relative scale) about ``centre``."""
    turn, factor = rotation_from_vector(motion[:3]), float(np.exp(motion[6]))
    return Placement(
        scale=placement.scale * factor,
        rotation=turn @ placement.rotation,
        translation=centre + motion[3:6] + factor * turn @ (placement.translation - centre),
    )


def _complement(held: Array) -> Array:
    """(7, 7 - h) orthonormal basis of what is left free."""
    if not held.size:
        return np.eye(7)
    left, _, _ = np.linalg.svd(held, full_matrices=True)
    return left[:, held.shape[1] :]
