"""What one finished segment tells of the cable as a whole, small enough to be kept for all segments at once.

Takes the segment's report data and its placement; gives :class:`Told`, in the whole cable's places.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from pipeline.core.vocabulary import Array
from pipeline.report.relief_records import ReliefFeature
from pipeline.report.types import (
    AxisSummary,
    BlockSummary,
    DiameterProfile,
    MosaicSummary,
    ReportData,
    StationResult,
)
from pipeline.segments.traverse import Placement


@dataclass(frozen=True, kw_only=True)
class Told:
    """One segment's share of the report on the whole cable; places from the survey's first frame.

    Attributes:
        blocks: of the segment, frames shared with neighbours included.
        stations: those measured here.
        profile: between the hand-overs to the neighbours.
        axis: over all of the segment.
        rotation: (3, 3) from the frame of the adjusted cameras to that of the surface and the axis.
        features: of the relief, their middles there as well.
        relief_level_mm: what stands out exceeds this.
        mosaic: how the segment's blocks came together.
        warnings: as the segment's own report has them.
    """

    blocks: tuple[BlockSummary, ...]
    stations: tuple[StationResult, ...]
    profile: DiameterProfile
    axis: AxisSummary
    rotation: Array
    features: tuple[ReliefFeature, ...]
    relief_level_mm: float
    mosaic: MosaicSummary
    warnings: tuple[str, ...]


def told(data: ReportData, rotation: Array, placement: Placement, *, last: bool) -> Told:
    """Pick up what lies between the hand-overs, and move it to its place.

    Args:
        data: of the finished segment: with profile, axis, relief and mosaic.
        rotation: from the frame of its adjusted cameras to that of its surface.
        placement: where it lies.
        last: whether this is the survey's last segment.

    Raises:
        ValueError: the data lack one of these.
    """
    profile, axis, relief, mosaic = data.profile, data.axis, data.relief, data.mosaic
    if profile is None or axis is None or relief is None or mosaic is None:
        raise ValueError("a segment's report has profile, axis, relief and mosaic")
    start_m = placement.start_m
    along = profile.position_m + start_m
    here = np.array([placement.here(y, last) for y in along], dtype=bool)
    return Told(
        blocks=data.blocks,
        stations=tuple(_moved(s, placement) for s in data.stations),
        profile=DiameterProfile(
            position_m=along[here], diameter_mm=profile.diameter_mm[here], sigma_mm=profile.sigma_mm[here]
        ),
        axis=replace(axis, position_m=axis.position_m + start_m),
        rotation=rotation,
        features=tuple(
            replace(
                f,
                position_m=f.position_m + start_m,
                azimuth_deg=math.remainder(f.azimuth_deg + math.degrees(placement.roll), 360.0),
            )
            for f in relief.features
            if placement.here(f.position_m + start_m, last)
        ),
        relief_level_mm=relief.level_mm,
        mosaic=mosaic,
        warnings=data.warnings,
    )


def _moved(station: StationResult, placement: Placement) -> StationResult:
    """In the whole's places and azimuths."""
    cos, sin = math.cos(placement.roll), math.sin(placement.roll)
    turn = np.array([[cos, sin], [-sin, cos]])
    x_mm, z_mm = turn @ station.circle_centre_mm
    return replace(
        station,
        position_m=station.position_m + placement.start_m,
        section_mm=station.section_mm @ turn.T,
        circle_centre_mm=(float(x_mm), float(z_mm)),
    )
