"""Pairs picked on the block meshes as by a click, for the tests of what is done with them."""

import math

import bpy
import numpy as np
from mathutils import Vector

from tests.addon.shown_run import library, objects

NAMES = ("Block1", "Block2", "Block3", "Block4")


def line(azimuth_deg, y_m, standoff_m=0.3):
    """From a camera's place to the axis."""
    out = Vector((math.cos(math.radians(azimuth_deg)), 0, -math.sin(math.radians(azimuth_deg))))
    return out * standoff_m + Vector((0, y_m, 0)), -out


def hit(azimuth_deg, y_m, *blocks):
    origin, direction = line(azimuth_deg, y_m)
    context = bpy.context
    return library("results.picking").cast(
        context.scene, context.view_layer, origin, direction, blocks or None
    )


def pick(first, second, azimuth_deg, y_m, aside_m=0.0):
    """Click a place half way between two blocks on both of them, on the second one a little aside."""
    a, b = hit(azimuth_deg, y_m, first), hit(azimuth_deg, y_m + aside_m, second)
    return bpy.ops.cabletwin.mosaic_pick(block_a=first, point_a=a.point, block_b=second, point_b=b.point)


def pick_ring(*aside_m):
    """A pair for every two neighbours, the partner aside by so much along the cable."""
    for k, aside in enumerate(aside_m or (0.0,) * 4):
        assert pick(NAMES[k], NAMES[(k + 1) % 4], 45 + 90 * k, 0.2, aside) == {"FINISHED"}


def places():
    return {name: np.array(item.matrix_world) for name, item in objects("Block meshes").items()}
