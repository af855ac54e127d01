"""A laser scan of a cable brought into the frame of its photo model, and held against it.

Takes a finished run's cloud, joined surface and diameters, and the scan; gives the seven parameters with
what holds them, the scan in the cable frame, its deviations from the model and its diameters.  Leaves out
reading scans (:mod:`pipeline.scan.reading`) and what is written (:mod:`pipeline.report.scan_page`).

The scan's scale is compared, not imposed: the scan comes into the cable frame by the seven parameters, so
deviations show form; its diameters are told in the scan's own metres, so that a photo model of the wrong
scale is seen as what it is.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RegularGridInterpolator

from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event
from pipeline.core.vocabulary import Array
from pipeline.scan.finished import FinishedRun
from pipeline.steel.fuse import fuse
from pipeline.steel.fuse_records import FuseOptions, Fusion, GivenPair, Placement, ScanCloud

STAGE = "scan"
OPTIONS = FuseOptions(scale_sigma_share=0.01)
WINDOW_M = 0.02
"""A station's diameter rests on the scan within this to both sides."""
SECTORS = 72
LEAST_SECTORS, LEAST_IN_SECTOR = 18, 3
"""A diameter needs so many sectors of 5 degrees with so many points."""
CLOSED_SECTORS = 54
"""Of 270 degrees and more, the circumference itself tells its diameter."""
PATCH_SECTORS = 6
"""Neighbouring sectors err alike: so many count as one."""
FARTHEST_SIGMAS = 6.0
"""Points farther off than this robust noise are other things, and not counted."""


@dataclass(frozen=True, kw_only=True)
class ScannedDiameter:
    """A station of the run, as the scan has it.

    Attributes:
        name, position_m: of the station.
        photo_mm, photo_sigma_mm: as the run measured it.
        scan_mm, scan_sigma_mm: in the scan's metres; NaN where the scan shows too little.
        coverage_deg: of the circumference, that both show.
    """

    name: str
    position_m: float
    photo_mm: float
    photo_sigma_mm: float
    scan_mm: float
    scan_sigma_mm: float
    coverage_deg: float


@dataclass(frozen=True, kw_only=True)
class ScanJoin:
    """A scan in the cable frame.

    Attributes:
        fusion: scan_from_cable, with covariance and residuals.
        scan: its points in the cable frame.
        kept: (n,) which of them were compared: on the model, and no other things.
        theta, position_m: (n,) azimuth in radians and place along the cable of each point.
        deviations_mm: (n,) scan less model, outward; NaN off the model.
        mean_mm, median_mm, rms_mm, noise_mm: of those kept; noise is robust.
        coverage: part of the model's surface that the scan shows.
        diameters: of the run's stations.
    """

    fusion: Fusion
    scan: ScanCloud
    kept: NDArray[np.bool_]
    theta: Array
    position_m: Array
    deviations_mm: Array
    mean_mm: float
    median_mm: float
    rms_mm: float
    noise_mm: float
    coverage: float
    diameters: tuple[ScannedDiameter, ...]

    @property
    def scale(self) -> float:
        """Length in the scan over length in the photo model."""
        return self.fusion.placement.scale

    @property
    def scale_sigma(self) -> float:
        """Standard deviation of the scale."""
        return _scale_sigma(self.fusion)

    @property
    def cable_from_scan(self) -> Placement:
        """x_cable = scale * rotation @ x_scan + translation."""
        return inverse(self.fusion.placement)


def _scale_sigma(fusion: Fusion) -> float:
    return fusion.placement.scale * float(np.sqrt(fusion.covariance[6, 6]))


def inverse(placement: Placement) -> Placement:
    """The placement the other way."""
    scale, rotation = 1 / placement.scale, placement.rotation.T
    return Placement(scale=scale, rotation=rotation, translation=-scale * rotation @ placement.translation)


