"""The unrolled picture of the joined model: each block's picture, looked up through the block's coordinates.

Takes one block's picture, its placed points and its crop; adds its colours to the ring's texels, weighted by
how squarely it looked at the surface.  Leaves out dividing by the weights.
"""

import cv2
import numpy as np
from numpy.polynomial.polynomial import polygrid2d, polyvander2d
from numpy.typing import NDArray

from pipeline.cable.crop import Crop
from pipeline.cable.mosaic import MosaicBlock
from pipeline.core.vocabulary import Array

_SECOND_ORDER = [0, 1, 2, 3, 4, 6]
"""Of the nine products of a^0..2 and y^0..2, those of second order at most."""


def add_colour(
    points: Array,
    block: MosaicBlock,
    crop: Crop,
    square: Array,
    gain: float,
    azimuth: Array,
    y_m: Array,
    sums: tuple[NDArray[np.float32], NDArray[np.float32]],
) -> None:
    """Look the ring's texels up in one block's picture, through the block's own surface coordinates."""
    surface, picture = block.surface, block.picture
    columns = _columns_of(points[crop.keep], azimuth)
    turn, rise = _own_coordinates(points, surface.azimuth, surface.y_m, azimuth[columns], y_m)
    texel = _place_on(picture.azimuth, turn), _place_on(picture.y_m, rise)
    cell = _place_on(surface.azimuth, turn), _place_on(surface.y_m, rise)
    colour = cv2.remap(picture.colour, *texel, cv2.INTER_CUBIC)
    known = cv2.remap(picture.known.astype(np.float32), *texel, cv2.INTER_LINEAR) > 0.99
    keep = cv2.remap(crop.keep.astype(np.float32), *cell, cv2.INTER_LINEAR) > 0.5
    across = np.interp(cell[0], np.arange(len(square)), square, left=0, right=0).astype(np.float32)
    factor = across * (known & keep)
    sums[0][:, columns] += colour * (np.float32(gain) * factor)[..., None]
    sums[1][:, columns] += factor


def _columns_of(points: Array, azimuth: Array) -> NDArray[np.int64]:
    """Which of the ring's columns lie over the block's points (n, 3), the neighbours of the outermost too."""
    turn = np.arctan2(-points[:, 2], points[:, 0])
    middle = np.angle(np.exp(1j * turn).sum())
    half = np.abs(np.angle(np.exp(1j * (turn - middle)))).max() + 2 * (azimuth[1] - azimuth[0])
    return np.flatnonzero(np.abs(np.angle(np.exp(1j * (azimuth - middle)))) <= half)


def _place_on(grid: Array, values: Array) -> NDArray[np.float32]:
    """Where values lie on an even grid, counted in its steps; outside, a picture has nothing to give."""
    return ((values - grid[0]) / (grid[1] - grid[0])).astype(np.float32)


def _own_coordinates(
    points: Array, own_azimuth: Array, own_y: Array, azimuth: Array, y_m: Array
) -> tuple[Array, Array]:
    """The block's own azimuth and y at each texel of the ring, (p, q) each.

    The two coordinate systems differ by a small rigid motion, so their difference is smooth: it is fitted by
    a polynomial of second order on a sample of the block's cells.
    """
    rows = np.linspace(0, points.shape[0] - 1, 40).astype(int)
    columns = np.linspace(0, points.shape[1] - 1, 40).astype(int)
    sample = points[np.ix_(rows, columns)].reshape(-1, 3)
    turn, rise = (g.ravel() for g in np.meshgrid(own_azimuth[columns], own_y[rows]))
    good = np.isfinite(sample[:, 0])
    sample, turn, rise = sample[good], turn[good], rise[good]
    middle = own_azimuth.mean()
    around = middle + np.angle(np.exp(1j * (np.arctan2(-sample[:, 2], sample[:, 0]) - middle)))

    offsets = np.stack([turn - around, rise - sample[:, 1]], axis=1)
    centre_y = float(own_y.mean())
    second_order = polyvander2d(around - middle, sample[:, 1] - centre_y, [2, 2])[:, _SECOND_ORDER]
    fitted = np.zeros((9, 2))
    fitted[_SECOND_ORDER] = np.linalg.lstsq(second_order, offsets, rcond=None)[0]
    wide = middle + np.angle(np.exp(1j * (azimuth - middle)))
    away = polygrid2d(y_m - centre_y, wide - middle, fitted.reshape(3, 3, 2).swapaxes(0, 1))
    return wide + away[0], y_m[:, None] + away[1]


def brightness_factors(blocks: tuple[MosaicBlock, ...]) -> list[float]:
    """Brightness factors that bring every block's picture to the common mean."""
    means = [float(b.picture.colour[b.picture.known].mean()) for b in blocks]
    return [float(np.mean(means)) / max(m, 1.0) for m in means]
