"""Where the photos are taken, and with which lens: seeded, from the specification alone; no bpy."""

import math
from dataclasses import dataclass

import numpy as np

from pipeline.core.vocabulary import Array, Lens
from synth.scan.frame import plan_m
from synth.scan.spec import Photos, ScanSpec

FLIGHT_SEED = 241
DOWN = np.array([0.0, 0.0, -1.0])


@dataclass(frozen=True, kw_only=True)
class Shot:
    """A photo: cam_from_hall ``rotation`` (3, 3), and the projection ``centre`` (3,) in the hall."""

    name: str
    rotation: Array
    centre: Array


def shots(spec: ScanSpec, photos: Photos) -> tuple[Shot, ...]:
    """The flight: along x, back on the next strip, with the camera's right-hand side in flight direction."""
    rng = np.random.default_rng([spec.seed, FLIGHT_SEED])
    middle = np.array([*plan_m(spec.structure) / 2.0, spec.structure.height_m])
    altitude_m = spec.structure.height_m + spec.structure.depth_m + photos.height_m
    found: list[Shot] = []
    for strip, y in enumerate(_places(photos.count[1], photos.reach)):
        ahead = 1.0 if strip % 2 == 0 else -1.0
        for x in ahead * _places(photos.count[0], photos.reach):
            plan = middle[:2] * (1.0 + np.array([x, y]))
            centre = np.array([*plan, altitude_m]) + photos.jitter_m * rng.standard_normal(3)
            towards = (middle - centre) / np.linalg.norm(middle - centre)
            axis = (1.0 - photos.converge) * DOWN + photos.converge * towards
            sway = np.radians(photos.sway_deg) * rng.standard_normal(3)
            rotation = _about(sway) @ _looking(axis, np.array([ahead, 0.0, 0.0]))
            found.append(Shot(name=f"P{len(found) + 1:03}.png", rotation=rotation, centre=centre))
    return tuple(found)


def lens_of(photos: Photos) -> Lens:
    """The true lens: a pinhole."""
    return Lens(
        width_px=photos.width_px,
        height_px=photos.height_px,
        focal_px=photos.focal_px,
        principal_point_px=(photos.width_px / 2.0, photos.height_px / 2.0),
        division_lambda=0.0,
    )


def _places(count: int, reach: float) -> Array:
    """From -reach to reach."""
    return np.linspace(-reach, reach, count) if count > 1 else np.zeros(1)


def _looking(axis: Array, right: Array) -> Array:
    """cam_from_hall with z along the axis and x as near to ``right`` as can be."""
    z = axis / np.linalg.norm(axis)
    x = right - (right @ z) * z
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z])


def _about(vector: Array) -> Array:
    """Rotation about a vector by its length (Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross
