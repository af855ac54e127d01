"""Pictures that show the lens: the distortion grid and a frame before and after (paper, figures 2 and 3).

Takes the lens and a frame; gives uint8 pictures (h, w, 3) in OpenCV's order blue-green-red.  Writes nothing.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.core.division import rays_to_pixels, undistorted_lens, undistortion_maps
from pipeline.core.vocabulary import Array, Lens

Image = NDArray[np.uint8]

GREY = (170, 170, 170)
BLUE = (178, 114, 0)
"""Readable for the colour-blind, blue-green-red."""
SUBPIXEL_BITS = 4


def distortion_grid_picture(lens: Lens, cells: int = 16, width_px: int = 960) -> Image:
    """Figure 2: an even grid as a pinhole camera sees it (grey) and as this lens does (blue).

    Args:
        lens: the lens; its focal length and principal point hold for both grids.
        cells: cells across the picture.
        width_px: width of the picture drawn.
    """
    scale = width_px / lens.width_px
    height_px = round(lens.height_px * scale)
    picture = np.full((height_px, width_px, 3), 255, np.uint8)
    straight = _grid_lines(lens, cells, 40 * cells)
    for line in straight:
        _draw(picture, line * scale, GREY)
    for line in _as_seen(lens, straight):
        _draw(picture, line * scale, BLUE)
    return picture


def before_after_picture(frame: Image, lens: Lens, cells: int = 0) -> tuple[Image, Image]:
    """Figure 3: a frame as taken and as a pinhole camera would have taken it, both on the same canvas.

    Args:
        frame: (h, w, 3) of the lens's size.
        lens: its lens.
        cells: cells across the picture of a grid that is straight where distortion is gone, drawn on both; 0
            draws none.
    """
    pinhole = undistorted_lens(lens)
    after = cv2.remap(frame, *undistortion_maps(lens, pinhole), cv2.INTER_CUBIC, borderValue=(255, 255, 255))
    before = np.full_like(after, 255)
    left = round(pinhole.principal_point_px[0] - lens.principal_point_px[0])
    top = round(pinhole.principal_point_px[1] - lens.principal_point_px[1])
    inside = before[top : top + lens.height_px, left : left + lens.width_px]
    inside[:] = frame
    after = np.asarray(after, dtype=np.uint8)
    if cells:
        straight = _grid_lines(lens, cells, 16 * cells)
        for line in _as_seen(lens, straight):
            _draw(inside, line, BLUE)
        for line in straight:
            _draw(after, line + np.array([left, top]), BLUE)
    return before, after


def _grid_lines(lens: Lens, cells: int, points: int) -> Array:
    """(lines, points, 2) of an even grid as a pinhole camera with this focal length sees it."""
    spacing, centre = lens.width_px / cells, np.array(lens.principal_point_px)
    # beyond the picture's border too: barrel distortion brings that part into view
    along = np.linspace(-lens.width_px, 2 * lens.width_px, points)
    across = centre % spacing + np.arange(-cells, 2 * cells + 1)[:, None] * spacing
    upright = np.stack(np.broadcast_arrays(across[:, :1], along), axis=-1)
    level = np.stack(np.broadcast_arrays(along, across[:, 1:]), axis=-1)
    return np.stack([upright, level], axis=1).reshape(-1, points, 2)


def _as_seen(lens: Lens, straight: Array) -> Array:
    """The same lines through the lens."""
    return rays_to_pixels(lens, (straight - lens.principal_point_px) / lens.focal_px)


def _draw(picture: Image, points: Array, colour: tuple[int, int, int]) -> None:
    """Smooth polyline through (n, 2) points, our pixel origin; gaps where a point is not seen."""
    near = np.isfinite(points).all(axis=1) & (np.abs(points) < 8 * max(picture.shape)).all(axis=1)
    for piece in np.split(np.arange(len(points)), np.flatnonzero(~near)):
        seen = piece[near[piece]]
        if len(seen) > 1:
            # our origin is the first pixel's corner, OpenCV's its centre
            fixed = np.round((points[seen] - 0.5) * 2**SUBPIXEL_BITS).astype(np.int32)
            cv2.polylines(picture, [fixed], False, colour, 1, cv2.LINE_AA, SUBPIXEL_BITS)
