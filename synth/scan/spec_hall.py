"""What stands in the hall: the frame, the room, the targets.  The records of :mod:`synth.scan.spec`."""

from dataclasses import dataclass, field


@dataclass(frozen=True, kw_only=True)
class Eccentric:
    """One ball that is not where its rods' axes meet.

    Attributes:
        node: name, B2-3 (bottom) or T1-1 (top), numbers from 1 along x and y.
        offset_mm: ball minus meeting point, in the hall's frame.
    """

    node: str
    offset_mm: tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class Structure:
    """A space frame of square pyramids on columns.

    Attributes:
        built: false leaves it out; the floor is as large as it would be.
        bays: squares along x and y.
        module_m: side of a square.
        depth_m: top chord's nodes over the bottom chord's.
        height_m: bottom chord's nodes over the floor, without sag.
        chord_diameter_mm, diagonal_diameter_mm: of the rods.
        ball_diameter_mm, column_diameter_mm: of nodes and columns.
        sag_mm: in the middle; a half sine in both directions, zero along the edge.
        span_m: for the limit of the deflection; None is the shorter side.
        eccentric: balls displaced as stated.
        eccentric_share: of the other nodes, drawn by the seed, displaced by ``eccentric_mm`` in a seeded
            direction.
        column_step: a column under every so many nodes of the edge, walked round from the origin; 0: under
            the four corners.
        column_at: (i, j) of the bottom nodes that carry the columns instead, numbers from 1.
        tilt_mm: least and largest deviation of a column's top from its bottom, drawn by the seed.
        tilt_limit_mm, tilt_over: so many columns deviate by more than this limit; None leaves it to chance.
        tilt_clear_mm: no column is so near the limit.
        judged_margin_m: a column's deviation is judged between this over the floor and this under its top.
    """

    built: bool = True
    bays: tuple[int, int] = field(default=(2, 2), metadata={"minimum": 1})
    module_m: float = field(default=3.0, metadata={"above": 0.0})
    depth_m: float = field(default=2.1, metadata={"above": 0.0})
    height_m: float = field(default=5.0, metadata={"above": 0.5})
    chord_diameter_mm: float = field(default=89.0, metadata={"above": 0.0})
    diagonal_diameter_mm: float = field(default=60.0, metadata={"above": 0.0})
    ball_diameter_mm: float = field(default=200.0, metadata={"above": 0.0})
    column_diameter_mm: float = field(default=300.0, metadata={"above": 0.0})
    sag_mm: float = 0.0
    span_m: float | None = field(default=None, metadata={"above": 0.0})
    eccentric: tuple[Eccentric, ...] = ()
    eccentric_share: float = field(default=0.0, metadata={"minimum": 0.0, "maximum": 1.0})
    eccentric_mm: float = field(default=10.0, metadata={"minimum": 0.0})
    column_step: int = field(default=0, metadata={"minimum": 0})
    column_at: tuple[tuple[int, int], ...] = ()
    tilt_mm: tuple[float, float] = field(default=(0.0, 0.0), metadata={"minimum": 0.0})
    tilt_limit_mm: float = field(default=35.0, metadata={"above": 0.0})
    tilt_over: int | None = field(default=None, metadata={"minimum": 0})
    tilt_clear_mm: float = field(default=2.0, metadata={"minimum": 0.0})
    judged_margin_m: float = field(default=0.25, metadata={"minimum": 0.0})


@dataclass(frozen=True, kw_only=True)
class Box:
    """A box on the floor that hides what is behind it.

    Attributes:
        at_m: (x, y) of its middle.
        size_m: along its own x, y and z.
        turn_deg: about the vertical, counterclockwise.
    """

    at_m: tuple[float, float]
    size_m: tuple[float, float, float] = field(default=(1.0, 1.0, 1.0), metadata={"above": 0.0})
    turn_deg: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Room:
    """What else the rays meet.

    Attributes:
        margin_m: floor beyond the frame's edge; the walls stand at its end.
        wall_height_m: of the four walls; 0 builds none.
        box: boxes.
    """

    margin_m: float = field(default=4.0, metadata={"minimum": 0.0})
    wall_height_m: float = field(default=0.0, metadata={"minimum": 0.0})
    box: tuple[Box, ...] = ()


@dataclass(frozen=True, kw_only=True)
class CablePlace:
    """A stay cable that stands in the hall.

    Attributes:
        spec: file of the cable survey's specification, relative to this one's.
        at_m: middle of the robot's travel.
        azimuth_deg: direction in which +y, the robot's travel, goes; from north to east.
        inclination_deg: how steep it climbs.
        turn_deg: of the cable about its axis; at 0 its x is level.
    """

    spec: str
    at_m: tuple[float, float, float] = (1.5, 1.5, 1.5)
    azimuth_deg: float = 0.0
    inclination_deg: float = field(default=45.0, metadata={"minimum": -90.0, "maximum": 90.0})
    turn_deg: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Targets:
    """White spheres, on stands and held to columns by magnets; named T01 and on.

    Attributes:
        radius_mm: of the spheres.
        stands: on a grid of so many along x and y over the hall's floor.
        at_m: further ones, stated.
        on_columns: so many more, at seeded columns, sides and heights.
        jitter_m: each stand is within so much of its place.
        heights_m: lowest and highest centre over the floor, drawn by the seed.
        nearest: a station's list names at most so many, the nearest.
        range_m: and none farther than this.
        least: fewer in one station's list are refused.
    """

    radius_mm: float = field(default=72.5, metadata={"above": 0.0})
    stands: tuple[int, int] = field(default=(3, 3), metadata={"minimum": 0})
    at_m: tuple[tuple[float, float, float], ...] = ()
    on_columns: int = field(default=0, metadata={"minimum": 0})
    jitter_m: float = field(default=0.8, metadata={"minimum": 0.0})
    heights_m: tuple[float, float] = field(default=(0.6, 2.6), metadata={"above": 0.1})
    nearest: int = field(default=10, metadata={"minimum": 1})
    range_m: float = field(default=25.0, metadata={"above": 0.0})
    least: int = field(default=4, metadata={"minimum": 0})
