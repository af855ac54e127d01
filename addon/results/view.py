"""What the 3D views of a scene look at: framing, shading, and the startup cube out of the way."""

from collections.abc import Iterator

import bpy
import numpy as np
from mathutils import Matrix, Vector

from . import collections

STARTUP = {"Cube", "Light", "Camera"}
"""What Blender's own startup file holds; its cube of 2 m would swallow any cable."""


def frame(context: bpy.types.Context, scene: bpy.types.Scene, *kinds: str) -> None:
    """Turn every 3D view of the scene's windows to what the collections of these kinds hold."""
    corners = _corners(scene, kinds)
    if not len(corners):
        return
    low, high = corners.min(axis=0), corners.max(axis=0)
    for space in views(context, scene):
        view = space.region_3d
        if view.view_perspective == "CAMERA":
            view.view_perspective = "PERSP"
        view.view_location = Vector((low + high) / 2)
        view.view_distance = 1.1 * float(np.linalg.norm(high - low))
        space.clip_start = min(space.clip_start, 0.005)


def look_at(
    context: bpy.types.Context,
    scene: bpy.types.Scene,
    place: Vector,
    distance_m: float,
    outward: Vector | None = None,
) -> None:
    """Turn every 3D view of the scene's windows to a place.

    Args:
        context, scene: whose views.
        place: in the world.
        distance_m: from there to the eye.
        outward: from where to look, square to the cable, which then lies level; None keeps the direction.
    """
    for space in views(context, scene):
        view = space.region_3d
        if view.view_perspective == "CAMERA":
            view.view_perspective = "PERSP"
        view.view_location, view.view_distance = place, distance_m
        if outward is not None:
            along = Vector((0, 1, 0))
            axes = Matrix((along, outward.cross(along), outward)).transposed()
            view.view_rotation = axes.to_quaternion()
        space.clip_start = min(space.clip_start, 0.005)


def show_pictures(context: bpy.types.Context, scene: bpy.types.Scene) -> None:
    """Let solid views show the meshes' own pictures, as they were filmed: quick on any machine."""
    for space in views(context, scene):
        space.shading.type = "SOLID"
        space.shading.light = "FLAT"
    show_colours(context, scene)


def show_colours(context: bpy.types.Context, scene: bpy.types.Scene) -> None:
    """Let solid views show the colours of the deviation where the scene wants them, else the pictures."""
    by_texture = scene.cabletwin.measure.colour_by == "TEXTURE"
    for space in views(context, scene):
        space.shading.color_type = "TEXTURE" if by_texture else "VERTEX"


def clear_startup(scene: bpy.types.Scene) -> None:
    """Hide the startup file's objects where a person has added nothing to them; none of them stays active."""
    own = collections.own_objects(scene)
    others = [item for item in scene.objects if item not in own]
    if not {item.name for item in others} <= STARTUP:
        return
    for item in others:
        item.hide_viewport = True
    for view_layer in scene.view_layers:
        if view_layer.objects.active in others:
            view_layer.objects.active = None


def views(context: bpy.types.Context, scene: bpy.types.Scene) -> Iterator[bpy.types.SpaceView3D]:
    """The 3D views of the scene's windows."""
    for window in context.window_manager.windows:
        if window.scene == scene:
            # while a file browser fills the window, the views wait in another screen of the workspace
            screens = {window.screen, *window.workspace.screens}
            yield from (a.spaces.active for s in screens for a in s.areas if a.type == "VIEW_3D")


def _corners(scene: bpy.types.Scene, kinds: tuple[str, ...]) -> np.ndarray:
    """Corners of the objects' boxes in the world, (n, 3)."""
    for view_layer in scene.view_layers:
        view_layer.update()  # boxes and places of what was just made are not there before
    found = [collections.existing(scene, kind) for kind in kinds]
    items = [item for each in found if each is not None for item in each.objects]
    return np.array([item.matrix_world @ Vector(c) for item in items for c in item.bound_box]).reshape(-1, 3)
