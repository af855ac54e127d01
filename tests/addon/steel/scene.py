"""What a scene shows of a steel run, for tests."""

import json

import bpy
import numpy as np
from mathutils import Vector


def told(folder):
    return json.loads((folder / "report.json").read_text())


def named(kind):
    """Objects of the steel collection whose outliner name is ``kind``, by their names."""
    steel = bpy.data.collections.get("Steel")
    found = steel.children.get(kind) if steel else None
    bpy.context.view_layer.update()
    return {item.name: item for item in found.objects} if found else {}


def colour(item):
    return tuple(item.material_slots[0].material.diffuse_color)


def ends(item):
    """Where the two ends of a tube's or arrow's axis stand in the world."""
    return [np.array(item.matrix_world @ Vector((0, 0, z))) for z in (0, 1)]


def job():
    return bpy.context.window_manager.cabletwin_job


def counts():
    kinds = ("objects", "meshes", "pointclouds", "materials", "collections", "curves")
    return {kind: len(getattr(bpy.data, kind)) for kind in kinds}


def cable_run(folder):
    (folder / "products").mkdir(parents=True)
    (folder / "products" / "all-frames.npz").write_bytes(b"")
    (folder / "report.json").write_text('{"format": 1, "stations": []}')
