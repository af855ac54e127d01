"""A block swept, and how far the map lies from the true cylinder."""

import numpy as np

from pipeline.cable.dense import DenseOptions, sweep_block
from tests.cable import scene


def sweep(frames, orientation, folder, options=None, azimuth_deg=0.0, emit=scene.silent):
    return sweep_block(frames, orientation, azimuth_deg, options or DenseOptions(), emit, folder)


def error_mm(found):
    """Distance of every cell from the true cylinder about the y axis, whatever axis the map has."""
    azimuth, y_m = np.meshgrid(found.azimuth, found.y_m)
    points = found.axis.roll(azimuth.ravel(), y_m.ravel(), found.radius_m.ravel().astype(float))
    return 1000 * (np.hypot(points[:, 0], points[:, 2]) - scene.RADIUS_M).reshape(azimuth.shape)
