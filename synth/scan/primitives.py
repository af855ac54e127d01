"""The world as exact surfaces: spheres, cylinders, rectangles, discs, each owned by a named thing.

Takes frame, layout and room; gives :class:`World` in the hall's frame and moves it into a station's.  Leaves
out rays (:mod:`synth.scan.hits`).
"""

import math
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pipeline.core.vocabulary import Array
from synth.scan.cable import cable_relief, read_cable
from synth.scan.frame import Frame, plan_m
from synth.scan.hits import Hit
from synth.scan.layout import Layout, Target
from synth.scan.spec import Box, ScanSpec

Indices = NDArray[np.int64]

STAND_RADIUS_M = 0.012
STEEL, WHITE, CONCRETE, WALL, PLASTIC = 0.45, 0.9, 0.35, 0.6, 0.2
SUNK_M = 0.05  # a column goes on below the floor: its foot is no edge


class Relief(Protocol):
    """A tube-like surface of its own shape, about an axis."""

    @property
    def owner(self) -> int:
        """Index into the world's names."""

    @property
    def rotation(self) -> Array:
        """(3, 3) scene_from_relief; its y is the axis."""

    @property
    def origin(self) -> Array:
        """(3,) in the scene."""

    @property
    def ends_m(self) -> tuple[float, float]:
        """Where it begins and ends on its axis."""

    @property
    def tube_m(self) -> float:
        """Radius about the axis that holds all of it."""

    def seen_from(self, rotation: Array, centre: Array) -> "Relief":
        """The same in a station's frame."""

    def hit(self, directions: Array) -> Hit:
        """Where rays from the origin meet it."""

    def albedo(self, points: Array) -> Array:
        """(n,) reflectance at points of the scene."""


@dataclass(frozen=True, kw_only=True)
class World:
    """Surfaces; ``*_owner`` index into ``names`` and ``reflectance``.

    Attributes:
        sphere: (n, 4) centre and radius.
        cylinder: (n, 7) start, end and radius of the lateral surface.
        rectangle: (n, 9) corner and the two edges from it.
        disc: (n, 7) centre, unit normal and radius.
        names: of the owners: ball:B1-1, rod:..., column:..., target:..., stand:..., floor, wall:..., box:...
        reflectance: 0..1 of the owners.
        relief: surfaces that are no quadric: they know themselves where rays meet them.
    """

    sphere: Array
    cylinder: Array
    rectangle: Array
    disc: Array
    sphere_owner: Indices
    cylinder_owner: Indices
    rectangle_owner: Indices
    disc_owner: Indices
    names: tuple[str, ...]
    reflectance: Array
    relief: tuple["Relief", ...] = ()

    @property
    def relief_owner(self) -> Indices:
        """Owners of the reliefs."""
        return np.array([relief.owner for relief in self.relief], np.int64)

    def seen_from(self, rotation: Array, centre: Array) -> "World":
        """The same world in the frame of a station with this hall_from_station rotation and centre."""

        def point(p: Array) -> Array:
            return (p - centre) @ rotation

        return World(
            sphere=np.column_stack([point(self.sphere[:, :3]), self.sphere[:, 3]]),
            cylinder=np.column_stack(
                [point(self.cylinder[:, :3]), point(self.cylinder[:, 3:6]), self.cylinder[:, 6]]
            ),
            rectangle=np.column_stack(
                [
                    point(self.rectangle[:, :3]),
                    self.rectangle[:, 3:6] @ rotation,
                    self.rectangle[:, 6:] @ rotation,
                ]
            ),
            disc=np.column_stack([point(self.disc[:, :3]), self.disc[:, 3:6] @ rotation, self.disc[:, 6]]),
            sphere_owner=self.sphere_owner,
            cylinder_owner=self.cylinder_owner,
            rectangle_owner=self.rectangle_owner,
            disc_owner=self.disc_owner,
            names=self.names,
            reflectance=self.reflectance,
            relief=tuple(relief.seen_from(rotation, centre) for relief in self.relief),
        )


