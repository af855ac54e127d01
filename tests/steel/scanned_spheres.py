"""A scanner simulated for the tests of targets: rays, spheres, a floor, a column, mixed edge pixels."""

import numpy as np

ARCSEC = np.pi / 180 / 3600


def scan(
    centres, radii, seed, *, step_deg=0.15, range_sigma_m=0.002, angle_sigma_rad=8 * ARCSEC, column=None
):
    """Points (n, 3) float32 in the station frame.

    Args:
        centres: (m, 3) of spheres; radii: (m,).
        seed: of the noise.
        step_deg: between rays.
        range_sigma_m, angle_sigma_rad: noise.
        column: (x, y, radius) of a vertical column.
    """
    rng = np.random.default_rng(seed)
    step = np.radians(step_deg)
    azimuth, elevation = np.meshgrid(
        np.arange(-np.pi, np.pi, step), np.arange(np.radians(-40), np.radians(40), step)
    )
    azimuth, elevation = azimuth.ravel(), elevation.ravel()
    rays = np.column_stack(
        [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
    )
    ranges = nearest(rays, centres, radii, column)
    # half of the beam falls beside: at an edge the range is drawn between both surfaces
    nearby = rays + 0.0003 * rng.normal(size=rays.shape)
    nearby /= np.linalg.norm(nearby, axis=1, keepdims=True)
    beside = nearest(nearby, centres, radii, column)
    with np.errstate(invalid="ignore"):
        edge = np.abs(beside - ranges) > 0.02
    share = rng.uniform(size=len(ranges))
    ranges = np.where(
        edge & np.isfinite(ranges) & np.isfinite(beside), share * ranges + (1 - share) * beside, ranges
    )
    ranges += rng.normal(scale=range_sigma_m, size=len(ranges))
    turned = rays + rng.normal(scale=angle_sigma_rad, size=rays.shape)
    turned /= np.linalg.norm(turned, axis=1, keepdims=True)
    hit = np.isfinite(ranges)
    return (turned[hit] * ranges[hit, None]).astype(np.float32)


def nearest(rays, centres, radii, column):
    """Ranges (n,) along unit rays from the origin; inf where nothing is hit."""
    # the floor, 1.6 m below, as far as 30 m
    with np.errstate(divide="ignore"):
        ranges = np.where(rays[:, 2] < 0, -1.6 / rays[:, 2], np.inf)
    ranges[ranges > 30] = np.inf
    for centre, radius in zip(centres, radii, strict=True):
        along = rays @ centre
        inside = radius**2 - (centre @ centre - along**2)
        hit = np.where((inside > 0) & (along > 0), along - np.sqrt(np.maximum(inside, 0)), np.inf)
        ranges = np.minimum(ranges, hit)
    if column is not None:
        x, y, radius = column
        flat2 = np.maximum(rays[:, 0] ** 2 + rays[:, 1] ** 2, 1e-12)
        along = (rays[:, 0] * x + rays[:, 1] * y) / flat2
        inside = along**2 - (x**2 + y**2 - radius**2) / flat2
        hit = np.where((inside > 0) & (along > 0), along - np.sqrt(np.maximum(inside, 0)), np.inf)
        ranges = np.minimum(ranges, hit)
    return ranges
