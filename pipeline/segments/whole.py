"""The report on the whole cable, from what its segments tell and the joined surface.

Takes :class:`~pipeline.segments.told.Told` records and placements; gives the ReportData that the usual page
and files are made of.  Computes no diameter: those are the segments'.
"""

from collections.abc import Mapping
from dataclasses import replace
from itertools import chain
from math import nan, sqrt

import numpy as np

from pipeline.cable.ring import Ring
from pipeline.cable.survey import Survey
from pipeline.report.collect import unrolled_picture
from pipeline.report.model import view_mesh
from pipeline.report.relief_records import ReliefSummary
from pipeline.report.segment_records import SegmentSummary
from pipeline.report.types import (
    AxisSummary,
    BlockSummary,
    DiameterProfile,
    MosaicSummary,
    ReportData,
    TruthStation,
)
from pipeline.segments.bends import WholeAxis
from pipeline.segments.told import Told

MOST_RELIEF_ROWS = 4000


def whole_report(
    survey: Survey,
    parts: tuple[Told, ...],
    segments: tuple[SegmentSummary, ...],
    axes: tuple[WholeAxis, ...],
    ring: Ring,
    frames: int,
    truth: tuple[TruthStation, ...],
    timing_s: Mapping[str, float],
    peak_memory_mb: float,
) -> ReportData:
    """Gather everything that the report on the whole shows.

    Args:
        survey: the whole one.
        parts, segments: one each a segment, in order.
        axes: of the segments, each as far as neighbours go on without a gap.
        ring: the joined surface.
        frames: worked on, a block.
        truth: true diameters, where they are known.
        timing_s, peak_memory_mb: of the whole run.
    """
    return ReportData(
        name=survey.name,
        length_m=survey.cable.travel_m,
        blocks=tuple(_block(of, segments, frames) for of in zip(*(p.blocks for p in parts), strict=True)),
        stations=tuple(chain.from_iterable(p.stations for p in parts)),
        truth=truth,
        unrolled=unrolled_picture(ring.picture, ring.texel_mm, ring.picture_azimuth, ring.picture_y_m),
        profile=_profile(parts),
        axis=_axis(axes),
        mosaic=_mosaic(parts),
        relief=_relief(parts, ring),
        mesh=view_mesh(ring),
        timing_s=timing_s,
        peak_memory_mb=peak_memory_mb,
        warnings=_warnings(parts, segments),
        segments=segments,
    )


def _block(of: tuple[BlockSummary, ...], segments: tuple[SegmentSummary, ...], frames: int) -> BlockSummary:
    """One camera over all segments: means over its images; its lens is found anew in every segment."""
    images = np.array([b.images for b in of], dtype=float)

    def mean(name: str) -> float:
        return float(np.average([getattr(b, name) for b in of], weights=images))

    told = [(s.to_m - s.from_m) / s.length_m for s in segments]
    missing = sum(b.images - b.calibrated for b in of)
    point = np.average([b.principal_point_px for b in of], axis=0, weights=images)
    return replace(
        of[0],
        images=frames,
        calibrated=max(frames - missing, 0),
        keypoints_per_image=mean("keypoints_per_image"),
        reprojection_px=sqrt(float(np.average([b.reprojection_px**2 for b in of], weights=images))),
        focal_px=mean("focal_px"),
        focal_sigma_px=mean("focal_sigma_px"),
        principal_point_px=(float(point[0]), float(point[1])),
        division_lambda=mean("division_lambda"),
        lambda_sigma=mean("lambda_sigma"),
        coverage_m2=float(sum(b.coverage_m2 * share for b, share in zip(of, told, strict=True))),
        resolution_mm=mean("resolution_mm"),
    )


def _profile(parts: tuple[Told, ...]) -> DiameterProfile:
    profiles = [p.profile for p in parts]
    return DiameterProfile(
        position_m=np.concatenate([p.position_m for p in profiles]),
        diameter_mm=np.concatenate([p.diameter_mm for p in profiles]),
        sigma_mm=np.concatenate([p.sigma_mm for p in profiles]),
    )


