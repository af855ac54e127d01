"""Photos and scans brought together: seven parameters, first by features, then by points.

Takes a photo cloud in any frame and scale, the registered scans and what features were fitted to them; gives
the placement with its covariance, residuals, and which directions nothing holds.  The same door brings a
cable's photo model and a laser scan of it together.  Leaves out how the photo cloud is made
(:mod:`pipeline.steel.photo_model`) and the merged file (:mod:`pipeline.steel.merged_cloud`).

Source: paper, section 2.3: the photo cloud is registered to the scans by features, "for one scale".
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event
from pipeline.core.vocabulary import Array
from pipeline.steel.cable_start import CableStart
from pipeline.steel.fuse_records import (
    FusedPair,
    FuseOptions,
    Fusion,
    GivenPair,
    PhotoCloud,
    Placement,
    ScanCloud,
    Start,
)
from pipeline.steel.fuse_rivals import best_laid
from pipeline.steel.fuse_sigma import Held, StartSigma, judge
from pipeline.steel.fuse_start import STAGE, STEPS, evenly, find_starts, worth_of
from pipeline.steel.point_match import Laid, lay
from pipeline.steel.records import Feature, FeatureKind
from pipeline.steel.scanned_surface import ScannedSurface, single, thinned, towards_scanners

MOST_SCANNED = 500_000
NOTHING_HELD = Held(covariance=np.zeros((7, 7)), directions=(), undetermined=np.zeros((7, 0)), patch_m=0.0)
ROUGH_SHARE = 0.25
"""Scatter of the scan's means about their surface, as a share of their spacing."""


def fuse(
    photo: PhotoCloud,
    scan: ScanCloud,
    scan_features: tuple[Feature, ...],
    options: FuseOptions,
    emit: Emit,
    pairs: tuple[GivenPair, ...] = (),
) -> Fusion:
    """Bring a photo cloud into the site frame.

    Args:
        photo: its cloud.
        scan: registered points; only those near the photo's are used.
        scan_features: spheres (points with a radius) fitted to the scans, site frame; others are ignored.
        options: see there.
        emit: told at every step.
        pairs: places pointed out in both, three or more; then nothing is searched.

    Raises:
        StageError: too few points or pairs, degenerate or ambiguous features, too little overlap.
    """
    _check(photo, scan)
    emit(Event(stage=STAGE, done=0, total=STEPS))
    spheres = np.array(
        [[*f.place, f.radius_m] for f in scan_features if f.kind is FeatureKind.POINT and f.radius_m > 0]
    ).reshape(-1, 4)
    photo = _with_normals(photo)
    starts, kind, fused, cable = find_starts(photo, scan, spheres, options, emit, pairs)
    worth = [worth_of(start, kind, some, cable) for start, some in zip(starts, fused, strict=True)]
    points, normals = evenly(photo, options.photo_points)
    emit(Event(stage=STAGE, done=40, total=STEPS))
    tried = []
    for number, start in enumerate(starts):
        done = 40 + 50 * number // len(starts)

        def tick(_: int, done: int = done) -> None:
            emit(Event(stage=STAGE, done=done, total=STEPS))

        surface, edge = _surface(scan, start, points, options)
        laid, held = _laid(
            points, normals, surface, spheres, start, edge, worth[number], cable, options, tick
        )
        tried.append((laid, held, number))
    laid, held, number = best_laid(tried, points, options)
    fusion = _fusion(laid, held, kind, fused[number], cable, options)
    emit(Event(stage=STAGE, done=STEPS, total=STEPS))
    return fusion


