"""A live sketch of the set-up: ring of cameras, axis, cable and stations, so that a wrong angle is seen.

Takes the survey's properties; keeps plain objects in the collection *Setup* in step with them.
"""

import math

import bpy
import numpy as np
from mathutils import Matrix

from pipeline.core.rotations import nominal_pose
from pipeline.core.vocabulary import TravelDirection

from ..properties.block import CableTwinBlock
from . import collections
from .cameras import SENSOR_MM, world_from_camera
from .stations import refresh_stations

AROUND = 64
ASSUMED_WIDTH_PX = 960
ASSUMED_RADIUS_M = 0.05
CAMERA_SHARE = 0.25
"""Drawn size of a camera, by the stand-off."""
LINE_SHARE = 0.006
"""Thickness of the drawn lines, by the stand-off."""
SHEATH, RING, STATION = (0.35, 0.37, 0.40, 1.0), (0.10, 0.45, 0.80, 1.0), (0.95, 0.45, 0.05, 1.0)

type _Point = tuple[float, float, float]


def refresh_sketch(scene: bpy.types.Scene) -> None:
    """Draw the survey's set-up anew, and mark stations that are still to be measured."""
    refresh_stations(scene)
    survey = scene.cabletwin.survey
    if not survey.blocks:
        if collections.existing(scene, collections.SETUP):
            collections.emptied(scene, collections.SETUP)
        return
    target = collections.emptied(scene, collections.SETUP)
    line_m = LINE_SHARE * survey.standoff
    radius_m = survey.diameter / 2 if survey.use_diameter else ASSUMED_RADIUS_M
    arrow = _line("Travel", _arrow(survey.travel, radius_m), line_m, RING)
    ring = _line("Ring", [_circle(survey.standoff)], line_m, RING)
    for made in (_cable(survey.travel, radius_m), arrow, ring):
        made.hide_select = True
        target.objects.link(made)
    for block in survey.blocks:
        target.objects.link(_camera(block, survey.standoff))
    for station in survey.stations:
        mark = _line(station.name, [_circle(1.01 * radius_m)], line_m, STATION)
        mark.location = (0, station.position, 0)
        mark.show_name = mark.hide_select = True
        target.objects.link(mark)


def _cable(travel_m: float, radius_m: float) -> bpy.types.Object:
    """A plain tube over the travel."""
    rings = [np.array(_circle(radius_m)[:-1]) + np.array([0.0, y, 0.0]) for y in (0.0, travel_m)]
    following = [(k + 1) % AROUND for k in range(AROUND)]
    faces = [(k, n, AROUND + n, AROUND + k) for k, n in enumerate(following)]
    data = bpy.data.meshes.new("Cable")
    data.from_pydata(np.concatenate(rings).tolist(), [], faces)
    data.shade_smooth()
    data.materials.append(_paint(SHEATH))
    return bpy.data.objects.new("Cable", data)


def _arrow(travel_m: float, radius_m: float) -> list[list[_Point]]:
    """Beside the cable, from the first frame to the last."""
    side, head = 1.6 * radius_m, 0.3 * radius_m
    barbs = [(side + turn * head, travel_m - head, 0.0) for turn in (-1, 1)]
    tip = (side, travel_m, 0.0)
    return [[(side, 0.0, 0.0), tip], [barbs[0], tip, barbs[1]]]


def _circle(radius_m: float) -> list[_Point]:
    turns = [math.tau * k / AROUND for k in range(AROUND + 1)]
    return [(radius_m * math.cos(a), 0.0, -radius_m * math.sin(a)) for a in turns]


def _camera(block: CableTwinBlock, standoff_m: float) -> bpy.types.Object:
    data = bpy.data.cameras.new(block.name)
    in_px = block.focal_in == "PX"
    share = block.focal_px / ASSUMED_WIDTH_PX if in_px else block.focal_mm / block.sensor_width_mm
    data.sensor_width, data.lens = SENSOR_MM, max(share * SENSOR_MM, 1.0)
    data.display_size = CAMERA_SHARE * standoff_m
    made = bpy.data.objects.new(block.name, data)
    poses = nominal_pose(
        math.degrees(block.angle), standoff_m, np.zeros(1), TravelDirection(block.travel_in_image)
    )
    made.matrix_world = Matrix(world_from_camera(poses.rotations[0], poses.translations[0]).tolist())
    made.show_name = made.hide_select = True
    return made


def _line(
    name: str, strokes: list[list[_Point]], thickness_m: float, colour: tuple[float, ...]
) -> bpy.types.Object:
    data = bpy.data.curves.new(name, "CURVE")
    data.dimensions = "3D"
    data.bevel_depth, data.bevel_resolution = thickness_m / 2, 1
    for stroke in strokes:
        spline = data.splines.new("POLY")
        spline.points.add(len(stroke) - 1)
        spline.points.foreach_set("co", [v for point in stroke for v in (*point, 1.0)])
    data.materials.append(_paint(colour))
    return bpy.data.objects.new(name, data)


def _paint(colour: tuple[float, ...]) -> bpy.types.Material:
    """A material that solid views show in this colour."""
    name = "CableTwin sketch {:.2f} {:.2f} {:.2f}".format(*colour)
    found = bpy.data.materials.get(name) or bpy.data.materials.new(name)
    found.diffuse_color = colour
    return found
