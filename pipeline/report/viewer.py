"""What the 3D view in the page needs: the mesh reduced to what a browser can bear, packed as text.

Takes a :class:`~pipeline.report.types.Mesh` and the stations, gives the JSON record that viewer.js reads.
Vertices are clustered in the texture (which is the unrolled surface, so a cell there is a cell on the cable),
never across its seam.
"""

import base64
import json
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pipeline.core.vocabulary import Array
from pipeline.report.pictures import data_address, jpeg_bytes, reduced
from pipeline.report.types import Mesh, Picture, StationResult

# Indices are stored in 16 bits.
MAX_VERTICES = 60_000
_MAX_TEXTURE_PX = 2048


@dataclass(frozen=True, kw_only=True)
class ViewerOptions:
    """How much of the model the page carries.

    Attributes:
        max_vertices: vertices after the reduction, at most 65 535.
        max_texture_px: longest side of the texture, pixels, a power of two.
        texture_quality: JPEG quality, 1 to 95.
    """

    max_vertices: int = MAX_VERTICES
    max_texture_px: int = _MAX_TEXTURE_PX
    texture_quality: int = 82

    def __post_init__(self) -> None:
        if not 4 <= self.max_vertices <= 65_535:
            raise ValueError(f"max_vertices is {self.max_vertices}, wanted 4 to 65535 (16-bit indices)")


def viewer_record(mesh: Mesh, stations: tuple[StationResult, ...], options: ViewerOptions) -> str:
    """The JSON text for the page: vertices in m (float32), normals (int8), uv and indices (uint16), rings."""
    small = reduced_mesh(mesh, options.max_vertices)
    normals = np.zeros((len(small.vertices), 4), dtype=np.int8)
    normals[:, :3] = np.rint(127 * small.normals)
    record = {
        "vertices": _packed(small.vertices.astype("<f4")),
        "normals": _packed(normals),
        "uv": _packed(np.rint(65535 * np.clip(small.uv, 0, 1)).astype("<u2")),
        "indices": _packed(small.faces.astype("<u2")),
        "texture": _texture_address(mesh.texture, options),
        "stations": [_ring(station) for station in stations if station.circle_radius_mm > 0],
    }
    # A "<" could end the script element that holds the record.
    return json.dumps(record, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")


def reduced_mesh(mesh: Mesh, max_vertices: int) -> Mesh:
    """The mesh with at most ``max_vertices`` vertices: those of one cell of the texture become their mean.

    Args:
        mesh: any textured mesh; given back as it is where it is small enough.
        max_vertices: at least 4.
    """
    if len(mesh.vertices) <= max_vertices:
        return mesh
    place_m = mesh.uv * _metres_per_uv(mesh)
    cell_m = float(np.sqrt(np.prod(np.ptp(place_m, axis=0)) / max_vertices))
    cluster, count = _clusters(place_m, cell_m)
    while count > max_vertices:
        cell_m *= 1.05
        cluster, count = _clusters(place_m, cell_m)
    weights = _weights(mesh, cluster, count)
    normals = _means(mesh.normals, cluster, weights, count)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    return Mesh(
        vertices=_means(mesh.vertices, cluster, weights, count),
        normals=normals,
        faces=_faces_between(cluster[mesh.faces]),
        uv=_means(mesh.uv, cluster, weights, count),
        texture=mesh.texture,
    )


def _metres_per_uv(mesh: Mesh) -> Array:
    """(2,) metres on the surface per unit of u and of v, by least squares over edges of the mesh."""
    some = mesh.faces[:: max(1, len(mesh.faces) // 5000)]
    start, end = np.concatenate([some[:, 0], some[:, 1]]), np.concatenate([some[:, 1], some[:, 2]])
    squared_m = np.sum((mesh.vertices[end] - mesh.vertices[start]) ** 2, axis=1)
    squared_uv = (mesh.uv[end] - mesh.uv[start]) ** 2
    solution = np.linalg.lstsq(squared_uv, squared_m, rcond=None)[0]
    return np.sqrt(np.maximum(solution, 1e-12))


def _clusters(place_m: Array, cell_m: float) -> tuple[NDArray[np.int64], int]:
    """Number of the cell that each vertex falls into, counted from 0 without gaps, and how many there are."""
    cells = np.floor((place_m - place_m.min(axis=0)) / cell_m).astype(np.int64)
    keys = cells[:, 0] * (cells[:, 1].max() + 1) + cells[:, 1]
    found, cluster = np.unique(keys, return_inverse=True)
    return cluster, len(found)


def _weights(mesh: Mesh, cluster: NDArray[np.int64], count: int) -> Array:
    """1 for the vertices (n,) that make their cluster's mean, else 0.

    Where a cell holds vertices of the mesh's rim only these count: a mean with the inner ones would draw the
    rim inward and open a slit along the seam.
    """
    edges = np.sort(np.concatenate([mesh.faces[:, pair] for pair in ([0, 1], [1, 2], [2, 0])]), axis=1)
    found, uses = np.unique(edges[:, 0].astype(np.int64) * len(cluster) + edges[:, 1], return_counts=True)
    open_edges = found[uses == 1]
    rank = np.zeros(len(cluster), dtype=np.int64)
    rank[open_edges // len(cluster)] = 1
    rank[open_edges % len(cluster)] = 1
    # A rim vertex with one or two triangles is a corner, and counts alone.
    rank[(rank == 1) & (np.bincount(mesh.faces.ravel(), minlength=len(cluster)) <= 2)] = 2
    highest = np.zeros(count, dtype=np.int64)
    np.maximum.at(highest, cluster, rank)
    return (rank == highest[cluster]).astype(np.float64)


def _means(values: Array, cluster: NDArray[np.int64], weights: Array, count: int) -> Array:
    sizes = np.bincount(cluster, weights=weights, minlength=count)
    columns = [np.bincount(cluster, weights=weights * column, minlength=count) for column in values.T]
    return np.stack(columns, axis=1) / sizes[:, None]


def _faces_between(corners: NDArray[np.int64]) -> NDArray[np.int64]:
    """The triangles (m, 3) that still have three different corners, each once, their sense kept."""
    a, b, c = corners.T
    kept = corners[(a != b) & (b != c) & (c != a)]
    first = np.argmin(kept, axis=1)
    turned = np.stack([kept[np.arange(len(kept)), (first + step) % 3] for step in range(3)], axis=1)
    return np.unique(turned, axis=0)


def _ring(station: StationResult) -> dict[str, Any]:
    x_mm, z_mm = station.circle_centre_mm
    return {
        "name": station.name,
        "text": f"{station.diameter_mm:.2f} mm",
        "centre": [x_mm / 1000, station.position_m, z_mm / 1000],
        "radius": station.circle_radius_mm / 1000,
    }


def _texture_address(texture: Picture, options: ViewerOptions) -> str:
    """The texture as JPEG, both sides a power of two: older WebGL smooths only such ones when far away."""
    image = reduced(texture, options.max_texture_px)
    width, height = (min(options.max_texture_px, 1 << (side - 1).bit_length()) for side in image.size)
    image = image.resize((width, height), Image.Resampling.LANCZOS)
    return data_address(jpeg_bytes(image, options.texture_quality), "image/jpeg")


def _packed(array: NDArray[Any]) -> str:
    return base64.b64encode(np.ascontiguousarray(array).tobytes()).decode("ascii")
