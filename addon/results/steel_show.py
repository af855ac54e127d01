"""A steel run into the scene: stations, targets, clouds, members, arrows and what is wrong."""

import math
from collections.abc import Iterable
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix, Vector

from . import steel_collections as steel
from .steel_points import photo_cloud, station_clouds
from .steel_rows import Column, Gross, Node, Place, Station, SteelRows, Target
from .steel_run import read_steel
from .steel_shapes import (
    BAD,
    GOOD,
    STEEL,
    UNKNOWN,
    UNSURE,
    arrow_object,
    ball_object,
    ellipsoid_object,
    stretch,
    tube_object,
)

STATION_M, TARGET_M, MARK_M = 0.5, 0.0725, 0.15
"""Size of the drawn things: a scanner's axes, a target, the mark of a gross error."""
LEAST_SHARE = 0.01
"""An ellipsoid is drawn no flatter than this share of its longest axis: without volume it cannot be seen."""

_COVARIANCE, _KEPT_SIZE = "cabletwin_half_axes_m", "cabletwin_true_size"


def show_steel(scene: bpy.types.Scene, folder: Path, most_points: int) -> SteelRows:
    """Put a finished steel run into the scene, in place of what another one left there.

    Args:
        scene: to fill.
        folder: the run folder.
        most_points: of all clouds together.

    Raises:
        StageError: there is nothing to show; what was shown before stays.
    """
    rows = read_steel(folder)
    names = tuple(station.name for station in rows.stations)
    clouds = [*station_clouds(folder, names, most_points), *photo_cloud(folder, most_points)]
    _fill(scene, steel.STATIONS, (made for s in rows.stations for made in _station(s)))
    _fill(scene, steel.TARGETS, map(_target, rows.targets))
    _fill(scene, steel.CLOUD, clouds)
    _fill(scene, steel.RODS, (tube_object(r.name, r.start, r.end, r.radius_m, STEEL) for r in rows.rods))
    _fill(scene, steel.BALLS, (made for node in rows.nodes if (made := _ball(node))))
    judged = [made for column in rows.columns if (made := _column(column))]
    others = [tube_object(u.name, u.start, u.end, u.radius_m, UNKNOWN) for u in rows.uprights]
    _fill(scene, steel.COLUMNS, [*judged, *others])
    _fill(scene, steel.ARROWS, [*_eccentricities(rows.nodes), *_leans(rows.columns)])
    places = {target.name: target.place for target in rows.targets}
    _fill(scene, steel.GROSS, (made for g in rows.gross for made in _gross(g, places.get(g.target))))
    rescale(scene)
    for kind in steel.KINDS:
        # the points lie on the members and would cover the colours of their verdicts
        steel.set_hidden(scene, kind, kind == steel.CLOUD and bool(rows.rods or rows.columns))
    return rows


def rescale(scene: bpy.types.Scene) -> None:
    """Draw arrows and error ellipsoids as large as the scene wants them now."""
    wanted = scene.cabletwin.steel
    for kind in (steel.ARROWS, steel.GROSS):
        for item in steel.objects(scene, kind):
            if "cabletwin_vector_m" in item:
                stretch(item, 1.0 if item.get(_KEPT_SIZE) else wanted.arrow_scale)
    for item in steel.objects(scene, steel.STATIONS):
        if _COVARIANCE in item:
            item.scale = wanted.error_scale * Vector(item[_COVARIANCE])


def _fill(scene: bpy.types.Scene, kind: str, made: Iterable[bpy.types.Object]) -> None:
    target = steel.emptied(scene, kind)
    for item in made:
        target.objects.link(item)


