"""A little scene and its photos, ray by ray in numpy: truth by an independent hand.

A textured floor, a block on it and white balls, seen by a pinhole; camera x right, y down, z forward.
"""

import numpy as np
from scipy.ndimage import gaussian_filter, map_coordinates

BLOCK = (np.array([0.3, 0.2, 0.0]), np.array([1.1, 0.9, 0.5]))


class Scene:
    """Metres, z up.  ``balls``: (k, 4) centres and radii."""

    def __init__(self, seed=0, balls=()):
        rng = np.random.default_rng(seed)
        fine, coarse = (gaussian_filter(rng.normal(size=(1400, 1400)), s) for s in (1.2, 5))
        self.texture = 110 + 35 * fine / fine.std() * 0.6 + 25 * coarse / coarse.std()
        self.balls = np.array(balls, dtype=float).reshape(-1, 4)

    def photo(self, rotation, centre, focal=500.0, width=480, height=320, noise=1.0, seed=0):
        """Grey picture (h, w) uint8, and the depth (h, w) along the camera's z."""
        column, row = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
        ray = np.stack([(column - width / 2) / focal, (row - height / 2) / focal, np.ones_like(row)], axis=-1)
        ray = ray @ rotation
        depth = -centre[2] / ray[..., 2]
        value = self._look(centre + depth[..., None] * ray)
        with np.errstate(divide="ignore", invalid="ignore"):
            a, b = (BLOCK[0] - centre) / ray, (BLOCK[1] - centre) / ray
        first, last = np.minimum(a, b).max(axis=-1), np.maximum(a, b).min(axis=-1)
        hit = (first < last) & (first > 0) & (first < depth)
        depth = np.where(hit, first, depth)
        place = centre + depth[..., None] * ray
        value = np.where(hit, self._look(place[..., [0, 2, 1]] + place[..., [2, 1, 0]] + 2.0), value)
        for *middle, radius in self.balls:
            away, square = np.asarray(middle) - centre, np.sum(ray**2, axis=-1)
            along = ray @ away
            inside = along**2 - square * (away @ away - radius**2)
            near = (along - np.sqrt(np.maximum(inside, 0))) / square
            hit = (inside > 0) & (near < depth)
            depth, value = np.where(hit, near, depth), np.where(hit, 245.0, value)
        value = gaussian_filter(value, 0.5) + noise * np.random.default_rng(seed).normal(size=value.shape)
        return np.clip(value, 0, 255).astype(np.uint8), depth

    def _look(self, place):
        return map_coordinates(
            self.texture, [(place[..., 0] + 3) * 220, (place[..., 1] + 3) * 220], order=1, mode="wrap"
        )


def looking_down(centre, aim):
    """cam_from_world rotation of a camera that looks from ``centre`` at ``aim``."""
    forward = np.asarray(aim, dtype=float) - centre
    forward /= np.linalg.norm(forward)
    right = np.cross([0.0, 1.0, 0.0], forward)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(forward, right), forward])


def flight(count=6, height=3.0):
    """Centres (n, 3) and rotations (n, 3, 3) of two strips of photos."""
    rng = np.random.default_rng(7)
    centres = np.array([[0.55 * (k % 3) - 0.1, 0.6 * (k // 3), height] for k in range(count)])
    centres += rng.normal(0, 0.05, centres.shape)
    return centres, np.array([looking_down(c, [0.5 + 0.2 * (c[0] - 0.5), 0.4, 0.1]) for c in centres])
