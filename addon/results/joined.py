"""Blocks in new places: their meshes, clouds and cameras move together, and the seam is looked at."""

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

import bpy
import numpy as np
from mathutils import Matrix, Vector

from pipeline.core.errors import StageError

from . import collections
from .crop_preview import end_preview
from .picking import block_objects

if TYPE_CHECKING:
    from pipeline.core.vocabulary import Array

FITTED = (collections.BLOCKS, collections.SPARSE, collections.CAMERAS, collections.PAIRS)
COVERING = (collections.MOSAIC, collections.DENSE, collections.SPARSE, collections.CAMERAS)


def place_blocks(scene: bpy.types.Scene, names: Iterable[str], cable_from_block: "Array") -> None:
    """Move everything of each block to where the block belongs now.

    Args:
        scene: whose blocks.
        names: of the blocks, in the order of
        cable_from_block: (b, 4, 4), metres.
    """
    meshes = block_objects(scene)
    for name, matrix in zip(names, cable_from_block, strict=True):
        if name not in meshes:
            continue
        new = Matrix(matrix.tolist())
        step = new @ meshes[name].matrix_world.inverted()
        for kind in FITTED:
            found = collections.existing(scene, kind)
            for item in found.objects if found else ():
                if item.get("cabletwin_block") == name:
                    item.matrix_world = new if item == meshes[name] else step @ item.matrix_world


def show_blocks(scene: bpy.types.Scene) -> None:
    """Let the block meshes be seen, and nothing over them; a preview of the crop ends."""
    end_preview(scene)
    for kind in (collections.BLOCKS, collections.PAIRS):
        collections.set_hidden(scene, kind, False)
    for kind in COVERING:
        collections.set_hidden(scene, kind, True)


def show_only(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, blocks: Iterable[str] | None) -> None:
    """Let only these blocks' meshes be seen, with their marks; None: all of them."""
    wanted = None if blocks is None else set(blocks)
    for kind in (collections.BLOCKS, collections.PAIRS):
        found = collections.existing(scene, kind)
        for item in found.objects if found else ():
            if item.name in view_layer.objects:
                hidden = wanted is not None and item.get("cabletwin_block") not in wanted
                item.hide_set(hidden, view_layer=view_layer)


def seam(scene: bpy.types.Scene, first: str, second: str) -> tuple[Vector, Vector, float]:
    """Where two blocks meet.

    Returns:
        The seam's middle, the direction from there out of the cable, and the seam's length in metres.

    Raises:
        StageError: a block is not there, or they lie opposite each other.
    """
    meshes = block_objects(scene)
    for name in (first, second):
        if name not in meshes:
            raise StageError("mosaic", f'there is no block "{name}"', "choose two neighbours")
    boxes = [
        np.array([meshes[n].matrix_world @ Vector(c) for c in meshes[n].bound_box]) for n in (first, second)
    ]
    middles = [(box.min(axis=0) + box.max(axis=0)) / 2 for box in boxes]
    out = np.array([middles[0][0] + middles[1][0], 0.0, middles[0][2] + middles[1][2]])
    apart = math.dist(middles[0][[0, 2]], middles[1][[0, 2]])
    if np.linalg.norm(out) < 0.2 * apart:
        raise StageError("mosaic", f"{first} and {second} do not meet", "choose two neighbours")
    out /= np.linalg.norm(out)
    radius_m = max(float(middle @ out) for middle in middles)
    along_m = (boxes[0][:, 1].mean() + boxes[1][:, 1].mean()) / 2
    return Vector(out * radius_m + (0, along_m, 0)), Vector(out), float(np.ptp(boxes[0][:, 1]))


def look_at_seam(view: bpy.types.RegionView3D, middle: Vector, out: Vector, length_m: float) -> None:
    """Turn a view to a seam: from outside, the cable from left to right."""
    right = Vector((0, 1, 0))
    up = out.cross(right)
    view.view_perspective = "ORTHO"
    view.view_rotation = Matrix((right, up, out)).transposed().to_quaternion()
    view.view_location = middle
    view.view_distance = 0.75 * length_m
