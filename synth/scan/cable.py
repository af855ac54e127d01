"""A stay cable in the hall, met exactly: the cable's own surface and paint, as its videos are rendered with.

Takes the specification of a cable survey and where the cable stands; gives a :class:`CableRelief`, which the
panorama holds against rays like any other surface.  Leaves out the robot: the cable's frame is that of the
photo model (y along the axis, 0 at the first frame).
"""

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from pipeline.core.vocabulary import Array
from synth.scan.hits import Hit
from synth.scan.spec import ScanSpec
from synth.spec import Spec
from synth.spec_reader import read_spec
from synth.surface import axis_m, largest_radius_m, radius_m
from synth.texture import surface_texture

SAMPLES = 40  # along a ray inside the bounding tube: 3 mm apart on a cable of 110 mm
HALVINGS = 26  # of such a step: to less than a thousandth of a micrometre
TEXEL_MM = 1.0  # a beam is wider than that
TANGENT_M = 1e-4
SPARE_M = 0.001  # a ray enters the tube above the surface, never on it


@dataclass(frozen=True, kw_only=True)
class CableRelief:
    """The cable in a scene.

    Attributes:
        spec: of the cable's survey.
        owner: number of the thing in the world.
        rotation: (3, 3) scene_from_cable.
        origin: (3,) the cable frame's origin in the scene.
        paint: (rows, columns) grey albedo: rows from -margin on along the axis, columns from azimuth 0.
    """

    spec: Spec
    owner: int
    rotation: Array
    origin: Array
    paint: Array

    @property
    def ends_m(self) -> tuple[float, float]:
        """Where the cable begins and ends on its axis."""
        return -self.spec.cable.margin_m, self.spec.robot.travel_m + self.spec.cable.margin_m

    @property
    def tube_m(self) -> float:
        """Radius about the y axis that holds all of it."""
        bow_m = np.hypot(*axis_m(self.spec.cable, self.spec.robot.travel_m, np.array(self.ends_m)))
        widest_m = largest_radius_m(self.spec.cable) + SPARE_M
        return widest_m + max(float(bow_m.max()), self.spec.cable.bow_mm / 1000.0)

    def seen_from(self, rotation: Array, centre: Array) -> "CableRelief":
        """The same in the frame of a station with this scene_from_station rotation and centre."""
        return replace(self, rotation=rotation.T @ self.rotation, origin=(self.origin - centre) @ rotation)

    def hit(self, directions: Array) -> Hit:
        """Where rays from the scene's origin meet the surface; as the functions of :mod:`synth.scan.hits`."""
        shape = directions.shape[:-1]
        along = directions.reshape(-1, 3) @ self.rotation
        start = -self.origin @ self.rotation
        range_m, inside, cosine = (np.full(len(along), value) for value in (np.inf, -np.inf, 0.0))
        across2 = np.maximum(along[:, 0] ** 2 + along[:, 2] ** 2, 1e-300)
        near = -(start[0] * along[:, 0] + start[2] * along[:, 2]) / across2
        off2 = (start[0] + near * along[:, 0]) ** 2 + (start[2] + near * along[:, 2]) ** 2
        rays = np.flatnonzero((near > 0.0) & (off2 < self.tube_m**2))
        if rays.size:
            half = np.sqrt((self.tube_m**2 - off2[rays]) / across2[rays])
            met = self._first(start, along[rays], near[rays], half)
            range_m[rays], inside[rays], cosine[rays] = met
        return Hit(range_m.reshape(shape), inside.reshape(shape), cosine.reshape(shape))

    def _first(self, start: Array, along: Array, near: Array, half: Array) -> tuple[Array, Array, Array]:
        """First change of sign of the height over the surface along each ray, by halving."""
        share = np.linspace(-1.0, 1.0, SAMPLES)
        heights = np.stack([self._height(start + (near + s * half)[:, None] * along) for s in share], axis=1)
        inside = -heights.min(axis=1)
        under = heights <= 0.0
        first = np.argmax(under, axis=1)
        met = under.any(axis=1) & (first > 0)
        step = 2.0 / (SAMPLES - 1) * half
        low = near - half + (first - 1) * step
        high = low + step
        for _ in range(HALVINGS):
            middle = (low + high) / 2.0
            over = self._height(start + middle[:, None] * along) > 0.0
            low, high = np.where(over, middle, low), np.where(over, high, middle)
        falling = self._height(start + (low - TANGENT_M)[:, None] * along) / TANGENT_M
        y = start[1] + low * along[:, 1]
        met &= (y >= self.ends_m[0]) & (y <= self.ends_m[1])
        on_it = (y >= self.ends_m[0] - 0.05) & (y <= self.ends_m[1] + 0.05)
        return (
            np.where(met, low, np.inf),
            np.where(on_it, inside, -np.inf),
            np.clip(falling, 0.0, 1.0),
        )

    def _height(self, points: Array) -> Array:
        """Distance from the local axis less the radius, of points in the cable's frame."""
        x, z = axis_m(self.spec.cable, self.spec.robot.travel_m, points[:, 1])
        off_x, off_z = points[:, 0] - x, points[:, 2] - z
        return np.asarray(
            np.hypot(off_x, off_z) - radius_m(self.spec.cable, np.arctan2(-off_z, off_x), points[:, 1])
        )

    def albedo(self, points: Array) -> Array:
        """(n,) grey of the paint at points (n, 3) of the scene."""
        inside = (points - self.origin) @ self.rotation
        x, z = axis_m(self.spec.cable, self.spec.robot.travel_m, inside[:, 1])
        turn = np.arctan2(-(inside[:, 2] - z), inside[:, 0] - x) / (2.0 * math.pi) % 1.0
        rows, columns = self.paint.shape
        row = (inside[:, 1] - self.ends_m[0]) / (self.ends_m[1] - self.ends_m[0]) * rows
        column = (turn * columns).astype(int) % columns
        return np.asarray(self.paint[np.clip(row.astype(int), 0, rows - 1), column], float)


