"""Triangulated irregular networks cut from a regular grid of surface points.

Takes an (n, m) grid of points with a mask; gives the triangles whose corners all stand, without unused
points.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.core.vocabulary import Array


@dataclass(frozen=True, kw_only=True)
class Mesh:
    """A surface of triangles.

    Attributes:
        vertices: (v, 3) metres in the cable frame.
        normals: (v, 3) unit vectors, outward.
        faces: (f, 3) int32, counter-clockwise from outside.
        cells: (v,) int64 flat index of each vertex in the grid it was cut from.
    """

    vertices: Array
    normals: Array
    faces: NDArray[np.int32]
    cells: NDArray[np.int64]


def mesh_of_grid(points: Array, stands: NDArray[np.bool_], outward: Array, closed: bool = False) -> Mesh:
    """Triangulate a grid.

    Args:
        points: (n, m, 3), rows along the cable, columns around it with growing azimuth.
        stands: (n, m) cells that have a point.
        outward: (n, m, 3) directions that normals must not oppose.
        closed: the last column joins the first (a full ring).
    """
    rows, columns = stands.shape
    index = np.arange(rows * columns).reshape(rows, columns)
    if closed:
        index = np.concatenate([index, index[:, :1]], axis=1)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    faces = np.concatenate(
        [np.stack([a, c, b], axis=-1).reshape(-1, 3), np.stack([a, d, c], axis=-1).reshape(-1, 3)]
    )
    faces = faces[stands.ravel()[faces].all(axis=1)]
    flat, out = points.reshape(-1, 3), outward.reshape(-1, 3)
    first = faces[:1]
    if len(first):
        face_normal = np.cross(flat[first[0, 1]] - flat[first[0, 0]], flat[first[0, 2]] - flat[first[0, 0]])
        if face_normal @ out[first[0, 0]] < 0:
            faces = faces[:, ::-1]
    used = np.zeros(rows * columns, dtype=np.bool_)
    used[faces.ravel()] = True
    cells = np.flatnonzero(used)
    faces = (np.cumsum(used, dtype=np.int32) - 1)[faces]
    vertices = flat[cells]
    return Mesh(vertices=vertices, normals=_normals(vertices, faces), faces=faces, cells=cells)


def _normals(vertices: Array, faces: NDArray[np.int32]) -> Array:
    """Area-weighted vertex normals."""
    sides = vertices[faces]
    face_normals = np.cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0])
    normals = np.zeros_like(vertices)
    for axis in range(3):
        weights = np.repeat(face_normals[:, axis], 3)
        normals[:, axis] = np.bincount(faces.ravel(), weights=weights, minlength=len(vertices))
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return normals / np.where(length > 0, length, 1)
