"""Textured meshes: the report's Mesh to a mesh datablock."""

import bpy
import numpy as np

from pipeline.report.types import Mesh

from .materials import packed_image, picture_material


def mesh_object(name: str, mesh: Mesh, material: bpy.types.Material | None = None) -> bpy.types.Object:
    """A textured mesh as an object that is in no collection yet.

    Args:
        name: of object and data.
        mesh: with its picture.
        material: that shows the picture already; None makes one, with the picture packed into the file.
    """
    data = bpy.data.meshes.new(name)
    data.vertices.add(len(mesh.vertices))
    data.vertices.foreach_set("co", mesh.vertices.astype(np.float32).ravel())
    corners = np.ascontiguousarray(mesh.faces, dtype=np.int32)
    data.loops.add(corners.size)
    data.loops.foreach_set("vertex_index", corners.ravel())
    data.polygons.add(len(corners))
    data.polygons.foreach_set("loop_start", np.arange(0, corners.size, 3, dtype=np.int32))
    layer = data.uv_layers.new(name="unrolled")
    uv = np.stack([mesh.uv[:, 0], 1 - mesh.uv[:, 1]], axis=1).astype(np.float32)
    layer.uv.foreach_set("vector", uv[corners.ravel()].ravel())
    data.update(calc_edges=True)
    data.shade_smooth()
    if material is None:
        material = picture_material(name, packed_image(f"{name} unrolled", mesh.texture))
    data.materials.append(material)
    return bpy.data.objects.new(name, data)
