"""Cells of the unrolled surface, and where a frame sees them.

Takes an axis, azimuths and places along it, a lens and orientations; gives pixels and the values there.  A
rolling shutter sees each row from where the robot is when it is read.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.core.axis import AxisCurve
from pipeline.core.division import coefficient
from pipeline.core.vocabulary import Array, Lens, Poses

Image = NDArray[np.floating]
READOUT_ROUNDS = 2
"""The row that sees a cell hangs on the moment, and the moment on the row, but weakly."""


@dataclass(frozen=True, kw_only=True)
class SweepGrid:
    """Cells of the unrolled surface.

    Attributes:
        axis: the axis they are unrolled about.
        azimuth: (m,) radians, evenly spaced.
        y_m: (n,) metres, evenly spaced.
    """

    axis: AxisCurve
    azimuth: Array
    y_m: Array


def outward_of(grid: SweepGrid) -> Array:
    """Unit vectors from the axis through the cells of a row, (m, 3), in the cable frame."""
    return np.stack([np.cos(grid.azimuth), np.zeros_like(grid.azimuth), -np.sin(grid.azimuth)], axis=1)


class SurfaceView:
    """Looks up a grid's cells in one frame, for any radius."""

    def __init__(self, lens: Lens, poses: Poses, frame: int, grid: SweepGrid) -> None:
        rotation, translation = poses.rotations[frame], poses.translations[frame]
        self.frame = frame
        self._base = (grid.axis.at(grid.y_m) @ rotation.T + translation).T.astype(np.float32)[:, :, None]
        self._outward = (outward_of(grid) @ rotation.T).T.astype(np.float32)[:, None, :]
        self._rotation = rotation
        self._drift = (rotation[:, 1] * poses.readout_m).astype(np.float32)
        self._lens, self._k = lens, np.float32(coefficient(lens))

    def turned(self, vectors: Array) -> Array:
        """Vectors (n, m, 3) of the cable frame in this camera's, (3, n, m)."""
        return np.moveaxis(vectors @ self._rotation.T, -1, 0).astype(np.float32)

    def pixels(self, radius_m: Image, beside: Array | None = None) -> tuple[Image, Image]:
        """Where the cells lie in the frame, OpenCV's origin (centre of the first pixel).

        Args:
            radius_m: (n, m) of every cell, or several such at once, (k, n, m).
            beside: (3, n, m) or (3, k, n, m) to be added to the cells, metres, in the camera frame.
        """
        place = [base + radius_m * out for base, out in zip(self._base, self._outward, strict=True)]
        if beside is not None:
            for part, more in zip(place, beside, strict=True):
                part += more
        if not self._drift.any():
            return self._imaged(*place)
        row = self._imaged(*(part.copy() for part in place))[1]
        for _ in range(READOUT_ROUNDS):
            moment = (row + np.float32(0.5)) / np.float32(self._lens.height_px) - np.float32(0.5)
            moved = (part - way * moment for part, way in zip(place, self._drift, strict=True))
            column, row = self._imaged(*moved)
        return column, row

    def _imaged(self, u: Image, v: Image, z: Image) -> tuple[Image, Image]:
        """Pixels of points in the camera frame, metres; in place."""
        np.divide(np.float32(1), z, out=z)
        u *= z
        v *= z
        # distort: the root of k u d^2 - d + u = 0 that goes to u for k -> 0
        grow = u * u
        grow += v * v
        grow *= -4 * self._k
        grow += 1
        np.sqrt(np.maximum(grow, 0, out=grow), out=grow)
        grow += 1
        np.divide(np.float32(2 * self._lens.focal_px), grow, out=grow)
        cx, cy = self._lens.principal_point_px
        u *= grow
        u += np.float32(cx - 0.5)
        v *= grow
        v += np.float32(cy - 0.5)
        return u, v

    def visible(self, pixels: tuple[Image, Image], window: int) -> Image:
        """1 where the whole comparison window about a cell at ``pixels`` lies in the frame, else 0."""
        column, row = pixels
        inside = (column > 1) & (column < self._lens.width_px - 3) & (row > 1)
        inside &= row < self._lens.height_px - 3
        if window == 1:
            return inside.astype(np.float32)
        kernel = np.ones((window, window), dtype=np.uint8)
        return cv2.erode(inside.astype(np.uint8), kernel, borderValue=1).astype(np.float32)


def sample(image: Image, pixels: tuple[Image, Image], interpolation: int = cv2.INTER_CUBIC) -> Image:
    """A frame's values where the cells lie in it, (n, m) or (n, m, 3); ``interpolation`` is OpenCV's."""
    return np.asarray(cv2.remap(image, *pixels, interpolation), dtype=np.float32)
