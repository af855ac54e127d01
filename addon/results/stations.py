"""Stations on the measured cable: the section at its place, its mean circle, and the figure beside it.

A measured station keeps its section on the object, so that it can be drawn anew with another exaggeration.
A station that is not measured yet gets a plain circle and the diameter of the profile there.
"""

import math
from typing import TYPE_CHECKING

import bpy
import numpy as np

from ..properties.measure import SAME_PLACE_M, measured_at
from . import collections
from .materials import plain_material

if TYPE_CHECKING:
    from pipeline.cable.measure import Section
    from pipeline.opened import OpenedRun

POINTS = 180
LABEL_AT = 1.4
"""Height of the labels over the axis, by the radius."""
THIN, THICK = 0.007, 0.016
"""Thickness of the lines, by the radius."""
_QUIET, _MEASURED, _PROVISIONAL = (0.9, 0.9, 0.9, 1), (1.0, 0.35, 0.0, 1), (0.1, 0.5, 1.0, 1)


type Sections = list[tuple["Section", np.ndarray]]
"""Sections with their distances from their circles, mm, direction by direction."""


def sections_of(run: "OpenedRun") -> Sections:
    """What is drawn of the measured sections; touches no bpy."""
    from pipeline.report.deviation import section_deviation_mm

    return [
        (s, section_deviation_mm(s.points_mm, s.centre_mm, s.diameter_mm / 2)[1])
        for s in (run.measurement.sections if run.measurement else ())
    ]


def show_stations(scene: bpy.types.Scene, run: "OpenedRun", sections: Sections) -> None:
    """Draw every measured section and every station that is still to be measured."""
    target = collections.emptied(scene, collections.STATIONS)
    scene.cabletwin.measure.take(run)
    for section, away in sections:
        target.objects.link(_label(section))
        target.objects.link(_curve(section, away))
    redraw_sections(scene)
    refresh_stations(scene)


def refresh_stations(scene: bpy.types.Scene) -> None:
    """Bring what is drawn in step with the survey's stations: those that are new or moved are provisional."""
    target = collections.existing(scene, collections.STATIONS)
    if target is None:
        return
    wanted = [s.position for s in scene.cabletwin.survey.stations]
    known = []
    for item in list(target.objects):
        if item.get("cabletwin_provisional") or item.get("cabletwin_elsewhere"):
            collections.remove(item)
            continue
        here = item["cabletwin_position_m"]
        known.append(here)
        item.hide_viewport = bool(wanted) and all(abs(here - y) > SAME_PLACE_M for y in wanted)
    for station in scene.cabletwin.survey.stations:
        if any(abs(here - station.position) <= SAME_PLACE_M for here in known):
            continue
        found = measured_at(scene.cabletwin.results, station.position)
        if found is not None:
            target.objects.link(_elsewhere(found))
            continue
        diameter_mm, centre_mm = provisional_mm(scene, station.position)
        station.provisional_mm = diameter_mm if math.isfinite(diameter_mm) else 0.0
        target.objects.link(_provisional(scene, station, centre_mm))


def redraw_sections(scene: bpy.types.Scene) -> None:
    """Draw the sections with the scene's exaggeration."""
    target = collections.existing(scene, collections.STATIONS)
    for item in target.objects if target else ():
        if "cabletwin_deviation_mm" in item:
            _draw_section(item, scene.cabletwin.measure.factor)


def provisional_mm(scene: bpy.types.Scene, position_m: float) -> tuple[float, tuple[float, float]]:
    """Diameter of the profile at a place, and its centre's x and z; NaN where nothing is known."""
    profile = scene.cabletwin.measure.profile
    along = [p.position_m for p in profile]
    if not along or not along[0] - SAME_PLACE_M <= position_m <= along[-1] + SAME_PLACE_M:
        return math.nan, (0.0, 0.0)
    diameter, x, z = (
        float(np.interp(position_m, along, values))
        for values in zip(*((p.diameter_mm, *p.centre_mm) for p in profile), strict=True)
    )
    return diameter, (x, z)


def _label(section: "Section") -> bpy.types.Object:
    """The mean circle with the figure above it."""
    return _labelled(section, (float(section.centre_mm[0]), float(section.centre_mm[1])))


def _elsewhere(station: bpy.types.PropertyGroup) -> bpy.types.Object:
    """The same of a station that another segment of a long survey measured: its section is not at hand."""
    made = _labelled(station, (0.0, 0.0))
    made["cabletwin_elsewhere"] = True
    return made


