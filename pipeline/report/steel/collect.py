"""From a finished steel run to what its report tells: every figure is picked up here, none is computed twice.

Takes a :class:`~pipeline.steel.steel_run.SteelRun`; gives a :class:`SteelReport`.
"""

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from pipeline.core.rotations import angle_between_deg
from pipeline.report.steel.members import balls_of, deflection_of, nodes_of, place, rods_of
from pipeline.report.steel.records import ComparisonRow, FusionSummary, StationRow, SteelReport, TargetRow
from pipeline.report.steel.structure_rows import ColumnRow, Place
from pipeline.steel.columns import Column
from pipeline.steel.fuse_records import Fusion
from pipeline.steel.photo_records import OrientedPhotos
from pipeline.steel.records import FeatureKind, StationPose
from pipeline.steel.registration_records import Registration
from pipeline.steel.steel_run import SteelRun

ARCSEC = math.degrees(1) * 3600
_PLACES = {FeatureKind.POINT: 3, FeatureKind.LINE: 2, FeatureKind.PLANE: 1}
"""How many of the first values of a feature's covariance are lengths."""
_TWO_SIGMA = 0.0228
"""Chance of an error beyond two sigma, on one side."""


def collect(found: SteelRun, timing_s: Mapping[str, float], peak_memory_mb: float) -> SteelReport:
    """Gather everything that the report shows."""
    survey, registration = found.survey, found.registration
    return SteelReport(
        name=survey.name,
        base="" if survey.control else survey.base.name,
        north_deg=survey.structure.north_deg,
        target_radius_mm=math.nan if survey.targets.radius_mm is None else survey.targets.radius_mm,
        stations=_stations(registration),
        targets=tuple(
            TargetRow(
                name=feature.name,
                kind=feature.kind.value,
                position_m=place(feature.place),
                sigma_mm=1000
                * _mean_sigma(feature.covariance[: _PLACES[feature.kind], : _PLACES[feature.kind]]),
                seen_by=seen_by,
            )
            for feature, seen_by in zip(registration.features, registration.seen_by, strict=True)
        ),
        gross=registration.gross,
        components=registration.components,
        residuals=registration.residuals,
        rounds=registration.rounds,
        comparison=_comparison(found),
        icp_pairs=found.icp.pairs if found.icp else (),
        rods=rods_of(found.members.rods) if found.members else (),
        uprights=rods_of(found.members.columns) if found.members else (),
        balls=balls_of(found.members) if found.members else (),
        nodes=nodes_of(found.nodes),
        columns=tuple(_column(column) for column in found.columns),
        deflection=deflection_of(found.deflection) if found.deflection else None,
        fusion=_fusion(found.fusion, found.photos) if found.fusion else None,
        timing_s=timing_s,
        peak_memory_mb=peak_memory_mb,
        warnings=found.cautions,
    )


def _stations(registration: Registration) -> tuple[StationRow, ...]:
    rows = []
    for pose, ring, parent in zip(registration.poses, registration.ring, registration.parents, strict=True):
        covariance_mm2 = 1e6 * pose.covariance[3:, 3:]
        rows.append(
            StationRow(
                name=pose.name,
                position_m=place(pose.translation),
                rotation=pose.rotation,
                covariance_mm2=covariance_mm2,
                sigma_mm=_mean_sigma(covariance_mm2),
                sigma_xyz_mm=place(np.sqrt(np.diag(covariance_mm2))),
                sigma_arcsec=ARCSEC * _mean_sigma(pose.covariance[:3, :3]),
                ring=ring,
                parent=parent,
            )
        )
    return tuple(rows)


def _mean_sigma(covariance: ArrayLike) -> float:
    """Root of the mean of the variances."""
    return float(np.sqrt(np.mean(np.diag(np.asarray(covariance)))))


def _comparison(found: SteelRun) -> tuple[ComparisonRow, ...]:
    chained = {pose.name: pose for pose in found.chained.poses}
    icp = {pose.name: pose for pose in found.icp.poses} if found.icp else {}
    rows = []
    for link in found.chained.links:
        adjusted = found.registration.pose(link.station)
        icp_offset, icp_turn = _apart(adjusted, icp.get(link.station))
        rows.append(
            ComparisonRow(
                station=link.station,
                position=link.position,
                chained_m=_where(chained.get(link.station)),
                icp_m=_where(icp.get(link.station)),
                chained_offset_mm=link.offset_mm,
                icp_offset_mm=icp_offset,
                chained_turn_arcsec=link.turn_arcsec,
                icp_turn_arcsec=icp_turn,
                chained_sigma_mm=link.chained_sigma_mm,
                adjusted_sigma_mm=link.adjusted_sigma_mm,
            )
        )
    return tuple(rows)


def _where(pose: StationPose | None) -> Place | None:
    return None if pose is None else place(pose.translation)


def _apart(adjusted: StationPose, other: StationPose | None) -> tuple[float, float]:
    """Distance, mm, and angle, arc seconds, between two poses; NaN without the other."""
    if other is None:
        return math.nan, math.nan
    turn_deg = float(angle_between_deg(adjusted.rotation, other.rotation))
    return 1000 * float(np.linalg.norm(other.translation - adjusted.translation)), 3600 * turn_deg


def _column(column: Column) -> ColumnRow:
    east_mm, north_mm = column.tilt_mm.tolist()
    east_sigma_mm, north_sigma_mm = np.sqrt(np.diag(column.tilt_covariance)).tolist()
    return ColumnRow(
        name=column.name,
        bottom_m=place(column.bottom_m),
        top_m=place(column.top_m),
        radius_mm=column.diameter_mm / 2,
        north_mm=north_mm,
        east_mm=east_mm,
        north_sigma_mm=north_sigma_mm,
        east_sigma_mm=east_sigma_mm,
        deviation_mm=column.deviation_mm,
        sigma_mm=column.sigma_mm,
        direction_deg=column.azimuth_deg,
        height_m=column.height_mm / 1000,
        limit_mm=column.limit_mm,
        over_limit=column.over,
        certain=not _TWO_SIGMA < column.over_probability < 1 - _TWO_SIGMA,
        hidden_mm=column.hidden_mm,
    )


def _fusion(fusion: Fusion, photos: OrientedPhotos | None) -> FusionSummary:
    files = photos.files if photos else ()
    centres = fusion.placement.apply(photos.poses.centres) if photos else np.zeros((0, 3))
    return FusionSummary(
        scale=fusion.placement.scale,
        rotation=fusion.placement.rotation,
        translation_m=place(fusion.placement.translation),
        scale_sigma_percent=100 * math.sqrt(max(float(fusion.covariance[6, 6]), 0.0)),
        overlap_percent=100 * fusion.overlap,
        median_mm=fusion.median_mm,
        noise_mm=fusion.noise_mm,
        pairs=tuple((pair.name, float(np.linalg.norm(pair.residual_mm))) for pair in fusion.pairs),
        undetermined=tuple(way.words for way in fusion.directions if not way.determined),
        residuals_mm=fusion.residuals_mm,
        notes=fusion.notes,
        photos=tuple((file.name, place(centre)) for file, centre in zip(files, centres, strict=True)),
    )
