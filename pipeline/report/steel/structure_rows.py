"""Rows of the report about the structure: members, nodes, columns, deflection; site frame, units in names.

A figure that is not known is NaN.
"""

from dataclasses import dataclass

Place = tuple[float, float, float]


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
