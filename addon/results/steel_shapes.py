"""Tubes, balls and arrows of a steel structure: each kind is one mesh of size one, stretched by its objects.

A hall of thousands of rods so stays light.  The colour belongs to the object and not to the shared mesh.
"""

import math
from collections.abc import Callable, Sequence

import bmesh
import bpy
import numpy as np
from mathutils import Matrix, Quaternion, Vector

from .materials import plain_material
from .steel_points import linear

STEEL, GOOD, UNSURE, BAD, UNKNOWN = (
    *(linear(154, 167, 178), linear(0, 158, 115), linear(230, 159, 0)),
    *(linear(213, 94, 0), linear(86, 180, 233)),
)
"""The colours of the report (pipeline/report/steel/colours.py)."""

HEAD_SHARE, SHAFT, HEAD = 0.25, 0.02, 0.055
"""An arrow's head by its length; radii of shaft and head by the arrow's length."""

type Colour = tuple[float, float, float, float]


def tube_object(
    name: str, start: Sequence[float], end: Sequence[float], radius_m: float, colour: Colour
) -> bpy.types.Object:
    """A closed tube between two places, in no collection yet; ``name`` is the thing's own."""
    a, b = Vector(start), Vector(end)
    made = _object(name, _shared("tube", _tube), colour)
    size = Vector((radius_m, radius_m, (b - a).length))
    made.matrix_world = Matrix.LocRotScale(a, _turn(b - a), size)
    return made


def ball_object(name: str, centre: Sequence[float], radius_m: float, colour: Colour) -> bpy.types.Object:
    """A ball, in no collection yet."""
    made = _object(name, _shared("ball", _ball), colour)
    made.matrix_world = Matrix.LocRotScale(Vector(centre), None, (radius_m,) * 3)
    return made


def ellipsoid_object(
    name: str, centre: Sequence[float], axes: Matrix, half_axes_m: Sequence[float], colour: Colour
) -> bpy.types.Object:
    """An ellipsoid whose half axes lie along the columns of ``axes``, in no collection yet."""
    made = _object(name, _shared("ball", _ball), colour)
    made.matrix_world = Matrix.LocRotScale(Vector(centre), axes.to_quaternion(), Vector(half_axes_m))
    return made


def arrow_object(
    name: str, start: Sequence[float], vector_m: Sequence[float], colour: Colour
) -> bpy.types.Object:
    """An arrow of ``vector_m``, in no collection yet; :func:`stretch` draws it longer."""
    made = _object(name, _shared("arrow", _arrow), colour)
    made.location = Vector(start)
    made.rotation_mode = "QUATERNION"
    made.rotation_quaternion = _turn(Vector(vector_m))
    made["cabletwin_vector_m"] = tuple(vector_m)
    stretch(made, 1.0)
    return made


def stretch(arrow: bpy.types.Object, factor: float) -> None:
    """Draw an arrow ``factor`` times as long as its vector."""
    length = factor * math.hypot(*arrow["cabletwin_vector_m"])
    arrow.scale = (length, length, length)


def _object(name: str, data: bpy.types.Mesh, colour: Colour) -> bpy.types.Object:
    made = bpy.data.objects.new(name, data)
    slot = made.material_slots[0]
    slot.link = "OBJECT"
    slot.material = plain_material(colour)
    made.color = colour
    made["cabletwin_name"] = name
    return made


def _turn(direction: Vector) -> Quaternion:
    """The rotation that takes z to a direction; Blender's own ``to_track_quat`` is off by 5e-6."""
    z = np.array(direction, dtype=np.float64)
    z /= np.linalg.norm(z) or 1.0
    x = np.cross(np.eye(3)[np.argmin(np.abs(z))], z)
    x /= np.linalg.norm(x) or 1.0
    return Matrix(np.stack([x, np.cross(z, x), z], axis=1).tolist()).to_quaternion()


def _shared(kind: str, build: Callable[[bmesh.types.BMesh], None]) -> bpy.types.Mesh:
    name = f"CableTwin steel {kind}"
    found = bpy.data.meshes.get(name)
    if found is not None:
        return found
    data = bpy.data.meshes.new(name)
    shape = bmesh.new()
    build(shape)
    shape.to_mesh(data)
    shape.free()
    data.shade_smooth()
    data.set_sharp_from_angle(angle=math.radians(40))
    data.materials.append(plain_material(STEEL))
    return data


def _tube(shape: bmesh.types.BMesh) -> None:
    """Radius 1 about z, from 0 to 1."""
    _cone(shape, 24, 1.0, 1.0, 0.0, 1.0)


def _ball(shape: bmesh.types.BMesh) -> None:
    bmesh.ops.create_icosphere(shape, subdivisions=3, radius=1.0)


def _arrow(shape: bmesh.types.BMesh) -> None:
    """From 0 to 1 along z."""
    _cone(shape, 12, SHAFT, SHAFT, 0.0, 1 - HEAD_SHARE)
    _cone(shape, 12, HEAD, 0.0, 1 - HEAD_SHARE, 1.0)


def _cone(shape: bmesh.types.BMesh, sides: int, low: float, high: float, bottom: float, top: float) -> None:
    bmesh.ops.create_cone(
        shape,
        cap_ends=True,
        segments=sides,
        radius1=low,
        radius2=high,
        depth=top - bottom,
        matrix=Matrix.Translation((0, 0, (bottom + top) / 2)),
    )
