"""The joined surface as a textured mesh and as a coloured cloud.

Takes a :class:`~pipeline.cable.ring.Ring`; gives the report's Mesh and Cloud.  Texture coordinates are
analytic: the unrolled picture is the texture.
"""

import cv2
import numpy as np

from pipeline.cable.ring import Ring
from pipeline.core.mesh import mesh_of_grid
from pipeline.core.vocabulary import Array
from pipeline.report.types import Cloud, Mesh

MESH_MM = 1.0
VIEW_VERTICES = 60_000
"""So many a browser turns smoothly; with fewer than 65 536 an index takes 16 bits."""


def ring_mesh(ring: Ring, edge_mm: float = MESH_MM) -> Mesh:
    """The closed surface, thinned to triangles of about ``edge_mm``; holes stay open."""
    cell_mm = 1000 * float(ring.y_m[1] - ring.y_m[0])
    return _mesh(ring, max(round(edge_mm / cell_mm), 1))


def view_mesh(ring: Ring, most_vertices: int = VIEW_VERTICES) -> Mesh:
    """The closed surface, thinned to at most so many vertices, for the 3D view of a page."""
    rows, columns = ring.radius_m.shape
    step = max(int(np.sqrt(rows * columns / most_vertices)), 1)
    while -(-rows // step) * (-(-columns // step) + 1) > most_vertices:
        step += 1
    return _mesh(ring, step)


def _mesh(ring: Ring, step: int) -> Mesh:
    """Every ``step``-th cell of every ``step``-th row as a vertex."""
    known = np.isfinite(ring.radius_m)
    radius = _smooth_radius(ring, step)[::step, ::step]
    azimuth, y_m = ring.azimuth[::step], ring.y_m[::step]
    # one column more, at the place of the first: there the texture must end and begin
    azimuth = np.append(azimuth, azimuth[0] + 2 * np.pi)
    radius = np.concatenate([radius, radius[:, :1]], axis=1)
    stands = known[::step, ::step]
    stands = np.concatenate([stands, stands[:, :1]], axis=1)
    out = np.stack([np.cos(azimuth), 0 * azimuth, -np.sin(azimuth)], axis=1)
    points = radius[..., None] * out + np.array([0, 1, 0]) * y_m[:, None, None]
    mesh = mesh_of_grid(points.astype(np.float64), stands, np.broadcast_to(out, points.shape))
    row, column = np.divmod(mesh.cells, len(azimuth))
    return Mesh(
        vertices=mesh.vertices,
        normals=mesh.normals,
        faces=mesh.faces,
        uv=_texture_coordinates(ring, azimuth[column], y_m[row]),
        texture=np.ascontiguousarray(ring.picture[..., ::-1]),
    )


def ring_cloud(ring: Ring) -> Cloud:
    """Every measured cell as a point with normal and colour."""
    row, column = np.nonzero(np.isfinite(ring.radius_m) & ring.measured)
    out = np.stack([np.cos(ring.azimuth), 0 * ring.azimuth, -np.sin(ring.azimuth)], axis=1)
    points = ring.radius_m[row, column][:, None] * out[column]
    points[:, 1] = ring.y_m[row]
    slope = _slope_along(ring)[row, column]
    normals = out[column] - slope[:, None] * np.array([0.0, 1.0, 0.0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    uv = _texture_coordinates(ring, ring.azimuth[column], ring.y_m[row])
    height, width = ring.picture.shape[:2]
    x = np.clip((uv[:, 0] * width).astype(int), 0, width - 1)
    y = np.clip((uv[:, 1] * height).astype(int), 0, height - 1)
    return Cloud(points=points, normals=normals, colours=np.ascontiguousarray(ring.picture[y, x, ::-1]))


def _texture_coordinates(ring: Ring, azimuth: Array, y_m: Array) -> Array:
    """(n, 2) from the top-left corner of the unrolled picture, u right, v down, 0 to 1."""
    height, width = ring.picture.shape[:2]
    turn = ring.picture_azimuth[1] - ring.picture_azimuth[0]
    rise = ring.picture_y_m[1] - ring.picture_y_m[0]
    u = ((azimuth - ring.picture_azimuth[0]) / turn + 0.5) / width
    return np.stack([u, ((y_m - ring.picture_y_m[0]) / rise + 0.5) / height], axis=1)


def _slope_along(ring: Ring) -> Array:
    """Change of the radius along the cable over about 4 mm."""
    smooth = _smooth_radius(ring, 4)
    return np.asarray(np.gradient(smooth, float(ring.y_m[1] - ring.y_m[0]), axis=0), dtype=np.float64)


def _smooth_radius(ring: Ring, cells: float) -> np.ndarray:
    """Radius averaged over about so many cells, of the known ones alone; carried on a little into holes."""
    known = np.isfinite(ring.radius_m)
    middle = np.float32(np.nanmedian(ring.radius_m))
    weight = _blur_ring(known.astype(np.float32), cells)
    excess = _blur_ring(np.where(known, ring.radius_m - middle, 0).astype(np.float32), cells)
    return np.asarray(middle + excess / np.maximum(weight, 1e-6))


def _blur_ring(values: np.ndarray, cells: float) -> np.ndarray:
    """Average over about so many cells, closed around the cable."""
    pad = 4 * round(cells) + 1
    wide = np.concatenate([values[:, -pad:], values, values[:, :pad]], axis=1)
    return np.asarray(cv2.GaussianBlur(wide, (0, 0), cells / 2)[:, pad:-pad])
