"""A live sketch of the set-up: ring of cameras, axis, cable and stations, so that a wrong angle is seen.

Takes the survey's properties; keeps plain objects in the collection *Setup* in step with them.
"""

import math

import bpy
import numpy as np
from mathutils import Matrix

from pipeline.core.rotations import nominal_pose
from pipeline.core.vocabulary import TravelDirection

from ..properties.survey import CableTwinBlock, CableTwinSurvey
from . import collections
from .cameras import SENSOR_MM, world_from_camera

AROUND = 48
ASSUMED_WIDTH_PX = 960
CAMERA_SHARE = 0.25
"""Drawn size of a camera, by the stand-off."""


def refresh_sketch(scene: bpy.types.Scene) -> None:
    """Draw the survey's set-up anew; nothing where the survey has no blocks."""
    survey = scene.cabletwin.survey
    if not survey.blocks:
        if collections.existing(scene, collections.SETUP):
            collections.emptied(scene, collections.SETUP)
        return
    target = collections.emptied(scene, collections.SETUP)
    target.objects.link(_lines(survey))
    for block in survey.blocks:
        target.objects.link(_camera(block, survey.standoff))
    for station in survey.stations:
        target.objects.link(_station(station.name, station.position, survey))


def _lines(survey: CableTwinSurvey) -> bpy.types.Object:
    """Axis with an arrow, outline of the cable, the ring's circle."""
    points: list[tuple[float, float, float]] = [(0, 0, 0), (0, survey.travel, 0)]
    edges = [(0, 1)]
    arrow = 0.04 * max(survey.travel, 0.1)
    for side in (-arrow / 2, arrow / 2):
        points.append((side, survey.travel - arrow, 0))
        edges.append((1, len(points) - 1))
    radius = survey.diameter / 2 if survey.use_diameter else 0.05
    for around, y in ((radius, 0.0), (radius, survey.travel), (survey.standoff, 0.0)):
        _circle(points, edges, around, y)
    made = _object("Setup", points, edges)
    made.hide_select = True
    return made


def _circle(
    points: list[tuple[float, float, float]], edges: list[tuple[int, int]], radius: float, y: float
) -> None:
    first = len(points)
    turns = [math.tau * k / AROUND for k in range(AROUND)]
    points += [(radius * math.cos(a), y, -radius * math.sin(a)) for a in turns]
    edges += [(first + k, first + (k + 1) % AROUND) for k in range(AROUND)]


def _station(name: str, y_m: float, survey: CableTwinSurvey) -> bpy.types.Object:
    points: list[tuple[float, float, float]] = []
    edges: list[tuple[int, int]] = []
    _circle(points, edges, 1.02 * (survey.diameter / 2 if survey.use_diameter else 0.05), 0.0)
    made = _object(name, points, edges)
    made.location = (0, y_m, 0)
    made.show_name = made.hide_select = True
    return made


def _camera(block: CableTwinBlock, standoff_m: float) -> bpy.types.Object:
    data = bpy.data.cameras.new(block.name)
    share = (
        block.focal_px / ASSUMED_WIDTH_PX
        if block.focal_in == "PX"
        else block.focal_mm / block.sensor_width_mm
    )
    data.sensor_width, data.lens = SENSOR_MM, max(share * SENSOR_MM, 1.0)
    data.display_size = CAMERA_SHARE * standoff_m
    made = bpy.data.objects.new(block.name, data)
    poses = nominal_pose(
        math.degrees(block.angle), standoff_m, np.zeros(1), TravelDirection(block.travel_in_image)
    )
    made.matrix_world = Matrix(world_from_camera(poses.rotations[0], poses.translations[0]).tolist())
    made.show_name = made.hide_select = True
    return made


def _object(
    name: str, points: list[tuple[float, float, float]], edges: list[tuple[int, int]]
) -> bpy.types.Object:
    data = bpy.data.meshes.new(name)
    data.from_pydata(points, edges, [])
    return bpy.data.objects.new(name, data)
