"""Textured meshes: the report's Mesh to a mesh datablock.

What takes time, reckoning and packing the picture, is :func:`prepared` and may be done beside Blender;
:func:`mesh_object` only hands whole arrays over.
"""

from dataclasses import dataclass

import bpy
import numpy as np
from numpy.typing import NDArray

from pipeline.report.types import Mesh

from .materials import packed_image, picture_material, png


@dataclass(frozen=True, kw_only=True)
class Prepared:
    """A mesh as Blender wants it.

    Attributes:
        vertices: (v, 3) metres.
        corners: (3 f,) vertex of each corner, face by face.
        uv: (3 f, 2) of each corner, from the picture's lower left.
        edges: (e, 2) vertices.
        corner_edges: (3 f,) the edge from each corner to the next one of its face.
        picture: a PNG; None where a material is there already.
    """

    vertices: NDArray[np.float32]
    corners: NDArray[np.int32]
    uv: NDArray[np.float32]
    edges: NDArray[np.int32]
    corner_edges: NDArray[np.int32]
    picture: bytes | None


def prepared(mesh: Mesh, *, picture: bool = True) -> Prepared:
    """All that can be done without Blender; ``picture``: its texture as well."""
    faces = np.ascontiguousarray(mesh.faces, dtype=np.int32)
    uv = np.stack([mesh.uv[:, 0], 1 - mesh.uv[:, 1]], axis=1).astype(np.float32)
    edges, corner_edges = _edges(faces, len(mesh.vertices))
    return Prepared(
        vertices=mesh.vertices.astype(np.float32),
        corners=faces.ravel(),
        uv=uv[faces.ravel()],
        edges=edges,
        corner_edges=corner_edges,
        picture=png(mesh.texture) if picture else None,
    )


def mesh_object(name: str, made: Prepared, material: bpy.types.Material | None = None) -> bpy.types.Object:
    """A textured mesh as an object that is in no collection yet.

    Args:
        name: of object and data.
        made: with its picture, unless
        material: shows that already; None makes one, with the picture packed into the file.
    """
    data = bpy.data.meshes.new(name)
    for parts, count in (
        (data.vertices, len(made.vertices)),
        (data.edges, len(made.edges)),
        (data.loops, len(made.corners)),
        (data.polygons, len(made.corners) // 3),
    ):
        parts.add(count)
    # by attribute: the same through vertices and loops takes ten times as long
    _set(data, "position", "FLOAT_VECTOR", "POINT", "vector", made.vertices)
    _set(data, ".edge_verts", "INT32_2D", "EDGE", "value", made.edges)
    _set(data, ".corner_vert", "INT", "CORNER", "value", made.corners)
    _set(data, ".corner_edge", "INT", "CORNER", "value", made.corner_edges)
    data.polygons.foreach_set("loop_start", np.arange(0, len(made.corners), 3, dtype=np.int32))
    data.uv_layers.new(name="unrolled", do_init=False).uv.foreach_set("vector", made.uv.ravel())
    data.update()
    data.shade_smooth()
    if material is None and made.picture is not None:
        material = picture_material(name, packed_image(f"{name} unrolled", made.picture))
    data.materials.append(material)
    return bpy.data.objects.new(name, data)


def _set(
    data: bpy.types.Mesh, name: str, kind: str, domain: str, key: str, values: NDArray[np.generic]
) -> None:
    attribute = data.attributes.get(name) or data.attributes.new(name, kind, domain)
    attribute.data.foreach_set(key, values.ravel())


def _edges(faces: NDArray[np.int32], vertices: int) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Every edge once, and for each corner the edge to the next corner of its triangle."""
    ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2).astype(np.int64)
    key, corner_edges = np.unique(ends.min(axis=1) * vertices + ends.max(axis=1), return_inverse=True)
    return np.stack(np.divmod(key, vertices), axis=1).astype(np.int32), corner_edges.astype(np.int32)
