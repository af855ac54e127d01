"""Where a camera sees the cable: rays meet an upright cylinder about the y axis, surface points meet pixels.

Surface coordinates are (azimuth in radians, y in metres) in the cable frame; see the vocabulary.
"""

import numpy as np

from pipeline.core.division import pixels_to_rays, project
from pipeline.core.vocabulary import Array, Lens


def surface_points(azimuth: Array, y_m: Array, radius_m: Array | float) -> Array:
    """Points on the surface, (..., 3) metres in the cable frame."""
    radius = np.broadcast_to(radius_m, np.broadcast_shapes(azimuth.shape, y_m.shape))
    return np.stack(
        [radius * np.cos(azimuth), np.broadcast_to(y_m, radius.shape), -radius * np.sin(azimuth)], axis=-1
    )


def azimuths(points: Array) -> Array:
    """Azimuth of points in the cable frame, (..., 3) -> (...), radians."""
    return np.arctan2(-points[..., 2], points[..., 0])


def image_points(lens: Lens, rotation: Array, translation: Array, points: Array) -> Array:
    """Project (n, 3) cable points with one pose cam_from_world, (n, 2) pixels; NaN where not seen."""
    return project(lens, points @ rotation.T + translation)


def meet_cylinder(lens: Lens, rotation: Array, translation: Array, pixels: Array, radius_m: float) -> Array:
    """First intersection of the pixels' rays with the cylinder of that radius about the y axis.

    Args:
        lens: interior orientation.
        rotation, translation: cam_from_world.
        pixels: (n, 2).
        radius_m: of the cylinder.

    Returns:
        (n, 3) points in the cable frame, NaN where the ray misses.
    """
    rays = pixels_to_rays(lens, pixels)
    directions = np.concatenate([rays, np.ones((len(rays), 1))], axis=1) @ rotation
    centre = -rotation.T @ translation
    across = directions[:, [0, 2]]
    a = np.sum(across**2, axis=1)
    b = across @ centre[[0, 2]]
    c = centre[0] ** 2 + centre[2] ** 2 - radius_m**2
    root = np.sqrt(np.where(b**2 >= a * c, b**2 - a * c, np.nan))
    return centre + ((-b - root) / a)[:, None] * directions