def join_scan(run: FinishedRun, scan: ScanCloud, emit: Emit, pairs: tuple[GivenPair, ...] = ()) -> ScanJoin:
    """Bring a scan of the cable into the frame of a finished run.

    Args:
        run: its cloud, surface and stations.
        scan: points on the cable, metres, any frame.
        emit: progress of the stage *scan*.
        pairs: places pointed out in both, three or more; then nothing is searched.

    Raises:
        StageError: too few points, another cable, too little overlap.
    """

    def tell(event: Event) -> None:
        emit(Event(stage=STAGE, done=min(event.done, event.total - 1), total=event.total))

    fusion = fuse(run.cloud, scan, (), OPTIONS, tell, pairs)
    moved = replace(scan, points=inverse(fusion.placement).apply(scan.points))
    theta, y, off_mm = _deviations(moved.points, run)
    known = np.isfinite(off_mm)
    if known.sum() < 100:
        raise StageError(STAGE, "the scan shows none of the model", "scan the part that was filmed")
    middle = float(np.median(off_mm[known]))
    noise = 1.4826 * float(np.median(np.abs(off_mm[known] - middle)))
    kept = known & (np.abs(off_mm - middle) < FARTHEST_SIGMAS * noise + 1.0)
    emit(Event(stage=STAGE, done=1, total=1))
    return ScanJoin(
        fusion=fusion,
        scan=moved,
        kept=kept,
        theta=theta,
        position_m=y,
        deviations_mm=off_mm,
        mean_mm=float(off_mm[kept].mean()),
        median_mm=float(np.median(off_mm[kept])),
        rms_mm=float(np.sqrt(np.mean(off_mm[kept] ** 2))),
        noise_mm=noise,
        coverage=_coverage(theta[kept], y[kept], run),
        diameters=tuple(
            _diameter(
                station, theta[kept], y[kept], off_mm[kept], fusion.placement.scale, _scale_sigma(fusion)
            )
            for station in run.stations
        ),
    )


def _deviations(points: Array, run: FinishedRun) -> tuple[Array, Array, Array]:
    """Azimuth, place along the cable, and distance outward from the model's surface (mm) of (n, 3) points."""
    theta = np.arctan2(-points[:, 2], points[:, 0]) % (2 * np.pi)
    rho_mm = 1000 * np.hypot(points[:, 0], points[:, 2])
    # the surface goes on around: the first column again behind the last
    columns = np.append(run.theta, run.theta[0] + 2 * np.pi)
    surface = np.column_stack([run.radius_mm, run.radius_mm[:, 0]])
    at = RegularGridInterpolator((run.position_m, columns), surface, bounds_error=False, fill_value=np.nan)
    inside = (theta - run.theta[0]) % (2 * np.pi) + run.theta[0]
    return theta, points[:, 1], rho_mm - at(np.column_stack([points[:, 1], inside]))


def _coverage(theta: Array, y: Array, run: FinishedRun) -> float:
    """Part of the model's cells of 5 degrees and 10 mm in which the scan has points."""

    def cells(turn: Array, along: Array) -> set[tuple[int, int]]:
        rows, columns = np.floor(along / 0.01).astype(int), np.floor(turn / (2 * np.pi) * SECTORS).astype(int)
        return set(zip(rows.tolist(), (columns % SECTORS).tolist(), strict=True))

    row, column = np.nonzero(np.isfinite(run.radius_mm))
    model = cells(run.theta[column], run.position_m[row])
    return len(model & cells(theta, y)) / max(len(model), 1)


def _diameter(
    station: dict[str, object],
    theta: Array,
    y: Array,
    off_mm: Array,
    scale: float,
    scale_sigma: float,
) -> ScannedDiameter:
    """The scan's diameter: the model's, more by the mean deviation, every sector counting alike."""
    place, photo = float(str(station["position_m"])), float(str(station["diameter_mm"]))
    near = np.abs(y - place) < WINDOW_M
    sector = np.floor(theta[near] / (2 * np.pi) * SECTORS).astype(np.int64) % SECTORS
    count = np.bincount(sector, minlength=SECTORS)
    full = count >= LEAST_IN_SECTOR
    scanned, sigma = np.nan, np.nan
    if full.sum() >= LEAST_SECTORS:
        means = np.bincount(sector, off_mm[near], minlength=SECTORS)[full] / count[full]
        patch = np.arange(len(means)) // PATCH_SECTORS
        patches = np.bincount(patch, means) / np.bincount(patch)
        scanned = scale * (photo + 2 * float(means.mean()))
        sigma = 2 * float(patches.std(ddof=1)) / np.sqrt(len(patches))
        if full.sum() < CLOSED_SECTORS:
            # on an open arc a larger cable farther off fits nearly as well
            sigma = float(np.hypot(sigma, scale_sigma * photo))
    return ScannedDiameter(
        name=str(station["name"]),
        position_m=place,
        photo_mm=photo,
        photo_sigma_mm=float(str(station["sigma_mm"])),
        scan_mm=float(scanned),
        scan_sigma_mm=float(sigma),
        coverage_deg=360.0 * int(full.sum()) / SECTORS,
    )
