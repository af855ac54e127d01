"""Measurements of tie points on a round cable, as the robot of a specification would see them; no picture.

Takes a specification of synth; gives measurements and the true rig's nominal.  Motion, mountings and lens are
synth's own (the independent hand); leaves out texture and matching, whose errors are drawn.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.core.rig import Observations
from pipeline.core.vocabulary import Array, Lens, Poses
from synth.lens import block_lenses, project
from synth.motion import block_poses
from synth.spec import Spec

Indices = NDArray[np.int64]

RADIUS_M = 0.0555
LIMB_DEG = 50.0
BORDER_PX = 12.0
MARGIN_M = 0.05
BETWEEN_DEG = 6.0
"""Half width of the strip between two neighbours in which marks are shared."""


@dataclass(frozen=True, kw_only=True)
class Simulation:
    """A survey as the adjustment gets it.

    Attributes:
        spec: what was simulated.
        cameras: number of cameras that take part.
        observations: measurements, noise included; those of shared marks are loose.
        starts: (m, 3) places of the points on the nominal cable, metres.
        lens: the true lens.
    """

    spec: Spec
    cameras: int
    observations: Observations
    starts: Array
    lens: Lens


@dataclass(frozen=True, kw_only=True)
class Noise:
    """Errors of the measurements, standard deviations.

    Attributes:
        tracking_px: of every measurement.
        matching_px: of a mark's place in the second block, alike in all its measurements there.
    """

    tracking_px: float = 0.1
    matching_px: float = 0.6


def simulate(spec: Spec, cameras: int, points: int, marks: int, noise: Noise | None = None) -> Simulation:
    """Simulate a survey.

    Args:
        spec: motion, mountings, lens and seed.
        cameras: the first so many take part; one is a strip alone.
        points: tie points of each camera.
        marks: shared by each two neighbours.
        noise: of the measurements.
    """
    noise = noise or Noise()
    rng = np.random.default_rng([spec.seed, 1])
    azimuths = np.radians(spec.angles_deg[:cameras])
    views = [_View(poses, lens) for poses, lens in zip(block_poses(spec), block_lenses(spec), strict=True)]
    travel_m = spec.robot.travel_m
    places, rows = [], []

    def see(number: int, camera: int, place: Array, offset: Array, looseness: float) -> None:
        frame, point, pixels = views[camera].observe(place)
        pixels = pixels + offset[point] + rng.normal(0, noise.tracking_px, pixels.shape)
        rows.append((frame, np.full(len(frame), camera), number + point, pixels, looseness))

    count = 0
    for camera, azimuth in enumerate(azimuths):
        place = _on_cable(rng, azimuth, LIMB_DEG, points, travel_m)
        see(count, camera, place, np.zeros((points, 2)), 1.0)
        places.append(place)
        count += points
    for camera in range(cameras if cameras > 2 else 0):
        place = _on_cable(rng, azimuths[camera] + np.pi / cameras, BETWEEN_DEG, marks, travel_m)
        looseness = noise.matching_px / noise.tracking_px
        see(count, camera, place, np.zeros((marks, 2)), looseness)
        offset = rng.normal(0, noise.matching_px, (marks, 2))
        see(count, (camera + 1) % cameras, place, offset, looseness)
        places.append(place)
        count += marks
    frame, camera_of, point, pixels = (np.concatenate([row[n] for row in rows]) for n in range(4))
    return Simulation(
        spec=spec,
        cameras=cameras,
        observations=Observations(
            frame=frame,
            camera=camera_of,
            point=point,
            pixels=pixels,
            looseness=np.concatenate([np.full(len(row[0]), row[4]) for row in rows]),
        ),
        starts=np.concatenate(places),
        lens=views[0].lens,
    )


@dataclass(frozen=True)
class _View:
    """One camera's way along the cable."""

    poses: Poses
    lens: Lens

    def observe(self, points: Array) -> tuple[Indices, Indices, Array]:
        """Frame, point and exact pixel of every sight of the points."""
        in_camera = np.einsum("fij,mj->fmi", self.poses.rotations, points)
        pixels = project(self.lens, in_camera + self.poses.translations[:, None])
        size = np.array([self.lens.width_px, self.lens.height_px])
        inside = (pixels > BORDER_PX) & (pixels < size - BORDER_PX)
        frame, point = np.argwhere(inside.all(axis=2)).T
        return frame, point, pixels[frame, point]


def _on_cable(rng: np.random.Generator, middle: float, half_deg: float, count: int, travel_m: float) -> Array:
    """Random places (count, 3) on the cable about an azimuth, numbered along it."""
    azimuth = middle + np.radians(rng.uniform(-half_deg, half_deg, count))
    y = np.sort(rng.uniform(-MARGIN_M, travel_m + MARGIN_M, count))
    return np.stack([RADIUS_M * np.cos(azimuth), y, -RADIUS_M * np.sin(azimuth)], axis=1)
