"""The robot's ring of the asset library in the scene: as many cameras as wanted, moving along the travel.

Takes the properties of the area *synthesise*; keeps the ring in step with them.  The rendered survey does not
look at these objects: they show what it will be.
"""

import math

import bpy
import numpy as np
from bpy_extras.anim_utils import action_get_channelbag_for_slot
from mathutils import Matrix

from pipeline.core.rotations import nominal_pose
from pipeline.core.vocabulary import TravelDirection

from ..asset_library import append_collection
from ..properties.synthesise import CableTwinSynthesise
from ..synthetic_cable import asset_modifier, read_inputs, scene_cable, write_inputs
from . import collections
from .cameras import SENSOR_MM, world_from_camera

_DEFAULT_TRAVEL_M = 0.46


def add_ring(scene: bpy.types.Scene) -> bpy.types.Object:
    """Put the library's ring into the scene, in place of one that is there; gives its middle."""
    target = collections.emptied(scene, collections.RING)
    source = append_collection("Robot ring")
    for item in list(source.objects):
        target.objects.link(item)
    bpy.data.collections.remove(source)
    refresh_ring(scene)
    middle = ring_middle(scene)
    if middle is None:
        raise RuntimeError("the library's ring has no middle")
    return middle


def ring_middle(scene: bpy.types.Scene) -> bpy.types.Object | None:
    """The empty that everything of the ring rides on, or None."""
    found = collections.existing(scene, collections.RING)
    return next((item for item in found.objects if item.type == "EMPTY"), None) if found else None


def refresh_ring(scene: bpy.types.Scene) -> None:
    """Bring the ring in step with the properties; nothing where there is none."""
    middle = ring_middle(scene)
    if middle is None:
        return
    settings = scene.cabletwin.synthesise
    for item in list(collections.collection(scene, collections.RING).objects):
        if modifier := asset_modifier(item, "ring"):
            values = {("", "Cameras"): settings.cameras, ("", "Stand-off"): settings.standoff}
            write_inputs(item, modifier, values)
        elif item.type in {"CAMERA", "LIGHT"}:
            _keep_or_remove(item, settings.cameras)
    for number in range(settings.cameras):
        _camera(scene, middle, number)
        _lamp(scene, middle, number)
    cable = scene_cable(scene)
    modifier = asset_modifier(cable, "cable") if cable else None
    travel_m = read_inputs(modifier)["", "Travel"] if modifier else _DEFAULT_TRAVEL_M
    _travel(middle, travel_m, settings.frames)


_NUMBER = "cabletwin_number"


def _keep_or_remove(item: bpy.types.Object, cameras: int) -> None:
    """The library's cameras and lamps are named Block1, Lamp1; here they are known by their number."""
    if _NUMBER not in item:
        digits = "".join(c for c in item.name.split(".")[0] if c.isdigit())
        item[_NUMBER] = int(digits) - 1
    if item[_NUMBER] >= cameras:
        collections.remove(item)


def _rider(scene: bpy.types.Scene, middle: bpy.types.Object, kind: str, number: int) -> bpy.types.Object:
    """The camera or lamp of a number; a further one is a copy of the first."""
    target = collections.collection(scene, collections.RING)
    riders = {item[_NUMBER]: item for item in target.objects if item.type == kind and _NUMBER in item}
    if number not in riders:
        made = riders[0].copy()
        made.data = riders[0].data.copy()
        made[_NUMBER] = number
        target.objects.link(made)
        riders[number] = made
    found = riders[number]
    found.name = found.data.name = f"{'Block' if kind == 'CAMERA' else 'Lamp'}{number + 1}"
    found.parent = middle
    return found


def _camera(scene: bpy.types.Scene, middle: bpy.types.Object, number: int) -> None:
    settings = scene.cabletwin.synthesise
    made = _rider(scene, middle, "CAMERA", number)
    made.matrix_local = _placed(settings, 360.0 * number / settings.cameras)
    made.data.sensor_width = SENSOR_MM
    made.data.lens = max(SENSOR_MM * settings.focal_px / settings.width_px, 1.0)
    made.data.display_size = 0.2 * settings.standoff


def _lamp(scene: bpy.types.Scene, middle: bpy.types.Object, number: int) -> None:
    """Half-way to the next camera, as synth has it; a single camera has it at 45 degrees."""
    settings = scene.cabletwin.synthesise
    half_deg = 180.0 / settings.cameras if settings.cameras > 1 else 45.0
    made = _rider(scene, middle, "LIGHT", number)
    made.matrix_local = _placed(settings, 360.0 * number / settings.cameras + half_deg)


def _placed(settings: CableTwinSynthesise, angle_deg: float) -> Matrix:
    direction = TravelDirection(settings.travel_in_image)
    poses = nominal_pose(math.fmod(angle_deg, 360.0), settings.standoff, np.zeros(1), direction)
    return Matrix(world_from_camera(poses.rotations[0], poses.translations[0]).tolist())


def _travel(middle: bpy.types.Object, travel_m: float, frames: int) -> None:
    """Even travel along y, one frame of the scene for one of the survey."""
    middle.animation_data_clear()
    for frame, y_m in ((1, 0.0), (frames, travel_m)):
        middle.location = (0.0, y_m, 0.0)
        middle.keyframe_insert("location", index=1, frame=frame)
    middle.location = (0.0, 0.0, 0.0)
    moved = middle.animation_data
    for curve in action_get_channelbag_for_slot(moved.action, moved.action_slot).fcurves:
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
