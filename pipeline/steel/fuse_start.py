"""Where a fusion starts: given pairs, spheres matched without names, or a cable's unrolled surface.

Takes both clouds; gives placements to try with what each is worth.  Leaves out the points
(:mod:`pipeline.steel.point_match`), which choose among them and refine.
"""

from contextlib import suppress

import numpy as np

from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event
from pipeline.core.fits import fit_similarity
from pipeline.core.vocabulary import Array
from pipeline.steel.cable_start import CableStart, is_elongated, start_from_unrolled
from pipeline.steel.feature_match import Agreement, match_spheres
from pipeline.steel.fuse_records import FuseOptions, GivenPair, PhotoCloud, Placement, ScanCloud, Start
from pipeline.steel.fuse_sigma import StartSigma
from pipeline.steel.photo_spheres import find_spheres
from pipeline.steel.scanned_surface import cube_of

STAGE = "fuse"
STEPS = 100
MOST_RIVALS = 8
"""So many placements that the features allow are tried on the points."""
CUBE_SHARE = 1 / 60
"""Edge of the cubes that points are spread over, as a share of the cloud's size."""
MOST_FOR_SPHERES = 400_000
LEAST_NOISE_M = {Start.PAIRS: 0.010, Start.FEATURES: 0.002}
"""A place pointed out by hand, or a sphere seen in photos, is never better; few may agree by chance."""
WELL_HELD = 1e-3
"""What the axis of a fitted cable leaves open across it (metres, radians, share), before the points."""


def find_starts(
    photo: PhotoCloud,
    scan: ScanCloud,
    spheres: Array,
    options: FuseOptions,
    emit: Emit,
    pairs: tuple[GivenPair, ...],
) -> tuple[list[Placement], Start, list[tuple[tuple[str, Array, Array], ...]], CableStart | None]:
    """Placements to try, where they come from, the features each rests on, and a cable's own findings.

    Raises:
        StageError: too few or degenerate features or pairs.
    """
    if pairs:
        return [_from_pairs(pairs)], Start.PAIRS, [tuple((p.name, p.photo, p.site) for p in pairs)], None
    if is_elongated(photo.points, options.elongated) and len(spheres) < options.least_features:
        cable = start_from_unrolled(photo.points, _grey(photo), scan.points, scan.intensities, options)
        return [cable.placement], Start.UNROLLED, [()], cable
    if len(spheres) < options.least_features:
        raise StageError(
            STAGE,
            f"the scans hold {len(spheres)} spheres, {options.least_features} are needed to place the photos",
            "give pairs of places by hand",
        )
    found, agreements = _matched(photo, spheres, options, emit)
    most = len(agreements[0].photo)
    kept = [a for a in agreements if len(a.photo) > options.clear * most][:MOST_RIVALS]
    fused = [
        tuple((f"sphere {j + 1}", found[i, :3], spheres[j, :3]) for i, j in zip(a.photo, a.scan, strict=True))
        for a in kept
    ]
    return [a.placement for a in kept], Start.FEATURES, fused, None


def _matched(
    photo: PhotoCloud, spheres: Array, options: FuseOptions, emit: Emit
) -> tuple[Array, list[Agreement]]:
    """Spheres of the photos and their agreements with the scans': those seen in photos, then the cloud's."""
    tolerance_m, least = options.feature_tolerance_mm / 1000, options.least_features
    if len(photo.spheres) >= least:
        with suppress(StageError):
            found = photo.spheres
            return found, match_spheres(found, spheres, options.ball_share, tolerance_m, least)
    points, normals = evenly(photo, MOST_FOR_SPHERES)
    more = find_spheres(points, normals, lambda: emit(Event(stage=STAGE, done=10, total=STEPS)))
    found = np.concatenate([photo.spheres, more])
    return found, match_spheres(found, spheres, options.ball_share, tolerance_m, least)


def worth_of(
    start: Placement, kind: Start, fused: tuple[tuple[str, Array, Array], ...], cable: CableStart | None
) -> StartSigma:
    """How good a start is by itself."""
    if cable is not None:
        along, about = np.outer(cable.axis, cable.axis), np.eye(3) - np.outer(cable.axis, cable.axis)
        spread = np.zeros((7, 7))
        spread[:3, :3] = cable.turn_sigma_rad**2 * along + WELL_HELD**2 * about
        spread[3:6, 3:6] = cable.along_sigma_m**2 * along + WELL_HELD**2 * about
        spread[6, 6] = WELL_HELD**2
        return StartSigma(name=cable.held_by, spread=spread, place=cable.place)
    photo, site = (np.array([pair[k] for pair in fused]) for k in (1, 2))
    fit = fit_similarity(photo, site)
    spread = fit.covariance.copy()
    spread[6] /= fit.scale
    spread[:, 6] /= fit.scale
    # a lamp or a habit of the hand shifts all of them alike: their mean is no better than one of them
    noise_m = max(fit.noise_sigma, LEAST_NOISE_M[kind])
    spread *= (noise_m / max(fit.noise_sigma, 1e-9)) ** 2
    spread[3:6, 3:6] += noise_m**2 * np.eye(3)
    if len(fused) == 3:
        # two of nine residuals are left: no scatter that one could trust
        spread *= 9.0
    return StartSigma(name=str(kind), spread=spread, place=start.apply(photo).mean(axis=0))


def _from_pairs(pairs: tuple[GivenPair, ...]) -> Placement:
    photo, site = (np.array([getattr(p, name) for p in pairs], dtype=float) for name in ("photo", "site"))
    for name, places in (("photo", photo), ("site", site)):
        singular = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)
        if len(places) < 3 or singular[1] < 0.03 * singular[0]:
            raise StageError(
                STAGE,
                f"the {len(places)} given pairs ({name}) lie on a line or are fewer than three",
                "add a pair off the line",
            )
    fit = fit_similarity(photo, site)
    return Placement(scale=fit.scale, rotation=fit.rotation, translation=fit.translation)


def _grey(photo: PhotoCloud) -> Array:
    return photo.colours.astype(float).mean(axis=1) if len(photo.colours) else np.zeros(0)


def evenly(photo: PhotoCloud, most: int) -> tuple[Array, Array]:
    """At most ``most`` points, evenly spread, so that near and far parts count alike.

    Each cube gives some of its points, whichever: the cubes are far larger than the noise, since one point a
    small cube would prefer points off the surface, which have their cubes to themselves, and make balls and
    rods wider.
    """
    # every so many points first: cubes of all of them would take longer than the rest of the fusion
    some = np.arange(0, len(photo), max(len(photo) // (12 * most), 1))
    points, normals = photo.points[some], photo.normals[some]
    low, high = np.percentile(points, 2, axis=0), np.percentile(points, 98, axis=0)
    cube = cube_of(points, float(np.linalg.norm(high - low)) * CUBE_SHARE)
    mixed = np.random.default_rng(len(points)).permutation(len(points))
    order = mixed[np.argsort(cube[mixed], kind="stable")]
    counts = np.bincount(cube)
    rank = np.empty(len(points), dtype=np.int64)
    rank[order] = np.arange(len(points)) - np.repeat(np.cumsum(counts) - counts, counts)
    # so many from each: the most that together are not too many
    given = np.cumsum(np.bincount(rank))
    chosen = np.flatnonzero(rank < max(int(np.searchsorted(given, most, side="right")), 1))
    return points[chosen], normals[chosen]