def _check(photo: PhotoCloud, scan: ScanCloud) -> None:
    for name, points in (("photo", photo.points), ("scan", scan.points)):
        if len(points) < 1000:
            raise StageError(STAGE, f"the {name} cloud has {len(points)} points", "give at least a thousand")
        if not np.isfinite(points[:: len(points) // 100_000 + 1]).all():
            raise StageError(STAGE, f"the {name} cloud holds places that are no numbers", "export it anew")


def _with_normals(photo: PhotoCloud) -> PhotoCloud:
    """Normals by the surface's own quadrics where the cloud brings none; their side is then arbitrary."""
    if len(photo.normals) == len(photo.points):
        return photo
    surface = ScannedSurface(single(photo.points))
    size = float(np.linalg.norm(np.ptp(photo.points, axis=0)))
    return replace(photo, normals=surface.at(photo.points, size).normals)


def _surface(
    scan: ScanCloud, start: Placement, points: Array, options: FuseOptions
) -> tuple[ScannedSurface, float]:
    """The scanned surface near the photo points, thinned; and the edge of the thinning, metres."""
    places = start.apply(points)
    reach = 2 * options.gate_mm / 1000
    low, high = places.min(axis=0) - reach, places.max(axis=0) + reach
    inside = np.all((scan.points >= low) & (scan.points <= high), axis=1)
    near = scan.where(inside)
    if len(near) < 1000:
        raise StageError(
            STAGE,
            f"only {len(near)} scanned points lie where the photo cloud comes to lie",
            "check that both show the same part, or give pairs of places by hand",
        )
    edge = options.scan_spacing_mm / 4000
    while True:
        thin = thinned(near.points, towards_scanners(near), edge, MOST_SCANNED)
        surface = ScannedSurface(thin)
        # cubes finer than the noise hold layers of it: their neighbourhoods are no surface
        if surface.roughness_m() < ROUGH_SHARE * thin.edge_m or thin.edge_m > options.scan_spacing_mm / 501:
            return surface, thin.edge_m
        edge = 2 * thin.edge_m


def _laid(
    points: Array,
    normals: Array,
    surface: ScannedSurface,
    spheres: Array,
    start: Placement,
    edge: float,
    worth: StartSigma,
    cable: CableStart | None,
    options: FuseOptions,
    tick: Callable[[int], None],
) -> tuple[Laid, Held]:
    """Lay the cloud; where directions turn out to be undetermined, again from the start without them."""
    held_motions = np.zeros((7, 0))
    gate = options.gate_mm / 1000
    if cable is not None:
        radius = float(np.linalg.norm(np.ptp(points, axis=0))) * start.scale / 20
        gate = min(gate, radius)
    axis = None if cable is None else cable.axis
    for _ in range(2):
        laid = lay(
            points, normals, surface, spheres, start, gate, options.iterations, edge, held_motions, tick
        )
        if len(laid.chosen) < 200:
            return laid, NOTHING_HELD
        held = judge(laid, options.undetermined_mm / 1000, worth, axis)
        if not held.undetermined.shape[1] or held_motions.shape[1]:
            break
        held_motions = held.undetermined
    return laid, held


def _fusion(
    laid: Laid,
    held: Held,
    kind: Start,
    fused: tuple[tuple[str, Array, Array], ...],
    cable: CableStart | None,
    options: FuseOptions,
) -> Fusion:
    off = 1000 * laid.distances
    open_ones = [d.words for d in held.directions if not d.determined]
    notes = []
    if cable is not None:
        notes.append(_cable_note(cable, bool(open_ones)))
    elif open_ones:
        notes.append(f"The points do not determine {' or '.join(open_ones)}; it is as the {kind} gave it.")
    return Fusion(
        placement=laid.placement,
        centre=laid.centre,
        covariance=held.covariance,
        start=kind,
        pairs=tuple(
            FusedPair(name=n, photo=p, site=s, residual_mm=1000 * (laid.placement.apply(p) - s))
            for n, p, s in fused
        ),
        directions=held.directions,
        places=laid.places,
        residuals_mm=off,
        overlap=laid.share,
        median_mm=float(np.median(np.abs(off))),
        noise_mm=1000 * laid.noise_m,
        patch_mm=1000 * held.patch_m,
        notes=tuple(notes),
    )


def _cable_note(cable: CableStart, open_left: bool) -> str:
    if cable.held_by:
        return (
            f"Turn and slide along the cable are held by its {cable.held_by} "
            f"(correlation {cable.score:.2f}, next best {cable.rival:.2f})."
        )
    if open_left:
        return (
            "Neither relief nor brightness tells how far the cable is turned and slid: these two directions "
            "are undetermined, the middles were laid onto each other."
        )
    return "Turn and slide along the cable are held by the points alone."
