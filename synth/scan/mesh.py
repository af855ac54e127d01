"""The world as triangles and quads, for Blender: photos, and a second opinion on what a ray meets.

Takes a :class:`~synth.scan.primitives.World`; gives vertices, faces, their owners and texture coordinates in
metres.  The vertices lie on the exact surfaces, so the polygons cut a little inside of them.  No bpy here.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.core.vocabulary import Array
from synth.scan.primitives import World

SIDES = 48


@dataclass(frozen=True, kw_only=True)
class Mesh:
    """Quads: ``vertices`` (n, 3), ``quads`` (m, 4), ``owner`` (m,), ``uv`` (m, 4, 2) metres."""

    vertices: Array
    quads: NDArray[np.int64]
    owner: NDArray[np.int64]
    uv: Array


def mesh_of(world: World, sides: int = SIDES) -> Mesh:
    """All surfaces of a world, each cut into a grid of quads with this many around its axis."""
    patches = [
        (_sphere(row, sides), owner) for row, owner in zip(world.sphere, world.sphere_owner, strict=True)
    ]
    pairs = zip(world.cylinder, world.cylinder_owner, strict=True)
    patches += [(_cylinder(row, sides), owner) for row, owner in pairs]
    pairs = zip(world.rectangle, world.rectangle_owner, strict=True)
    patches += [(_rectangle(row), owner) for row, owner in pairs]
    patches += [(_disc(row, sides), owner) for row, owner in zip(world.disc, world.disc_owner, strict=True)]
    vertices, quads, owners, uvs = [], [], [], []
    first = 0
    for (points, uv), owner in patches:
        corners = _grid_quads(*points.shape[:2])
        vertices.append(points.reshape(-1, 3))
        quads.append(corners + first)
        owners.append(np.full(len(corners), owner))
        uvs.append(uv.reshape(-1, 2)[corners])
        first += len(vertices[-1])
    return Mesh(
        vertices=np.concatenate(vertices),
        quads=np.concatenate(quads),
        owner=np.concatenate(owners),
        uv=np.concatenate(uvs),
    )


def _grid_quads(rows: int, columns: int) -> NDArray[np.int64]:
    corner = np.arange((rows - 1) * columns).reshape(rows - 1, columns)[:, :-1].ravel()
    return np.stack([corner, corner + 1, corner + columns + 1, corner + columns], axis=1)


def _across(axis: Array) -> tuple[Array, Array]:
    """Two unit vectors that make a right-handed frame with a unit axis."""
    helper = np.eye(3)[int(np.argmin(np.abs(axis)))]
    u = np.cross(helper, axis)
    u /= np.linalg.norm(u)
    return u, np.cross(axis, u)


def _sphere(row: Array, sides: int) -> tuple[Array, Array]:
    turn, rise = (
        np.linspace(0.0, 2.0 * math.pi, sides + 1),
        np.linspace(-math.pi / 2, math.pi / 2, sides // 2 + 1),
    )
    t, e = np.meshgrid(turn, rise)
    unit = np.stack([np.cos(e) * np.cos(t), np.cos(e) * np.sin(t), np.sin(e)], axis=-1)
    return row[:3] + row[3] * unit, row[3] * np.stack([t, e], axis=-1)


def _cylinder(row: Array, sides: int) -> tuple[Array, Array]:
    length = float(np.linalg.norm(row[3:6] - row[:3]))
    axis = (row[3:6] - row[:3]) / length
    u, v = _across(axis)
    t, s = np.meshgrid(np.linspace(0.0, 2.0 * math.pi, sides + 1), [0.0, length])
    round_ = np.cos(t)[..., None] * u + np.sin(t)[..., None] * v
    return row[:3] + s[..., None] * axis + row[6] * round_, np.stack([row[6] * t, s], axis=-1)


def _rectangle(row: Array) -> tuple[Array, Array]:
    a, b = np.meshgrid([0.0, 1.0], [0.0, 1.0])
    size = np.array([np.linalg.norm(row[3:6]), np.linalg.norm(row[6:])])
    return row[:3] + a[..., None] * row[3:6] + b[..., None] * row[6:], np.stack([a, b], axis=-1) * size


def _disc(row: Array, sides: int) -> tuple[Array, Array]:
    u, v = _across(row[3:6])
    t, r = np.meshgrid(np.linspace(0.0, 2.0 * math.pi, sides + 1), [row[6], 0.0])
    flat = np.stack([r * np.cos(t), r * np.sin(t)], axis=-1)
    return row[:3] + flat[..., :1] * u + flat[..., 1:] * v, flat
