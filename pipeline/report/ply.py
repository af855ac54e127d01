"""Meshes and clouds as binary PLY, little endian, which CloudCompare, MeshLab and Blender read.

Takes records of ``types``, gives bytes.  Metres, cable frame.
"""

import numpy as np
from numpy.typing import NDArray

from pipeline.core.vocabulary import Array
from pipeline.report.types import Cloud, Mesh, Picture

_TYPE_NAMES = {"<f4": "float", "|u1": "uchar", "<i4": "int"}
_PLACE = [(name, "<f4") for name in ("x", "y", "z", "nx", "ny", "nz")]
_COLOUR = [(name, "|u1") for name in ("red", "green", "blue")]


def mesh_ply_bytes(mesh: Mesh) -> bytes:
    """Mesh with normals, texture coordinates (s right, t *up*, as PLY readers expect) and vertex colours."""
    rows = np.empty(len(mesh.vertices), dtype=[*_PLACE, *_COLOUR, ("s", "<f4"), ("t", "<f4")])
    _fill(rows, mesh.vertices, mesh.normals, colours_at(mesh.texture, mesh.uv))
    rows["s"] = mesh.uv[:, 0]
    rows["t"] = 1 - mesh.uv[:, 1]
    faces = np.empty(len(mesh.faces), dtype=[("count", "|u1"), ("corners", "<i4", (3,))])
    faces["count"] = 3
    faces["corners"] = mesh.faces
    face_lines = [f"element face {len(faces)}", "property list uchar int vertex_indices"]
    return _header(_element("vertex", rows) + face_lines) + rows.tobytes() + faces.tobytes()


def cloud_ply_bytes(cloud: Cloud) -> bytes:
    """Points with normals and colours."""
    rows = np.empty(len(cloud.points), dtype=[*_PLACE, *_COLOUR])
    _fill(rows, cloud.points, cloud.normals, cloud.colours)
    return _header(_element("vertex", rows)) + rows.tobytes()


def colours_at(texture: Picture, uv: Array) -> Picture:
    """Colours (n, 3) of the texture's pixels at the places uv (n, 2); (0, 0) is the top-left corner."""
    height, width = texture.shape[:2]
    columns = np.clip((uv[:, 0] * width).astype(np.int64), 0, width - 1)
    rows = np.clip((uv[:, 1] * height).astype(np.int64), 0, height - 1)
    return texture[rows, columns]


def _fill(rows: NDArray[np.void], places: Array, normals: Array, colours: Picture) -> None:
    for axis, (place, normal, colour) in enumerate(
        zip(("x", "y", "z"), ("nx", "ny", "nz"), ("red", "green", "blue"), strict=True)
    ):
        rows[place] = places[:, axis]
        rows[normal] = normals[:, axis]
        rows[colour] = colours[:, axis]


def _element(name: str, rows: NDArray[np.void]) -> list[str]:
    names = rows.dtype.names or ()
    properties = [f"property {_TYPE_NAMES[rows.dtype[field].str]} {field}" for field in names]
    return [f"element {name} {len(rows)}", *properties]


def _header(lines: list[str]) -> bytes:
    comment = "comment CableTwin; metres; y is the cable axis in the direction of travel"
    return "\n".join(["ply", "format binary_little_endian 1.0", comment, *lines, "end_header\n"]).encode()
