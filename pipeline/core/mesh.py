"""Triangulated irregular networks cut from a regular grid of surface points.

Takes an (n, m) grid of points with a mask; gives the triangles whose corners all stand, without unused
points.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.core.vocabulary import Array

FACES_PER_RUN = 200_000


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
    index = np.arange(rows * columns, dtype=np.int32).reshape(rows, columns)
    corner_stands = stands
    if closed:
        index, corner_stands = (np.concatenate([g, g[:, :1]], axis=1) for g in (index, stands))
    a, b, c, d = (
        (index[part], corner_stands[part])
        for part in (np.s_[:-1, :-1], np.s_[:-1, 1:], np.s_[1:, 1:], np.s_[1:, :-1])
    )
    faces = np.concatenate([_triangles(a, c, b), _triangles(a, d, c)])
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


def _triangles(*corners: tuple[NDArray[np.int32], NDArray[np.bool_]]) -> NDArray[np.int32]:
    """The triangles (f, 3) whose three corners, given with whether they stand, all do."""
    whole = np.logical_and.reduce([stands for _, stands in corners])
    return np.stack([index[whole] for index, _ in corners], axis=1)


def _normals(vertices: Array, faces: NDArray[np.int32]) -> Array:
    """Area-weighted vertex normals, summed over runs of faces, which are neighbours: memory stays small."""
    normals = np.zeros_like(vertices)
    for start in range(0, len(faces), FACES_PER_RUN):
        run = faces[start : start + FACES_PER_RUN]
        first, last = int(run.min()), int(run.max()) + 1
        corner = vertices[run[:, 0]]
        face_normals = np.cross(vertices[run[:, 1]] - corner, vertices[run[:, 2]] - corner)
        for axis in range(3):
            weights = np.repeat(face_normals[:, axis], 3)
            normals[first:last, axis] += np.bincount((run - first).ravel(), weights, last - first)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return normals / np.where(length > 0, length, 1)
