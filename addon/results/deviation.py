"""The mosaic's surface coloured by its deviation from the ideal, in place of its picture.

The distances themselves come from ``pipeline.report.deviation`` and lie on the mesh in millimetres, so that
range and reference can be changed, and a saved file opened, without the run folder.
"""

from pathlib import Path
from typing import TYPE_CHECKING

import bpy
import numpy as np

from ..pieces import Pieces, beside
from . import collections
from .materials import attribute_material

if TYPE_CHECKING:
    from pipeline.core.vocabulary import Array
    from pipeline.opened import OpenedRun

FROM_MEAN, OVER_BASE, COLOUR = "deviation_mm", "height_mm", "Deviation"
_RING = "cabletwin_ring"


def attach_deviation(mesh: bpy.types.Mesh, run: "OpenedRun") -> Pieces[None]:
    """Lay the distances on a mesh of the mosaic; :func:`colour_surface` shows them."""
    measurement, ring = run.measurement, run.ring
    if measurement is None or ring is None:
        return
    mesh[_RING] = _ring_stamp(run.folder)
    coordinates = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.attributes["position"].data.foreach_get("vector", coordinates)

    def distances() -> tuple["Array", "Array"]:
        from pipeline.report import deviation

        points = coordinates.reshape(-1, 3).astype(np.float64)
        mean_mm = deviation.mean_diameter_mm(measurement)
        away = deviation.circle_deviation_mm(points, measurement, mean_mm)
        away[~deviation.is_measured(points, ring)] = np.nan
        return away, deviation.base_deviation_mm(points, measurement)

    for name, values in zip((FROM_MEAN, OVER_BASE), (yield from beside(distances)), strict=True):
        _set(mesh, name, values)


def shows_ring(scene: bpy.types.Scene, folder: Path) -> bool:
    """Whether the scene's mosaic is that of the run folder as it is now."""
    meshes, now = mosaic_meshes(scene), _ring_stamp(folder)
    return bool(meshes and now) and all(mesh.get(_RING) == now for mesh in meshes)


def colour_surface(scene: bpy.types.Scene) -> None:
    """Colour by deviation, or show the picture again."""
    wanted = scene.cabletwin.measure
    for mesh in mosaic_meshes(scene):
        away = deviation_of(scene, mesh)
        if away is not None:
            from pipeline.report.deviation import diverging_colours

            _paint(mesh, diverging_colours(away, wanted.limit_mm))
        slot = 0 if away is None else 1
        if mesh.polygons and mesh.polygons[0].material_index != slot:
            mesh.polygons.foreach_set("material_index", np.full(len(mesh.polygons), slot, dtype=np.int32))
        mesh.update()


def deviation_of(scene: bpy.types.Scene, mesh: bpy.types.Mesh) -> np.ndarray | None:
    """(n,) what the scene wants to see of each vertex, mm; None for the picture."""
    wanted = scene.cabletwin.measure
    name = OVER_BASE if wanted.colour_by == "BASE" else FROM_MEAN
    if wanted.colour_by == "TEXTURE" or name not in mesh.attributes:
        return None
    values = np.empty(len(mesh.vertices), dtype=np.float32)
    mesh.attributes[name].data.foreach_get("value", values)
    if wanted.colour_by == "NOMINAL":
        values += (wanted.mean_diameter_mm - 1000 * scene.cabletwin.survey.diameter) / 2
    return values


def mosaic_meshes(scene: bpy.types.Scene) -> list[bpy.types.Mesh]:
    """Those that the scene holds now: one, or none."""
    found = collections.existing(scene, collections.MOSAIC)
    return [] if found is None else [o.data for o in found.objects if o.type == "MESH"]


def _ring_stamp(folder: Path) -> str:
    file = folder / "products" / "all-ring.stamp"
    return file.read_text(encoding="utf-8").strip() if file.is_file() else ""


def _paint(mesh: bpy.types.Mesh, colours: np.ndarray) -> None:
    """(n, 3) uint8 sRGB as the colour attribute that is shown."""
    attribute = mesh.color_attributes.get(COLOUR) or mesh.color_attributes.new(COLOUR, "BYTE_COLOR", "POINT")
    rgba = np.ones((len(colours), 4), dtype=np.float32)
    rgba[:, :3] = colours / 255.0
    attribute.data.foreach_set("color_srgb", rgba.ravel())
    mesh.color_attributes.active_color = attribute
    if len(mesh.materials) < 2:
        mesh.materials.append(attribute_material(COLOUR))


def _set(mesh: bpy.types.Mesh, name: str, values: np.ndarray) -> None:
    attribute = mesh.attributes.get(name) or mesh.attributes.new(name, "FLOAT", "POINT")
    attribute.data.foreach_set("value", values.astype(np.float32))
