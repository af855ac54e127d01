"""Marks of the pairs on the block meshes: small balls, numbered 1 and 1′ as homologous points are.

The numbers are written by :mod:`..overlay`, which keeps them apart and leaves out those behind the cable; the
balls, too, are seen only from in front, or a pair of one seam would seem to lie on the opposite one.
"""

import bmesh
import bpy
from mathutils import Matrix, Vector

from . import collections
from .materials import plain_material
from .picking import block_objects

RADIUS_M = 0.001
APART_M = 0.01
"""Nearer partners share one number."""
COLOURS = (
    (1.0, 0.45, 0.0, 1.0),
    (0.1, 0.6, 1.0, 1.0),
    (0.3, 0.85, 0.2, 1.0),
    (0.9, 0.2, 0.7, 1.0),
    (1.0, 0.85, 0.1, 1.0),
    (0.3, 0.9, 0.85, 1.0),
)
LABEL = "cabletwin_label"
"""What is written at a mark."""
_DATA = "CableTwin mark"


def show_marks(scene: bpy.types.Scene) -> None:
    """Draw all pairs of the scene anew."""
    target = collections.emptied(scene, collections.PAIRS)
    for number, pair in enumerate(scene.cabletwin.mosaic.pairs):
        first = _mark(scene, target, number, pair.block_a, Vector(pair.point_a))
        second = _mark(scene, target, number, pair.block_b, Vector(pair.point_b), partner=True)
        if first and second:  # one number is enough for both
            apart_m = (second.matrix_world.translation - first.matrix_world.translation).length
            if apart_m <= APART_M:
                del second[LABEL]


def show_pending(scene: bpy.types.Scene, block: str, point: Vector) -> None:
    """Draw the first point of a pair whose second one is still to come."""
    target = collections.collection(scene, collections.PAIRS)
    _mark(scene, target, len(scene.cabletwin.mosaic.pairs), block, point)


def _mark(
    scene: bpy.types.Scene,
    target: bpy.types.Collection,
    number: int,
    block: str,
    point: Vector,
    *,
    partner: bool = False,
) -> bpy.types.Object | None:
    parent = block_objects(scene).get(block)
    if parent is None:
        return None
    colour = COLOURS[number % len(COLOURS)]
    name = f"{number + 1}′" if partner else f"{number + 1}"
    made = bpy.data.objects.new(name, _ball(number % len(COLOURS), colour))
    # not its child: Blender would draw a line from each mark to the origin
    made.matrix_world = Matrix.LocRotScale(parent.matrix_world @ point, None, (RADIUS_M,) * 3)
    made.hide_select = True
    made["cabletwin_pair"], made["cabletwin_block"], made[LABEL] = number, block, name
    target.objects.link(made)
    return made


def _ball(number: int, colour: tuple[float, float, float, float]) -> bpy.types.Mesh:
    name = f"{_DATA} {number + 1}"
    found = bpy.data.meshes.get(name)
    if found is not None:
        return found
    data = bpy.data.meshes.new(name)
    shape = bmesh.new()
    bmesh.ops.create_icosphere(shape, subdivisions=2, radius=1.0)
    shape.to_mesh(data)
    shape.free()
    data.materials.append(plain_material(colour))
    return data
