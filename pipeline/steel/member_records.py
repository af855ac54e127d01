"""What is found in the registered cloud: rods, columns, ball nodes, each with its covariance."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.core.vocabulary import Array
from pipeline.steel.records import Feature, FeatureKind, StationPose
from pipeline.steel.vectors import lengths


@dataclass(frozen=True, kw_only=True)
class NominalSizes:
    """Diameters as drawn; they narrow the search and never enter a result.

    Attributes:
        rods_mm, balls_mm, columns_mm: diameters; empty where nothing is known.
    """

    rods_mm: tuple[float, ...] = ()
    balls_mm: tuple[float, ...] = ()
    columns_mm: tuple[float, ...] = ()


@dataclass(frozen=True, kw_only=True)
class MemberOptions:
    """How members are searched and fitted.

    Attributes:
        range_sigma_mm: noise of one point along its ray.
        angle_sigma_arcsec: noise of the ray's direction, each way.
        range_bias_mm: standard deviation of an error of the range common to all points of a station.
        search_spacing_m: the search looks at about one point in a cube of this size.
        reach_m: neighbourhood whose normals tell a cylinder from a plane.
        least_diameter_mm, largest_diameter_mm: of any cylinder, where no sizes are given.
        least_length_m: shorter cylinders are no members.
        gap_m: a member may be hidden over this length.
        nominal_share: a diameter may differ from the nominal one by this share.
        rim_deg: rays that meet the surface more obliquely than this are left out: they see the edge as well.
        column_tilt_deg: a column leans less than this.
        least_column_m: a column is at least this long.
    """

    range_sigma_mm: float = field(default=2.0, metadata={"above": 0.0})
    angle_sigma_arcsec: float = field(default=8.0, metadata={"minimum": 0.0})
    range_bias_mm: float = field(default=0.0, metadata={"minimum": 0.0})
    search_spacing_m: float = field(default=0.010, metadata={"minimum": 0.002, "maximum": 0.05})
    reach_m: float = field(default=0.12, metadata={"minimum": 0.03, "maximum": 0.5})
    least_diameter_mm: float = field(default=30.0, metadata={"above": 0.0})
    largest_diameter_mm: float = field(default=900.0, metadata={"above": 0.0})
    least_length_m: float = field(default=0.5, metadata={"above": 0.0})
    gap_m: float = field(default=0.6, metadata={"minimum": 0.0})
    nominal_share: float = field(default=0.2, metadata={"above": 0.0, "maximum": 1.0})
    rim_deg: float = field(default=65.0, metadata={"minimum": 30.0, "maximum": 90.0})
    column_tilt_deg: float = field(default=4.0, metadata={"above": 0.0, "maximum": 45.0})
    least_column_m: float = field(default=1.5, metadata={"above": 0.0})


@dataclass(frozen=True, kw_only=True)
class StationShare:
    """How a fit follows the errors of the stations it rests on.

    A station whose pose is off by d (rotation vector on the left, translation) and whose ranges are off by b
    moves the fit's parameters by ``gains @ (d, b)``.

    Attributes:
        stations: (k,) int64, numbers of the stations.
        gains: (k, p, 7).
    """

    stations: NDArray[np.int64]
    gains: Array


@dataclass(frozen=True, kw_only=True)
class Rod:
    """A straight cylinder: a rod of the grid or a column.

    Attributes:
        name: "R001", "C01", ...
        place: (3,) metres, site frame: the axis next to the points' centroid.
        direction: (3,) unit vector.
        frame: (3, 3) rows u, v, direction.
        radius_m: of the surface.
        first_m, last_m: where the seen surface begins and ends, along the direction from ``place``.
        noise_covariance: (5, 5) of (offset along u, along v, slope towards u, towards v, radius), from the
            points' noise alone.
        share: how the same five follow their stations.
        covariance: (5, 5), both together.
        points: how many points were fitted.
        rms_m: of their distances from the surface.
        arc_deg: how much of the circumference was seen.
    """

    name: str
    place: Array
    direction: Array
    frame: Array
    radius_m: float
    first_m: float
    last_m: float
    noise_covariance: Array
    share: StationShare
    covariance: Array
    points: int
    rms_m: float
    arc_deg: float

    @property
    def start(self) -> Array:
        """(3,) first seen point of the axis."""
        return self.place + self.first_m * self.direction

    @property
    def end(self) -> Array:
        """(3,) last seen point of the axis."""
        return self.place + self.last_m * self.direction

    @property
    def length_m(self) -> float:
        """Length of the seen surface."""
        return self.last_m - self.first_m

    def along(self, points: ArrayLike) -> Array:
        """Distances (n,) of points (n, 3) along the axis from ``place``."""
        return (np.asarray(points, dtype=float) - self.place) @ self.direction

    def apart(self, points: ArrayLike) -> Array:
        """Distances (n,) of points (n, 3) from the axis, which is taken to go on for ever."""
        away = np.asarray(points, dtype=float) - self.place
        return lengths(away - (away @ self.direction)[..., None] * self.direction)


@dataclass(frozen=True, kw_only=True)
class Ball:
    """A ball node.

    Attributes:
        name: "N001", ...
        centre: (3,) metres, site frame.
        radius_m: of the surface.
        noise_covariance: (4, 4) of (x, y, z, radius), from the points' noise alone.
        share: how the same four follow their stations.
        covariance: (4, 4), both together.
        rods: names of the rods that end here.
        column: name of the column below, or "".
        points: how many points were fitted.
        rms_m: of their distances from the surface.
    """

    name: str
    centre: Array
    radius_m: float
    noise_covariance: Array
    share: StationShare
    covariance: Array
    rods: tuple[str, ...]
    column: str
    points: int
    rms_m: float


@dataclass(frozen=True, kw_only=True)
class Joint:
    """A place where rods meet, but no ball was seen (it hides on a column's head, or among the rods).

    Attributes:
        name: "J01", ...
        place: (3,) roughly, metres, site frame.
        rods: names of the rods that end here.
        column: name of the column below, or "".
    """

    name: str
    place: Array
    rods: tuple[str, ...]
    column: str


@dataclass(frozen=True, kw_only=True)
class Members:
    """All members.

    Attributes:
        stations: the poses that the members rest on; shares count in this order.
        range_bias_m: standard deviation of a range error common to a station's points.
        rods: of the grid.
        columns: upright cylinders.
        balls: ball nodes.
        joints: nodes whose ball was not seen.
    """

    stations: tuple[StationPose, ...]
    range_bias_m: float
    rods: tuple[Rod, ...]
    columns: tuple[Rod, ...]
    balls: tuple[Ball, ...]
    joints: tuple[Joint, ...] = ()

    def rod(self, name: str) -> Rod:
        """A rod or column by its name."""
        return next(rod for rod in (*self.rods, *self.columns) if rod.name == name)


def ball_features(members: Members | None) -> tuple[Feature, ...]:
    """The ball nodes as point features, site frame; none without members."""
    balls = () if members is None else members.balls
    return tuple(
        Feature(
            kind=FeatureKind.POINT,
            name=ball.name,
            place=ball.centre,
            direction=np.zeros(3),
            frame=np.eye(3),
            covariance=ball.covariance[:3, :3],
            radius_m=ball.radius_m,
            points=ball.points,
            rms_m=ball.rms_m,
        )
        for ball in balls
    )
