"""What the report of a steel survey tells, frozen and plain: the site frame, metres unless a name says mm.

Takes nothing, gives the records that ``collect`` fills and that page, tables and files read.  A figure that
is not known is NaN.  Residuals, gross errors, variance components and ICP pairs are those of
:mod:`pipeline.steel.registration_records`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from pipeline.core.vocabulary import Array
from pipeline.steel.registration_records import GrossError, IcpPair, Residual, VarianceComponent

Place = tuple[float, float, float]


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
class NodeRow:
    """A ball node: where the ball is, and where the axes of its rods meet.

    Attributes:
        name: of the node.
        ball_m: centre of the fitted ball.
        radius_mm: of the ball.
        rods_m: where the rods' axes meet, by least squares over all rods; NaN with fewer than two.
        by_perpendiculars_m: the same by common perpendiculars (equations 8 to 14).
        eccentricity_mm: ball less rods, site frame.
        size_mm, sigma_mm: its length and the standard deviation of it.
        significant: whether it cannot be noise.
        rods: names of the rods.
    """

    name: str
    ball_m: Place
    radius_mm: float
    rods_m: Place
    by_perpendiculars_m: Place
    eccentricity_mm: Place
    size_mm: float
    sigma_mm: float
    significant: bool
    rods: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class MemberRow:
    """A rod or column as fitted: its seen axis from ``start_m`` to ``end_m``."""

    name: str
    start_m: Place
    end_m: Place
    radius_mm: float
    radius_sigma_mm: float
    rms_mm: float
    points: int


@dataclass(frozen=True, kw_only=True)
class BallRow:
    """A ball as fitted; ``sigma_mm`` is the root of the mean of its centre's three variances."""

    name: str
    centre_m: Place
    radius_mm: float
    sigma_mm: float
    rms_mm: float
    points: int


@dataclass(frozen=True, kw_only=True)
class ColumnRow:
    """How a column leans, as a row of the paper's Table 1.

    Attributes:
        name: of the column.
        bottom_m, top_m: its axis at the heights it is judged between.
        radius_mm: of its surface.
        north_mm, east_mm: how far the top is off the bottom towards north and east.
        north_sigma_mm, east_sigma_mm: their standard deviations.
        deviation_mm, sigma_mm: length of the two together.
        direction_deg: azimuth towards which it leans, clockwise from north.
        height_m: height difference of top and bottom.
        limit_mm: what the deviation may be.
        over_limit: whether it is more.
        certain: whether limit and deviation are more than two sigma apart.
        hidden_mm: how much of the height was not seen and is extrapolated.
    """

    name: str
    bottom_m: Place
    top_m: Place
    radius_mm: float
    north_mm: float
    east_mm: float
    north_sigma_mm: float
    east_sigma_mm: float
    deviation_mm: float
    sigma_mm: float
    direction_deg: float
    height_m: float
    limit_mm: float
    over_limit: bool
    certain: bool
    hidden_mm: float = 0.0

    @property
    def ratio(self) -> float:
        """n of the ratio 1/n: height over deviation."""
        return 1000 * self.height_m / self.deviation_mm if self.deviation_mm > 0 else float("inf")


@dataclass(frozen=True, kw_only=True)
class DeflectionRow:
    """How far a node hangs below the plane of the supports; positive is down."""

    node: str
    position_m: Place
    deflection_mm: float
    sigma_mm: float
    support: bool


@dataclass(frozen=True, kw_only=True)
class DeflectionSummary:
    """The grid against its limit.

    Attributes:
        span_m: of the grid.
        limit_mm: span over the survey's divisor.
        largest_mm, largest_node, largest_sigma_mm: where it hangs most.
        over_limit: whether that is more than the limit.
        rows: one a node.
    """

    span_m: float
    limit_mm: float
    largest_mm: float
    largest_node: str
    largest_sigma_mm: float
    over_limit: bool
    rows: tuple[DeflectionRow, ...]


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