def _axis(axes: tuple[WholeAxis, ...]) -> AxisSummary:
    """The axis from end to end; where a gap breaks it, each piece about a chord of its own."""
    return AxisSummary(
        straightness_mm_per_m=max((a.straightness_mm_per_m for a in axes), default=nan),
        position_m=np.concatenate([np.zeros(0), *(a.y_m for a in axes)]),
        bow_mm=np.concatenate([np.zeros((0, 2)), *(a.bow_mm for a in axes)]),
        centre_mm=np.concatenate([np.zeros((0, 2)), *(a.centre_mm for a in axes)]),
        sigma_mm=np.concatenate([np.zeros(0), *(a.sigma_mm for a in axes)]),
    )


def _mosaic(parts: tuple[Told, ...]) -> MosaicSummary:
    """The joints between neighbouring blocks, over all segments."""
    mosaics = [p.mosaic for p in parts]
    pairs = {(j.first, j.second): j for m in mosaics for j in m.joints}
    joints = []
    for names in pairs:
        mine = [j for m in mosaics for j in m.joints if (j.first, j.second) == names]
        weights = np.array([j.pairs for j in mine], dtype=float)
        squares = [j.residual_mm**2 for j in mine]
        residual = sqrt(float(np.average(squares, weights=weights))) if weights.sum() else nan
        joints.append(replace(mine[0], pairs=int(weights.sum()), residual_mm=residual))
    readout = np.array([(m.readout_mm, m.readout_sigma_mm) for m in mosaics])
    known = readout[np.isfinite(readout[:, 0])]
    weight = known[:, 1] ** -2
    return replace(
        mosaics[0],
        joints=tuple(joints),
        tie_points=sum(m.tie_points for m in mosaics),
        shared_residual_px=sqrt(float(np.nanmean([m.shared_residual_px**2 for m in mosaics]))),
        readout_mm=float(known[:, 0] @ weight / weight.sum()) if len(known) else nan,
        readout_sigma_mm=float(weight.sum() ** -0.5) if len(known) else nan,
    )


def _relief(parts: tuple[Told, ...], ring: Ring) -> ReliefSummary:
    """What stands out anywhere, and the heights of the joined surface over its median, row by row."""
    step = max(-(-len(ring.y_m) // MOST_RELIEF_ROWS), 1)
    radius_mm = 1000 * np.where(ring.measured, ring.radius_m, np.nan)[::step, ::step].astype(np.float64)
    seen = np.isfinite(radius_mm).any(axis=1)
    base = np.full(len(radius_mm), nan)
    base[seen] = np.nanmedian(radius_mm[seen], axis=1)
    turn, rise = ring.azimuth[1] - ring.azimuth[0], ring.y_m[1] - ring.y_m[0]
    return ReliefSummary(
        features=tuple(chain.from_iterable(p.features for p in parts)),
        height_mm=radius_mm - base[:, None],
        theta_range_deg=(
            float(np.rad2deg(ring.azimuth[0] - turn / 2)),
            float(np.rad2deg(ring.azimuth[-1] + turn / 2)),
        ),
        y_range_m=(float(ring.y_m[0] - rise / 2), float(ring.y_m[-1] + rise / 2)),
        level_mm=max(p.relief_level_mm for p in parts),
    )


def _warnings(parts: tuple[Told, ...], segments: tuple[SegmentSummary, ...]) -> tuple[str, ...]:
    """What the segments say, each sentence once, with the places where it holds."""
    said: dict[str, list[str]] = {}
    for part, segment in zip(parts, segments, strict=True):
        for sentence in part.warnings:
            said.setdefault(sentence, []).append(segment.name)
    everywhere = len(segments)
    return tuple(
        sentence if len(names) == everywhere else f"Segment {', '.join(names)}: {sentence}"
        for sentence, names in said.items()
    )
