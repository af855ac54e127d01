"""What the report of a steel survey tells, frozen and plain: the site frame, metres unless a name says mm.

Takes nothing, gives the records that ``collect`` fills and that page, tables and files read.  A figure that
is not known is NaN.  Residuals, gross errors, variance components and ICP pairs are those of
:mod:`pipeline.steel.registration_records`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from pipeline.core.vocabulary import Array
from pipeline.report.steel.structure_rows import (
    BallRow,
    ColumnRow,
    DeflectionSummary,
    MemberRow,
    NodeRow,
    Place,
)
from pipeline.steel.registration_records import GrossError, IcpPair, Residual, VarianceComponent


@dataclass(frozen=True, kw_only=True)
class StationRow:
    """A station in the site frame.

    Attributes:
        name: of the station.
        position_m: of the scanner's centre.
        rotation: (3, 3) site_from_station.
        covariance_mm2: (3, 3) of the position.
        sigma_mm: root of the mean of its three variances.
        sigma_xyz_mm: standard deviation of each coordinate.
        sigma_arcsec: of the attitude, likewise the root of the mean of three variances.
        ring: set-ups away from the base.
        parent: the station it was first placed from, "" for the base.
    """

    name: str
    position_m: Place
    rotation: Array
    covariance_mm2: Array
    sigma_mm: float
    sigma_xyz_mm: Place
    sigma_arcsec: float
    ring: int
    parent: str


@dataclass(frozen=True, kw_only=True)
class TargetRow:
    """A target or other feature: ``position_m`` its centre (or a point of it), sigma as for a station."""

    name: str
    kind: str
    position_m: Place
    sigma_mm: float
    seen_by: int


@dataclass(frozen=True, kw_only=True)
class ComparisonRow:
    """A station placed in other ways: NaN and None where a way did not place it.

    Attributes:
        station: its name.
        position: set-ups away from the base along the chain.
        chained_m, icp_m: its position station by station and by pairwise ICP.
        chained_offset_mm, icp_offset_mm: how far these lie off the adjusted position.
        chained_turn_arcsec, icp_turn_arcsec: angle to the adjusted attitude.
        chained_sigma_mm, adjusted_sigma_mm: predicted standard deviation of the position, root of the trace.
    """

    station: str
    position: int
    chained_m: Place | None
    icp_m: Place | None
    chained_offset_mm: float
    icp_offset_mm: float
    chained_turn_arcsec: float
    icp_turn_arcsec: float
    chained_sigma_mm: float
    adjusted_sigma_mm: float


@dataclass(frozen=True, kw_only=True)
class FusionSummary:
    """How the photo cloud lies in the site frame: x_site = scale * rotation @ x_photo + translation.

    Attributes:
        scale, rotation, translation_m: the seven parameters.
        scale_sigma_percent: standard deviation of the scale.
        overlap_percent: part of the photo's points that have a scanned surface beside them.
        median_mm, noise_mm: of the distances to it: median size, standard deviation of one.
        pairs: common places: name and size of the residual, mm.
        undetermined: ways in which nothing holds the photo cloud, in words.
        residuals_mm: (m,) the distances themselves.
        notes: sentences.
        photos: name of the picture and place of its camera, m, site frame; empty where not known.
    """

    scale: float
    rotation: Array
    translation_m: Place
    scale_sigma_percent: float
    overlap_percent: float
    median_mm: float
    noise_mm: float
    pairs: tuple[tuple[str, float], ...]
    undetermined: tuple[str, ...]
    residuals_mm: Array
    notes: tuple[str, ...]
    photos: tuple[tuple[str, Place], ...] = ()


@dataclass(frozen=True, kw_only=True)
class SteelReport:
    """Everything that the report shows.

    Attributes:
        name: of the structure.
        base: name of the base station; "" where control targets define the frame.
        north_deg: azimuth of north, clockwise from the site's +y.
        target_radius_mm: of the sphere targets, NaN where they were named by hand.
        stations, targets: in the site frame.
        gross, components, residuals, rounds: of the adjustment.
        comparison: the same stations by chaining and ICP; icp_pairs its single steps.
        rods, uprights, balls: fitted members, uprights being upright cylinders.
        nodes, columns, deflection: what is judged.
        timing_s, peak_memory_mb: of the run.
        warnings: sentences.
        fusion: of photos and scans; None without photos.
    """

    name: str
    base: str
    north_deg: float
    target_radius_mm: float
    stations: tuple[StationRow, ...]
    targets: tuple[TargetRow, ...]
    gross: tuple[GrossError, ...]
    components: tuple[VarianceComponent, ...]
    residuals: tuple[Residual, ...]
    rounds: int
    comparison: tuple[ComparisonRow, ...]
    icp_pairs: tuple[IcpPair, ...] = ()
    rods: tuple[MemberRow, ...] = ()
    uprights: tuple[MemberRow, ...] = ()
    balls: tuple[BallRow, ...] = ()
    nodes: tuple[NodeRow, ...] = ()
    columns: tuple[ColumnRow, ...] = ()
    deflection: DeflectionSummary | None = None
    fusion: FusionSummary | None = None
    timing_s: Mapping[str, float] = field(default_factory=dict)
    peak_memory_mb: float = float("nan")
    warnings: tuple[str, ...] = ()
