"""From a finished run to what the report tells: every figure is picked up here, none is computed twice.

Takes a :class:`~pipeline.cable.records.CableRun`; gives :class:`~pipeline.report.types.ReportData`.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from pipeline.cable.lens_pictures import before_after_picture, distortion_grid_picture
from pipeline.cable.measure import Section
from pipeline.cable.records import BlockRun, CableRun
from pipeline.cable.relief import Relief
from pipeline.core.fits.cylinder import Cylinder, fit_cylinder
from pipeline.core.parallel import each_side_by_side
from pipeline.core.pictures import read_colour
from pipeline.core.vocabulary import Array
from pipeline.report.model import view_mesh
from pipeline.report.notes import notes_of
from pipeline.report.relief_records import ReliefFeature, ReliefSummary
from pipeline.report.types import (
    AxisSummary,
    BlockSummary,
    DiameterProfile,
    LensEffect,
    LensPictures,
    MosaicJoint,
    MosaicSummary,
    ReportData,
    StationResult,
    SurfacePriorStation,
    SurfacePriorSummary,
    TruthStation,
    UnrolledPicture,
)

EFFECT_POINTS = 4000


def collect(
    run: CableRun,
    truth: tuple[TruthStation, ...],
    timing_s: Mapping[str, float],
    peak_memory_mb: float,
) -> ReportData:
    """Gather everything that the report shows."""
    ring, measurement = run.ring, run.measurement
    return ReportData(
        name=run.survey.name,
        length_m=run.survey.cable.travel_m,
        blocks=tuple(_block(b) for b in run.blocks),
        stations=tuple(_station(s) for s in measurement.sections),
        truth=truth,
        lens_pictures=(_lens_pictures(run.blocks[0]),),
        lens_effects=tuple(e for e in each_side_by_side(_lens_effect, run.blocks) if e is not None),
        unrolled=unrolled_picture(ring.picture, ring.texel_mm, ring.picture_azimuth, ring.picture_y_m),
        block_unrolled=tuple(_block_picture(b) for b in run.blocks),
        profile=DiameterProfile(
            position_m=measurement.profile_y_m,
            diameter_mm=measurement.profile_diameter_mm,
            sigma_mm=measurement.profile_sigma_mm,
        ),
        axis=_axis(run),
        mosaic=_mosaic(run),
        relief=_relief(measurement.relief),
        surface_prior=_surface_prior(run),
        mesh=view_mesh(ring),
        timing_s=timing_s,
        peak_memory_mb=peak_memory_mb,
        warnings=notes_of(run),
    )


def _block(run: BlockRun) -> BlockSummary:
    orientation, stated = run.orientation, run.lens
    lens, refined = orientation.lens, orientation.lens != stated.lens
    along_m, around_m = run.surface.cell_m
    return BlockSummary(
        name=run.block.name,
        images=len(run.frames),
        calibrated=int(orientation.calibrated.sum()),
        keypoints_per_image=float(orientation.keypoints.mean()),
        reprojection_px=orientation.reprojection_px,
        focal_px=lens.focal_px,
        focal_sigma_px=lens.focal_sigma_px,
        principal_point_px=lens.principal_point_px,
        division_lambda=lens.division_lambda,
        lambda_radius=lens.lambda_radius,
        lambda_sigma=lens.lambda_sigma,
        lens_method="adjustment" if refined else stated.method.value,
        coverage_m2=float(run.crop.keep.sum() * along_m * around_m),
        resolution_mm=run.dense.ground_sample_mm,
        angle_deg=run.block.angle_deg,
    )


def _station(section: Section) -> StationResult:
    return StationResult(
        name=section.name,
        position_m=section.position_m,
        diameter_mm=section.diameter_mm,
        sigma_mm=section.sigma_mm,
        min_mm=section.min_mm,
        max_mm=section.max_mm,
        coverage_deg=section.coverage_deg,
        section_mm=section.points_mm,
        circle_centre_mm=(float(section.centre_mm[0]), float(section.centre_mm[1])),
        circle_radius_mm=section.diameter_mm / 2,
        base_diameter_mm=section.base_diameter_mm,
        base_sigma_mm=section.base_sigma_mm,
    )


def _lens_pictures(run: BlockRun) -> LensPictures:
    lens = run.orientation.lens
    frame = read_colour(run.frames.files[len(run.frames) // 2], "report")
    before, after = before_after_picture(frame, lens)
    return LensPictures(
        block=run.block.name, grid=_rgb(distortion_grid_picture(lens)), before=_rgb(before), after=_rgb(after)
    )


def _lens_effect(run: BlockRun) -> LensEffect | None:
    """Cylinders through the same tie points, adjusted without and with the lens correction."""
    effect = run.orientation.lens_effect
    if effect is None:
        return None
    step = max(len(run.orientation.points) // EFFECT_POINTS, 1)
    before, after = effect.points_uncorrected[::step], run.orientation.points[::step]
    bent, straight = _cylinder(before), _cylinder(after)
    return LensEffect(
        block=run.block.name,
        diameter_uncorrected_mm=2000 * bent.radius,
        diameter_corrected_mm=2000 * straight.radius,
        residual_uncorrected_mm=_rms_mm(bent, before),
        residual_corrected_mm=_rms_mm(straight, after),
        bow_uncorrected_mm=_bow_mm(before),
        bow_corrected_mm=_bow_mm(after),
        points_uncorrected_mm=1000 * before,
        points_corrected_mm=1000 * after,
    )


def _cylinder(points: Array) -> Cylinder:
    return fit_cylinder(points, direction=(0.0, 1.0, 0.0))


def _rms_mm(cylinder: Cylinder, points: Array) -> float:
    return 1000 * float(np.sqrt(np.mean(cylinder.distances(points) ** 2)))


def _bow_mm(points: Array) -> float:
    """Sagitta of the axis over the length of the block."""
    bow = fit_cylinder(points, direction=(0.0, 1.0, 0.0), bowed=True).bow
    half_m = float(np.ptp(points[:, 1])) / 2
    return 1000 * float(np.linalg.norm(bow)) * half_m**2


def _block_picture(run: BlockRun) -> UnrolledPicture:
    picture = run.picture
    return unrolled_picture(picture.colour, picture.texel_mm, picture.azimuth, picture.y_m, run.block.name)


def unrolled_picture(
    colour: NDArray[np.uint8], texel_mm: float, azimuth: Array, y_m: Array, name: str = ""
) -> UnrolledPicture:
    """A picture (h, w, 3), blue, green, red, with the places of its edges: half a texel beyond the centres
    of the outermost texels (azimuths in radians, places in metres)."""
    return UnrolledPicture(
        image=_rgb(colour),
        mm_per_px=texel_mm,
        theta_range_deg=_edges(np.rad2deg(azimuth)),
        y_range_m=_edges(y_m),
        name=name,
    )


def _edges(centres: Array) -> tuple[float, float]:
    """Outer edges of evenly spaced cells."""
    half = (centres[1] - centres[0]) / 2
    return float(centres[0] - half), float(centres[-1] + half)


def _axis(run: CableRun) -> AxisSummary:
    measurement = run.measurement
    good = np.isfinite(measurement.profile_centre_mm[:, 0])
    y_m, centres = measurement.profile_y_m[good], measurement.profile_centre_mm[good]
    if len(y_m) < 2:
        return AxisSummary(
            straightness_mm_per_m=float("nan"), position_m=y_m, bow_mm=0 * centres, centre_mm=centres
        )
    part = ((y_m - y_m[0]) / (y_m[-1] - y_m[0]))[:, None]
    chord = centres[0] * (1 - part) + centres[-1] * part
    return AxisSummary(
        straightness_mm_per_m=measurement.straightness_mm_per_m,
        position_m=y_m,
        bow_mm=centres - chord,
        centre_mm=centres,
    )


def _mosaic(run: CableRun) -> MosaicSummary:
    names = [b.block.name for b in run.blocks]
    joins = run.mosaic.joins
    together = run.together
    readout = (float("nan"), float("nan"))
    if together is not None and together.readout_sigma_mm > 0:
        readout = together.readout_mm, together.readout_sigma_mm
    return MosaicSummary(
        joints=tuple(
            MosaicJoint(
                first=names[j.first],
                second=names[j.second],
                pairs=j.pairs,
                residual_mm=float(np.sqrt(np.sum(j.residual_mm**2))),
            )
            for j in joins
        ),
        scale_corrections={n: float(s) for n, s in zip(names, run.mosaic.placement.scales, strict=True)},
        tie_points=sum(j.pairs for j in joins) if together is None else together.shared_marks,
        shared_residual_px=float("nan") if together is None else together.shared_residual_px,
        readout_mm=readout[0],
        readout_sigma_mm=readout[1],
    )


def _surface_prior(run: CableRun) -> SurfacePriorSummary | None:
    effect = run.together.surface_effect if run.together is not None else None
    if effect is None:
        return None
    columns = (effect.without_mm, effect.with_mm, effect.without_sigma_mm, effect.with_sigma_mm)
    stations = tuple(
        SurfacePriorStation(
            name=name,
            without_mm=float(without),
            with_mm=float(tied),
            without_sigma_mm=float(without_sigma),
            with_sigma_mm=float(tied_sigma),
        )
        for name, without, tied, without_sigma, tied_sigma in zip(effect.names, *columns, strict=True)
    )
    return SurfacePriorSummary(sigma_mm=effect.sigma_mm, used=effect.used, stations=stations)


def _relief(relief: Relief) -> ReliefSummary:
    return ReliefSummary(
        features=tuple(ReliefFeature(**vars(f) | {"kind": f.kind.value}) for f in relief.features),
        height_mm=relief.height_mm.astype(np.float64),
        theta_range_deg=_edges(np.rad2deg(relief.azimuth)),
        y_range_m=_edges(relief.y_m),
        level_mm=relief.level_mm,
    )


def _rgb(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    return np.ascontiguousarray(image[..., ::-1])