def _station(station: Station) -> list[bpy.types.Object]:
    """The scanner's axes, and the ellipsoid of one sigma about its centre where it has one."""
    axes = bpy.data.objects.new(station.name, None)
    axes.empty_display_type, axes.empty_display_size = "ARROWS", STATION_M
    axes.show_name = True
    axes["cabletwin_name"] = station.name
    axes.matrix_world = Matrix.Translation(station.place) @ Matrix(station.rotation).to_4x4()
    variances, directions = np.linalg.eigh(np.array(station.covariance_mm2))
    half_axes_m = np.sqrt(np.clip(variances, 0, None)) / 1000
    if not (np.isfinite(half_axes_m).all() and half_axes_m.max() > 0):
        return [axes]  # the base station, to which the others are relative
    half_axes_m = np.maximum(half_axes_m, LEAST_SHARE * half_axes_m.max())
    if np.linalg.det(directions) < 0:
        directions[:, 0] *= -1
    name = f"{station.name} error"
    made = ellipsoid_object(name, station.place, Matrix(directions.tolist()), half_axes_m.tolist(), UNSURE)
    made[_COVARIANCE] = half_axes_m.tolist()
    made.display_type = "WIRE"
    return [axes, made]


def _target(target: Target) -> bpy.types.Object:
    if target.kind == "point":
        return ball_object(target.name, target.place, TARGET_M, UNKNOWN)
    made = bpy.data.objects.new(target.name, None)
    made.empty_display_size, made.location = STATION_M / 2, target.place
    made["cabletwin_name"] = target.name
    return made


def _ball(node: Node) -> bpy.types.Object | None:
    if not _known(node.ball) or not math.isfinite(node.radius_m):
        return None
    judged = math.isfinite(node.size_mm)
    return ball_object(
        node.name, node.ball, node.radius_m, BAD if node.significant else GOOD if judged else UNKNOWN
    )


def _column(column: Column) -> bpy.types.Object | None:
    axis = column.axis
    if not (_known(axis.start) and _known(axis.end) and math.isfinite(axis.radius_m)):
        return None
    return tube_object(column.name, axis.start, axis.end, axis.radius_m, _verdict(column))


def _verdict(column: Column) -> tuple[float, float, float, float]:
    if not column.certain:
        return UNSURE
    return BAD if column.over else GOOD


def _eccentricities(nodes: Iterable[Node]) -> list[bpy.types.Object]:
    """From where the rods meet towards the ball, where they are apart for certain."""
    return [
        _arrow(node.name, f"{node.name} eccentricity", node.rods, node.eccentricity_mm, BAD)
        for node in nodes
        if node.significant and _known(node.rods)
    ]


def _leans(columns: Iterable[Column]) -> list[bpy.types.Object]:
    """At the top, level, from where a plumb column would end."""
    made = []
    for column in columns:
        (x, y, _), (top_x, top_y, top_z) = column.axis.start, column.axis.end
        lean_mm = (1000 * (top_x - x), 1000 * (top_y - y), 0.0)
        if _known(column.axis.start) and _known(column.axis.end) and any(lean_mm):
            made.append(_arrow(column.name, f"{column.name} lean", (x, y, top_z), lean_mm, _verdict(column)))
    return made


def _gross(gross: Gross, place: Place | None) -> list[bpy.types.Object]:
    """A mark at the target, and an arrow to where it was seen; a wrong name's arrow keeps its true length."""
    if place is None:
        return []
    mark = ball_object(f"{gross.target} {gross.kind}", place, MARK_M, BAD)
    mark.show_name = mark.show_in_front = True
    mark.display_type = "WIRE"
    mark["cabletwin_name"] = gross_name(gross)
    offset_m = [value / 1000 for value in gross.offset_mm]
    arrow = arrow_object(f"{gross.target} offset", place, offset_m, BAD)
    if gross.kind != "moved":
        arrow[_KEPT_SIZE] = True
    return [mark, arrow]


def gross_name(gross: Gross) -> str:
    """What a gross error's mark is found by."""
    return " ".join([gross.kind, gross.target, *gross.stations])


def _arrow(
    thing: str, name: str, start: Place, vector_mm: Place, colour: tuple[float, float, float, float]
) -> bpy.types.Object:
    made = arrow_object(name, start, [value / 1000 for value in vector_mm], colour)
    made["cabletwin_name"] = thing
    return made


def _known(place: Place) -> bool:
    return all(math.isfinite(value) for value in place)
