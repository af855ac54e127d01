"""The place on a mesh that lies under the mouse in a 3D view."""

import bpy
from mathutils import Vector

from ..results.picking import inside, line_of_sight


def view_under_mouse(context: bpy.types.Context, event: bpy.types.Event) -> bpy.types.Area | None:
    """The 3D view that the mouse is over, or None: over another editor, a sidebar or a header."""
    views = (a for a in context.window.screen.areas if a.type == "VIEW_3D")
    return next((a for a in views if inside(a, event.mouse_x, event.mouse_y)), None)


def surface_on_ray(
    view_layer: bpy.types.ViewLayer, start: Vector, along: Vector, meshes: list[bpy.types.Object]
) -> Vector | None:
    """The first place that a ray meets on any of the meshes that are visible, all in the world."""
    places = []
    for item in meshes:
        if not item.visible_get(view_layer=view_layer):
            continue
        back = item.matrix_world.inverted()
        hit, place, _, _ = item.ray_cast(back @ start, (back.to_3x3() @ along).normalized())
        if hit:
            places.append(item.matrix_world @ place)
    return min(places, key=lambda place: (place - start).length, default=None)


def surface_under_mouse(
    context: bpy.types.Context, event: bpy.types.Event, meshes: list[bpy.types.Object]
) -> Vector | None:
    """The nearest place on any of the meshes, in the world; None where the mouse is not over them."""
    area = view_under_mouse(context, event)
    if area is None:
        return None
    start, along = line_of_sight(area, event.mouse_x, event.mouse_y)
    return surface_on_ray(context.view_layer, start, along, meshes)
