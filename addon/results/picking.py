"""Points on the block meshes: what a line of sight meets first, and the same through the pointer."""

from collections.abc import Container
from dataclasses import dataclass

import bpy
from bpy_extras import view3d_utils
from mathutils import Vector

from . import collections

NEAR_M = 10.0
"""A view without perspective looks from so far off; from its far clip 32 bits would leave 0.1 mm."""


@dataclass(frozen=True, kw_only=True)
class Hit:
    """A point on a block.

    Attributes:
        block: the block's name.
        point: metres in the block's own frame.
        distance_m: from the line's origin, in the world.
    """

    block: str
    point: Vector
    distance_m: float


def block_objects(scene: bpy.types.Scene) -> dict[str, bpy.types.Object]:
    """The block meshes by the names of their blocks."""
    found = collections.existing(scene, collections.BLOCKS)
    return {o["cabletwin_block"]: o for o in found.objects if "cabletwin_block" in o} if found else {}


def cast(
    scene: bpy.types.Scene,
    view_layer: bpy.types.ViewLayer,
    origin: Vector,
    direction: Vector,
    blocks: Container[str] | None = None,
) -> Hit | None:
    """The first point that a line meets on a visible block mesh, or None.

    Args:
        scene: whose blocks.
        view_layer: in which they must be visible.
        origin, direction: of the line, in the world.
        blocks: names of those that count; None: all.
    """
    hits = []
    for name, item in block_objects(scene).items():
        if (blocks is not None and name not in blocks) or not item.visible_get(view_layer=view_layer):
            continue
        inverse = item.matrix_world.inverted()
        met, point, _, _ = item.ray_cast(inverse @ origin, (inverse.to_3x3() @ direction).normalized())
        if met:
            away_m = (item.matrix_world @ point - origin).length
            hits.append(Hit(block=name, point=point, distance_m=away_m))
    return min(hits, key=lambda hit: hit.distance_m, default=None)


def window_region(area: bpy.types.Area) -> bpy.types.Region:
    """The part of a 3D view that shows the scene."""
    return next(r for r in area.regions if r.type == "WINDOW")


def inside(area: bpy.types.Area, x: int, y: int) -> bool:
    """Whether a place in the window is over the scene, and not over the sidebar or another region."""
    for region in area.regions:
        over = region.x <= x < region.x + region.width and region.y <= y < region.y + region.height
        if region.type != "WINDOW" and region.width > 1 and over and region.alignment != "NONE":
            return False
    region = window_region(area)
    return region.x <= x < region.x + region.width and region.y <= y < region.y + region.height


def line_of_sight(area: bpy.types.Area, x: int, y: int) -> tuple[Vector, Vector]:
    """Origin and direction, in the world, of what is seen at a place in the window."""
    region = window_region(area)
    view, place = area.spaces.active.region_3d, (x - region.x, y - region.y)
    return (
        view3d_utils.region_2d_to_origin_3d(region, view, place, clamp=NEAR_M),
        view3d_utils.region_2d_to_vector_3d(region, view, place),
    )
