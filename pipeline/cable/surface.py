"""Stage *surface*: one block's radius map without gross errors, its small holes closed or kept by choice.

Takes the dense radius map; gives the surface that is textured, cropped and joined, and the TIN of it (paper,
section 2.4).  Leaves out colour.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.cable.dense import RadiusMap
from pipeline.cable.surface_view import Image
from pipeline.core.axis import AxisCurve
from pipeline.core.mesh import Mesh, mesh_of_grid
from pipeline.core.vocabulary import Array


@dataclass(frozen=True, kw_only=True)
class SurfaceOptions:
    """How the surface is cleaned.

    Attributes:
        outlier_mm: cells further than this from the median of their surroundings are dropped.
        surroundings_mm: side of the surroundings.
        fill_mm: holes up to this width are closed; 0 keeps every hole.
        mesh_mm: edge of the triangles.
    """

    outlier_mm: float = field(default=0.6, metadata={"above": 0.0})
    surroundings_mm: float = field(default=5.0, metadata={"above": 0.0})
    fill_mm: float = field(default=6.0, metadata={"minimum": 0.0})
    mesh_mm: float = field(default=1.0, metadata={"above": 0.0})


@dataclass(frozen=True, kw_only=True)
class BlockSurface:
    """The surface of one block about the block's own axis.

    Attributes:
        axis: of the block.
        azimuth: (m,) radians.
        y_m: (n,) metres.
        radius_m: (n, m), NaN in the holes that stay.
        measured: (n, m) bool, false where a hole was closed.
        score: (n, m) agreement of the frames.
    """

    axis: AxisCurve
    azimuth: Array
    y_m: Array
    radius_m: Image
    measured: NDArray[np.bool_]
    score: Image

    @cached_property
    def median_radius_m(self) -> float:
        """Median of all cells; kept, as a preview or a fit asks for it again and again."""
        return float(np.nanmedian(self.radius_m))

    @property
    def cell_m(self) -> tuple[float, float]:
        """Side of a cell along the cable and around it, metres."""
        around = (self.azimuth[1] - self.azimuth[0]) * self.median_radius_m
        return float(self.y_m[1] - self.y_m[0]), float(around)

    def points(self, rows: slice = slice(None), columns: slice = slice(None)) -> Array:
        """Surface points of the chosen cells in the cable frame, (n, m, 3) metres."""
        return self.axis.roll_grid(self.azimuth[columns], self.y_m[rows], self.radius_m[rows, columns])

    def outward(self) -> Array:
        """Unit vectors away from the axis, (1, m, 3)."""
        return np.stack([np.cos(self.azimuth), 0 * self.azimuth, -np.sin(self.azimuth)], axis=1)[None]


def build_surface(dense: RadiusMap, options: SurfaceOptions) -> BlockSurface:
    """Drop outliers and close small holes."""
    radius = np.asarray(dense.radius_m, dtype=np.float32)
    cell_mm = 1000 * float(dense.y_m[1] - dense.y_m[0])
    radius = _without_outliers(radius, cell_mm, options)
    measured = np.isfinite(radius)
    return BlockSurface(
        axis=dense.axis,
        azimuth=dense.azimuth,
        y_m=dense.y_m,
        radius_m=_close_holes(radius, cell_mm, options),
        measured=measured,
        score=dense.score,
    )


def mesh_surface(surface: BlockSurface, stands: NDArray[np.bool_], options: SurfaceOptions) -> Mesh:
    """The TIN of the cells that stand, (n, m) bool, thinned to the wanted edge length."""
    rows, columns = mesh_cells(surface, options)
    outward = np.broadcast_to(surface.outward(), (*stands.shape, 3))[rows, columns]
    points = smoothed(surface, options.mesh_mm).points(rows, columns)
    return mesh_of_grid(points, stands[rows, columns] & np.isfinite(points[..., 0]), outward)


def mesh_cells(surface: BlockSurface, options: SurfaceOptions) -> tuple[slice, slice]:
    """The rows and columns of cells that become vertices."""
    along_m, around_m = surface.cell_m
    rows = slice(None, None, max(round(options.mesh_mm / 1000 / along_m), 1))
    columns = slice(None, None, max(round(options.mesh_mm / 1000 / around_m), 1))
    return rows, columns


def smoothed(surface: BlockSurface, width_mm: float) -> BlockSurface:
    """The surface averaged over about ``width_mm``, holes left alone."""
    along_m, around_m = surface.cell_m
    sigma = (width_mm / 2000 / around_m, width_mm / 2000 / along_m)
    known = np.isfinite(surface.radius_m)
    middle = np.float32(surface.median_radius_m)
    excess = np.where(known, surface.radius_m - middle, 0).astype(np.float32)
    weight = cv2.GaussianBlur(known.astype(np.float32), (0, 0), sigmaX=sigma[0], sigmaY=sigma[1])
    total = cv2.GaussianBlur(excess, (0, 0), sigmaX=sigma[0], sigmaY=sigma[1])
    radius = np.where(known, middle + total / np.maximum(weight, 1e-6), np.nan)
    return replace(surface, radius_m=radius.astype(np.float32))


def _without_outliers(radius: Image, cell_mm: float, options: SurfaceOptions) -> Image:
    known = np.isfinite(radius)
    middle = np.float32(np.median(radius[known]))
    side = min(max(round(options.surroundings_mm / cell_mm) | 1, 3), 5)  # OpenCV: 5 is the most for floats
    step = max(round(options.surroundings_mm / cell_mm / side), 1)
    filled = np.where(known, radius, middle).astype(np.float32)
    local = np.empty_like(filled)
    for row in range(step):  # a median of cells ``step`` apart spans the surroundings
        for column in range(step):
            part = np.ascontiguousarray(filled[row::step, column::step])
            local[row::step, column::step] = cv2.medianBlur(part, side)
    with np.errstate(invalid="ignore"):
        far = np.abs(radius - local) > options.outlier_mm / 1000
    return np.where(far, np.nan, radius).astype(np.float32)


def _close_holes(radius: Image, cell_mm: float, options: SurfaceOptions) -> Image:
    """Fill narrow holes from their rims; what lies open to the border of the map is no hole."""
    known = np.isfinite(radius)
    width = round(options.fill_mm / cell_mm)
    if width < 1:
        return radius
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (width | 1, width | 1))
    padded = cv2.copyMakeBorder(known.astype(np.uint8), width, width, width, width, cv2.BORDER_CONSTANT)
    _, region = cv2.connectedComponents(1 - padded, connectivity=4)
    closed = (cv2.morphologyEx(padded, cv2.MORPH_CLOSE, kernel) > 0) & (region != region[0, 0])
    hole = closed[width:-width, width:-width] & ~known
    if not hole.any():
        return radius
    middle = np.float32(np.median(radius[known]))
    excess = np.where(known, radius - middle, 0).astype(np.float32)
    weight, total = known.astype(np.float32), excess
    filled = np.full_like(radius, np.nan)
    sigma = 1.0
    while np.isnan(filled[hole]).any() and sigma <= 2 * width:
        near = cv2.GaussianBlur(weight, (0, 0), sigma)
        value = cv2.GaussianBlur(total, (0, 0), sigma) / np.maximum(near, 1e-9)
        fresh = hole & np.isnan(filled) & (near > 0.05)
        filled[fresh] = middle + value[fresh]
        sigma *= 2
    return np.where(known, radius, filled).astype(np.float32)
