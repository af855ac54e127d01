"""What the 3D views show of a steel structure: all of it, or the one thing that was chosen in a table."""

import bpy
import numpy as np
from mathutils import Vector

from . import steel_collections as steel
from .view import views

CLOSEST_M, MARGIN, WHOLE_MARGIN = 1.0, 1.6, 1.2
"""How near the eye comes to a small thing; how much more than the box of one thing, of all, is seen."""


def look_at_all(context: bpy.types.Context, scene: bpy.types.Scene) -> None:
    """Turn every 3D view to the whole structure, as shapes in the colours of their verdicts."""
    for space in views(context, scene):
        space.shading.type, space.shading.light, space.shading.color_type = "SOLID", "STUDIO", "MATERIAL"
    kinds = (steel.RODS, steel.BALLS, steel.COLUMNS)
    items = [item for kind in kinds for item in steel.objects(scene, kind)]
    _look(context, scene, items or [i for k in steel.KINDS for i in steel.objects(scene, k)], WHOLE_MARGIN)


def choose(context: bpy.types.Context, scene: bpy.types.Scene, kind: str, name: str) -> bool:
    """Select the thing of that kind and name, alone, and turn every 3D view to it; False where it is not."""
    item = steel.named(scene, kind, name)
    if item is None:
        return False
    steel.set_hidden(scene, kind, False)
    for view_layer in scene.view_layers:
        if item.name not in view_layer.objects:
            continue
        for other in view_layer.objects:
            if other.select_get(view_layer=view_layer):
                other.select_set(False, view_layer=view_layer)
        item.select_set(True, view_layer=view_layer)
        view_layer.objects.active = item
    _look(context, scene, [item], MARGIN)
    return True


def _look(
    context: bpy.types.Context, scene: bpy.types.Scene, items: list[bpy.types.Object], margin: float
) -> None:
    """Without the operator view3d.view_selected, which needs a window: scripts and tests have none."""
    for view_layer in scene.view_layers:
        view_layer.update()  # places of what was just made are not there before
    corners = np.array([i.matrix_world @ Vector(c) for i in items for c in i.bound_box]).reshape(-1, 3)
    if not len(corners):
        return
    low, high = corners.min(axis=0), corners.max(axis=0)
    for space in views(context, scene):
        view = space.region_3d
        if view.view_perspective == "CAMERA":
            view.view_perspective = "PERSP"
        view.view_location = Vector((low + high) / 2)
        view.view_distance = max(margin * float(np.linalg.norm(high - low)), CLOSEST_M)