def read_cable(spec: ScanSpec) -> Spec | None:
    """The specification of the cable in the hall, if one stands there; raises StageError as its reader."""
    return None if spec.cable is None else read_spec(Path(spec.cable.spec))


def stand_cable(spec: ScanSpec, shape: Spec) -> tuple[Array, Array]:
    """hall_from_cable: rotation (3, 3), and the cable frame's origin (3,) in the hall.

    The middle of the travel comes to ``cable.at_m``; +y climbs.
    """
    place = spec.cable
    if place is None:
        return np.eye(3), np.zeros(3)
    azimuth, rise, turn = (
        math.radians(v) for v in (place.azimuth_deg, place.inclination_deg, place.turn_deg)
    )
    y = np.array([math.cos(rise) * math.sin(azimuth), math.cos(rise) * math.cos(azimuth), math.sin(rise)])
    level = np.array([math.cos(azimuth), -math.sin(azimuth), 0.0])
    up = np.cross(level, y)
    x = math.cos(turn) * level + math.sin(turn) * up
    rotation = np.stack([x, y, np.cross(x, y)], axis=1)
    return rotation, np.array(place.at_m) - rotation[:, 1] * shape.robot.travel_m / 2.0


def cable_relief(spec: ScanSpec, shape: Spec, owner: int) -> CableRelief:
    """The cable in the hall's frame, painted as in its videos but for what a beam cannot see."""
    rotation, origin = stand_cable(spec, shape)
    return CableRelief(spec=shape, owner=owner, rotation=rotation, origin=origin, paint=_paint(shape))


@lru_cache(maxsize=1)  # painting takes seconds, and all stations see the same
def _paint(shape: Spec) -> Array:
    """Mean albedo of cells of about a millimetre."""
    albedo = surface_texture(shape.cable, shape.robot, shape.seed)[..., :3].mean(axis=-1)
    step = max(1, round(TEXEL_MM / shape.cable.material.texel_mm))
    # whole texels, but all of them: a remainder left out would stretch the paint around the cable
    edges = [np.rint(np.linspace(0, size, max(size // step, 1) + 1)).astype(int) for size in albedo.shape]
    sums = np.add.reduceat(np.add.reduceat(albedo, edges[0][:-1], axis=0), edges[1][:-1], axis=1)
    return np.asarray(sums / np.outer(np.diff(edges[0]), np.diff(edges[1])), dtype=np.float64)