def _labelled(
    station: "Section | bpy.types.PropertyGroup", centre_mm: tuple[float, float]
) -> bpy.types.Object:
    text = f"{station.name}  {station.diameter_mm:.3f} ± {station.sigma_mm:.3f} mm"
    made = _circle(station.name, station.position_m, station.diameter_mm, centre_mm, _QUIET)
    made["cabletwin_label"] = text
    made["cabletwin_diameter_mm"], made["cabletwin_sigma_mm"] = station.diameter_mm, station.sigma_mm
    return made


def _provisional(
    scene: bpy.types.Scene, station: bpy.types.PropertyGroup, centre_mm: tuple[float, float]
) -> bpy.types.Object:
    """A plain circle; of the mean diameter where the profile knows none."""
    known = station.provisional_mm > 0
    text = f"{station.name}  ≈ {station.provisional_mm:.1f} mm" if known else f"{station.name}  –"
    drawn_mm = station.provisional_mm if known else scene.cabletwin.measure.mean_diameter_mm or 100.0
    made = _circle(station.name, station.position, drawn_mm, centre_mm, _PROVISIONAL)
    made["cabletwin_label"], made["cabletwin_provisional"] = text, True
    return made


def _circle(
    name: str, y_m: float, diameter_mm: float, centre_mm: tuple[float, float], colour: tuple
) -> bpy.types.Object:
    """A circle and a line up to the object's origin, where its label is written."""
    radius_m, (x_m, z_m) = diameter_mm / 2000, (c / 1000 for c in centre_mm)
    up_m = LABEL_AT * radius_m
    turn = np.linspace(0, 2 * np.pi, POINTS, endpoint=False)
    ring = np.column_stack([radius_m * np.cos(turn), radius_m * np.sin(turn) - up_m])
    made = bpy.data.objects.new(name, _curve_data(name, THIN * radius_m, colour))
    _spline(made.data, ring, cyclic=True)
    _spline(made.data, np.array([[0.0, radius_m - up_m], [0.0, 0.0]]), cyclic=False)
    made.location = (x_m, y_m, z_m + up_m)
    made.hide_select = made.show_in_front = True
    made["cabletwin_station"], made["cabletwin_position_m"] = name, y_m
    return made


def _curve(section: "Section", away: np.ndarray) -> bpy.types.Object:
    """The section itself; its points are set by :func:`redraw_sections`."""
    name = f"{section.name} section"
    made = bpy.data.objects.new(name, _curve_data(name, THICK * section.diameter_mm / 2000, _MEASURED))
    made.location = (section.centre_mm[0] / 1000, section.position_m, section.centre_mm[1] / 1000)
    made.hide_select = made.show_in_front = True
    made["cabletwin_station"], made["cabletwin_position_m"] = section.name, section.position_m
    made["cabletwin_radius_mm"], made["cabletwin_deviation_mm"] = section.diameter_mm / 2, away.tolist()
    return made


def _draw_section(item: bpy.types.Object, factor: float) -> None:
    """Splines through the section, broken where it was not seen."""
    away = np.array(item["cabletwin_deviation_mm"][:])
    turn = 2 * np.pi * (np.arange(len(away)) + 0.5) / len(away)
    radius_m = np.maximum(item["cabletwin_radius_mm"] + factor * away, 1.0) / 1000
    ring = np.column_stack([radius_m * np.cos(turn), radius_m * np.sin(turn)])
    item.data.splines.clear()
    if np.isfinite(away).all():
        _spline(item.data, ring, cyclic=True)
        return
    first = int(np.flatnonzero(~np.isfinite(away))[0])  # begin in a gap: no part is cut in two
    ring = np.roll(ring, -first, axis=0)
    gaps = np.flatnonzero(~np.isfinite(ring[:, 0]))
    for start, end in zip(gaps, [*gaps[1:], len(ring)], strict=True):
        if end - start > 2:
            _spline(item.data, ring[start + 1 : end], cyclic=False)


def _curve_data(name: str, thickness_m: float, colour: tuple) -> bpy.types.Curve:
    data = bpy.data.curves.new(name, "CURVE")
    data.dimensions, data.fill_mode = "3D", "FULL"
    data.bevel_depth, data.bevel_resolution = thickness_m / 2, 1
    data.materials.append(plain_material(colour))
    return data


def _spline(data: bpy.types.Curve, flat_m: np.ndarray, cyclic: bool) -> None:
    """A polyline through (n, 2) x and z."""
    spline = data.splines.new("POLY")
    spline.points.add(len(flat_m) - 1)
    rows = np.zeros((len(flat_m), 4), dtype=np.float32)
    rows[:, 0], rows[:, 2], rows[:, 3] = flat_m[:, 0], flat_m[:, 1], 1.0
    spline.points.foreach_set("co", rows.ravel())
    spline.use_cyclic_u = cyclic