class Builder:
    """Collects surfaces, then gives the :class:`World`."""

    def __init__(self) -> None:
        self._rows: dict[str, list[list[float]]] = {"sphere": [], "cylinder": [], "rectangle": [], "disc": []}
        self._owners: dict[str, list[int]] = {kind: [] for kind in self._rows}
        self._names: list[str] = []
        self._reflectance: list[float] = []

    def own(self, name: str, reflectance: float) -> int:
        """Name the thing that owns what is added under the number returned."""
        self._names.append(name)
        self._reflectance.append(reflectance)
        return len(self._names) - 1

    def add(self, kind: str, owner: int, *values: Array | float) -> None:
        """Add one surface; the values are those of :class:`World`."""
        self._rows[kind].append([float(v) for value in values for v in np.atleast_1d(value)])
        self._owners[kind].append(owner)

    def world(self) -> World:
        """All that was added."""
        widths = {"sphere": 4, "cylinder": 7, "rectangle": 9, "disc": 7}
        rows = {kind: np.array(self._rows[kind], float).reshape(-1, width) for kind, width in widths.items()}
        owners = {kind: np.array(self._owners[kind], np.int64) for kind in widths}
        return World(
            sphere=rows["sphere"],
            cylinder=rows["cylinder"],
            rectangle=rows["rectangle"],
            disc=rows["disc"],
            sphere_owner=owners["sphere"],
            cylinder_owner=owners["cylinder"],
            rectangle_owner=owners["rectangle"],
            disc_owner=owners["disc"],
            names=tuple(self._names),
            reflectance=np.array(self._reflectance),
        )


def build_world(spec: ScanSpec, frame: Frame, layout: Layout, station: int) -> World:
    """Everything that the station of this number (from 0) can hit, in the hall's frame."""
    builder = Builder()
    _add_structure(builder, frame)
    for target in layout.targets:
        _add_target(builder, layout.target_at(target, station), spec.targets.radius_mm / 1000.0)
    _add_room(builder, spec)
    shape = read_cable(spec)
    if shape is None:
        return builder.world()
    owner = builder.own("cable", 1.0)
    return replace(builder.world(), relief=(cable_relief(spec, shape, owner),))


def build_occluders(spec: ScanSpec, frame: Frame) -> World:
    """Only what hides targets from stations: columns, walls, boxes."""
    builder = Builder()
    _add_columns(builder, frame)
    _add_room(builder, spec)
    return builder.world()


def _add_structure(builder: Builder, frame: Frame) -> None:
    for node in frame.nodes:
        builder.add("sphere", builder.own(f"ball:{node.name}", STEEL), node.ball, frame.ball_radius_m)
    for rod in frame.rods:
        along = (rod.end - rod.start) / np.linalg.norm(rod.end - rod.start)
        start, end = rod.start - rod.inside_m[0] * along, rod.end + rod.inside_m[1] * along
        builder.add("cylinder", builder.own(f"rod:{rod.name}", STEEL), start, end, rod.radius_m)
    _add_columns(builder, frame)


def _add_columns(builder: Builder, frame: Frame) -> None:
    for column in frame.columns:
        owner = builder.own(f"column:{column.name}", STEEL)
        axis = (column.head - column.foot) / np.linalg.norm(column.head - column.foot)
        builder.add("cylinder", owner, column.foot - SUNK_M * axis, column.head, column.radius_m)
        builder.add("disc", owner, column.head, axis, column.radius_m)


def _add_target(builder: Builder, target: Target, radius_m: float) -> None:
    builder.add("sphere", builder.own(f"target:{target.name}", WHITE), target.centre, radius_m)
    owner = builder.own(f"stand:{target.name}", PLASTIC)
    foot = np.array([*target.centre[:2], 0.0]) if target.column is None else target.column
    builder.add("cylinder", owner, foot, target.centre, STAND_RADIUS_M)


def _add_room(builder: Builder, spec: ScanSpec) -> None:
    low, high = -np.full(2, spec.room.margin_m), plan_m(spec.structure) + spec.room.margin_m
    corner, size = np.array([*low, 0.0]), high - low
    east, north, up = np.array([size[0], 0.0, 0.0]), np.array([0.0, size[1], 0.0]), np.array([0.0, 0.0, 1.0])
    builder.add("rectangle", builder.own("floor", CONCRETE), corner, east, north)
    if spec.room.wall_height_m > 0.0:
        rise = spec.room.wall_height_m * up
        walls = {"west": (corner, north), "east": (corner + east, north), "south": (corner, east)}
        walls["north"] = (corner + north, east)
        for name, (start, along) in walls.items():
            builder.add("rectangle", builder.own(f"wall:{name}", WALL), start, along, rise)
    for number, box in enumerate(spec.room.box, start=1):
        _add_box(builder, builder.own(f"box:{number}", WALL), box)


def _add_box(builder: Builder, owner: int, box: Box) -> None:
    """Four sides and the lid."""
    turn = math.radians(box.turn_deg)
    x = box.size_m[0] * np.array([math.cos(turn), math.sin(turn), 0.0])
    y = box.size_m[1] * np.array([-math.sin(turn), math.cos(turn), 0.0])
    z = np.array([0.0, 0.0, box.size_m[2]])
    corner = np.array([*box.at_m, 0.0]) - (x + y) / 2.0
    for start, u, v in (
        (corner, x, z),
        (corner, y, z),
        (corner + x, y, z),
        (corner + y, x, z),
        (corner + z, x, y),
    ):
        builder.add("rectangle", owner, start, u, v)
