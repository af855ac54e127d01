"""Stations on the measured cable: a circle of the measured diameter at each, with its name and figure."""

import bpy
import numpy as np

from pipeline.cable.measure import Section
from pipeline.opened import OpenedRun

from . import collections

POINTS = 96


def show_stations(scene: bpy.types.Scene, run: OpenedRun) -> None:
    """One circle for each measured section, about the section's own centre."""
    target = collections.emptied(scene, collections.STATIONS)
    if run.measurement is None:
        return
    for section in run.measurement.sections:
        target.objects.link(_circle(section))


def _circle(section: Section) -> bpy.types.Object:
    angle = np.linspace(0, 2 * np.pi, POINTS, endpoint=False)
    radius_m, (x_m, z_m) = section.diameter_mm / 2000, section.centre_mm / 1000
    ring = np.stack([x_m + radius_m * np.cos(angle), 0 * angle, z_m - radius_m * np.sin(angle)], axis=1)
    data = bpy.data.meshes.new(section.name)
    data.from_pydata(ring.tolist(), [(k, (k + 1) % POINTS) for k in range(POINTS)], [])
    made = bpy.data.objects.new(f"{section.name}  {section.diameter_mm:.2f} mm", data)
    made.location = (0.0, section.position_m, 0.0)
    made.show_name = made.show_in_front = True
    made["cabletwin_station"] = section.name
    return made
