"""A cable with known dents, the run folder that it would leave, and a scan of it in a room; all analytic."""

import json

import numpy as np
from scipy.ndimage import gaussian_filter

from pipeline.core.rotations import rotation_from_vector
from pipeline.report.ply import cloud_ply_bytes
from pipeline.report.types import Cloud

RADIUS, FIRST, LAST = 0.055, 0.0, 0.46
MARKS = ((0.0015, 0.4, 0.10, 0.012), (-0.001, 2.2, 0.21, 0.015), (0.001, 4.3, 0.38, 0.010))
"""Height, azimuth, place along and size of bulges and dents; metres, radians."""
STATIONS = (("A", 0.1), ("B", 0.23), ("C", 0.37))


def dents(azimuth, y):
    """Height over the tube, metres: one bulge, two dents, none a mirror image of another."""
    total = np.zeros(np.broadcast(azimuth, y).shape)
    for height, at, place, size in (
        (0.0015, 0.4, 0.10, 0.012),
        (-0.001, 2.2, 0.21, 0.015),
        (0.001, 4.3, 0.38, 0.01),
    ):
        around = RADIUS * ((azimuth - at + np.pi) % (2 * np.pi) - np.pi)
        total = total + height * np.exp(-(around**2 + (y - place) ** 2) / (2 * size**2))
    return total


def ribs(azimuth, y, pitch=0.6):
    """A double helix, 2 mm high."""
    phase = (azimuth - 2 * np.pi * y / pitch) % np.pi
    away = RADIUS * np.minimum(phase, np.pi - phase)
    return 0.002 * np.exp(-(away**2) / (2 * 0.004**2))


def smooth(azimuth, y):
    """Nothing on it."""
    return np.zeros(np.broadcast(azimuth, y).shape)


def outward(azimuth):
    """(n, 3) unit vectors of the cable frame's azimuths."""
    return np.stack([np.cos(azimuth), np.zeros(len(azimuth)), -np.sin(azimuth)], axis=1)


def surface(form, azimuth, y, off=0.0):
    """(n, 3) points on the cable, ``off`` metres outside."""
    places = (RADIUS + form(azimuth, y) + off)[:, None] * outward(azimuth)
    places[:, 1] = y
    return places


def normals(form, azimuth, y, step=1e-4):
    """(n, 3) unit normals of the surface, by finite differences."""
    around = (form(azimuth + step, y) - form(azimuth - step, y)) / (2 * step * RADIUS)
    along = (form(azimuth, y + step) - form(azimuth, y - step)) / (2 * step)
    tangent = np.stack([-np.sin(azimuth), np.zeros(len(azimuth)), -np.cos(azimuth)], axis=1)
    found = outward(azimuth) - around[:, None] * tangent - along[:, None] * [0.0, 1.0, 0.0]
    return found / np.linalg.norm(found, axis=1, keepdims=True)


def paint(azimuth, y, seed=3):
    """Grey of a pattern of patches some millimetres wide, 0 to 255."""
    rng = np.random.default_rng(seed)
    pattern = gaussian_filter(rng.normal(size=(180, 800)), 1.5, mode=("wrap", "nearest"))
    cell = (np.degrees(azimuth) // 2).astype(int) % 180, np.clip(((y + 0.2) * 1000).astype(int), 0, 799)
    return np.clip(128 + 40 * pattern[cell] / pattern.std(), 0, 255)


def write_run(folder, form, seed=0, photo_scale=1.0, painted=False):
    """What a finished run leaves: cloud.ply, radius_map.npz, report.json; too large by ``photo_scale``."""
    folder.mkdir(parents=True)
    rng = np.random.default_rng(seed)
    azimuth, y = rng.uniform(0, 2 * np.pi, 80_000), rng.uniform(FIRST, LAST, 80_000)
    points = photo_scale * surface(form, azimuth, y, 3e-5 * rng.normal(size=len(y)))
    grey = np.full((len(y), 3), 128, dtype=np.uint8)
    if painted:
        grey[:] = paint(azimuth, y)[:, None]
    cloud = Cloud(points=points, normals=normals(form, azimuth, y), colours=grey)
    (folder / "cloud.ply").write_bytes(cloud_ply_bytes(cloud))
    theta, along = np.arange(0.0, 360.0, 1.0), np.arange(FIRST, LAST, 0.001)
    radius = 1000 * photo_scale * (RADIUS + form(np.radians(theta)[None], along[:, None]))
    np.savez(
        folder / "radius_map.npz",
        theta_deg=theta,
        position_m=photo_scale * along,
        radius_mm=radius.astype(np.float32),
    )
    stations = [
        {
            "name": name,
            "position_m": place,
            "diameter_mm": diameter_mm(form, place, photo_scale),
            "sigma_mm": 0.01,
        }
        for name, place in STATIONS
    ]
    (folder / "report.json").write_text(json.dumps({"name": "cable", "stations": stations}))
    return folder


def diameter_mm(form, place, scale=1.0):
    """Mean diameter within 20 mm of a place."""
    azimuth, y = np.meshgrid(
        np.linspace(0, 2 * np.pi, 360, endpoint=False), place + np.linspace(-0.02, 0.02, 41)
    )
    return float(2000 * scale * (RADIUS + form(azimuth, y)).mean())


def placement(seed):
    """Rotation and translation that bring the cable into the scan."""
    rng = np.random.default_rng(seed)
    return rotation_from_vector(rng.normal(0, 1.2, 3)), rng.uniform(-2, 2, 3)


def scanned(form, seed, noise_m=0.0005, first=-0.15, last=0.6, azimuths=(0.0, 2 * np.pi), room=True):
    """(n, 3) points of the cable (which goes on beyond what was filmed) and of the room around it."""
    rng = np.random.default_rng(seed + 500)
    count = 70_000
    azimuth, y = rng.uniform(*azimuths, count), rng.uniform(first, last, count)
    rotation, move = placement(seed)
    cable = surface(form, azimuth, y, noise_m * rng.normal(size=count)) @ rotation.T + move
    if not room:
        return cable
    x, z = rng.uniform(-2, 2, (2, 60_000))
    floor = np.column_stack([x, z, np.full(len(x), -1.5)]) + move
    wall = np.column_stack([np.full(len(x), 2.0), x, z]) + move
    turn, height = rng.uniform(0, 2 * np.pi, 20_000), rng.uniform(-1.5, 1.5, 20_000)
    pipe = np.column_stack([0.09 * np.cos(turn) + 1.2, 0.09 * np.sin(turn) - 1.0, height]) + move
    others = np.concatenate([floor, wall, pipe])
    return np.concatenate([cable, others + noise_m * rng.normal(size=others.shape)])


def painted_scan(form, seed, noise_m=0.0005):
    """(n, 4) points of the cable alone, and how bright each came back, with the scanner's noise."""
    rng = np.random.default_rng(seed + 500)
    azimuth, y = rng.uniform(0, 2 * np.pi, 70_000), rng.uniform(-0.15, 0.6, 70_000)
    rotation, move = placement(seed)
    points = surface(form, azimuth, y, noise_m * rng.normal(size=len(y))) @ rotation.T + move
    return np.column_stack([points, 0.003 * paint(azimuth, y) + rng.normal(scale=0.05, size=len(y))])
