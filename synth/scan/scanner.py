"""A virtual terrestrial scanner: rays, noise, mixed edge pixels and losses; points in the station's frame.

The world is met along the true directions; the instrument reports the nominal angles, so angle noise turns
every point about the scanner.  Azimuth and elevation get independent noise, as from two encoders.
"""

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.core.vocabulary import Array
from synth.scan.panorama import Canvas, Grid, Pieces, cast, cast_beams, cut
from synth.scan.primitives import World
from synth.scan.spec import Scanner

RAYS_PER_BAND = 400_000
SCAN_SEED = 221
NOISE_REACH = 6.0  # sigmas; noise is cut there, so that the windows hold all rays
WEAKEST = 0.25  # least share of a beam that comes back


@dataclass(frozen=True, kw_only=True)
class Band:
    """Part of a station's cloud.

    Attributes:
        points: (n, 3) metres, station frame.
        intensity: (n,) 0..1.
        owner: (n,) of what the ray's axis met, index into the world's names; -1 where only its rim met any.
        mixed: (n,) whether the beam met surfaces at different ranges.
        rays: cast, sub-rays not counted.
        seconds: taken.
        share: of the station's rays that are done, this band included.
    """

    points: Array
    intensity: Array
    owner: NDArray[np.int64]
    mixed: NDArray[np.bool_]
    rays: int
    seconds: float
    share: float


def scan(world: World, scanner: Scanner, seed: tuple[int, ...]) -> Iterator[Band]:
    """Scan once round.

    Args:
        world: in the station's frame.
        scanner: the instrument.
        seed: of the noise.
    """
    azimuth, elevation = angles(scanner)
    pieces = cut(world, scanner.max_range_m)
    height = max(1, RAYS_PER_BAND // len(azimuth))
    for number, first in enumerate(range(0, len(elevation), height)):
        grid = Grid(azimuth=azimuth, elevation=elevation[first : first + height])
        rng = np.random.default_rng([*seed, SCAN_SEED, number])
        share = min(1.0, (first + height) / len(elevation))
        yield _band(world, pieces, scanner, grid, rng, share)


def angles(scanner: Scanner) -> tuple[Array, Array]:
    """Azimuths (w,) and elevations (h,) of the rays, radians; the step divides the circle evenly."""
    count = round(360.0 / scanner.step_deg)
    azimuth = 2.0 * math.pi * np.arange(count) / count
    low_deg, high_deg = scanner.elevation_deg
    rows = math.floor((high_deg - low_deg) / scanner.step_deg + 1e-9) + 1
    return azimuth, np.radians(low_deg + scanner.step_deg * np.arange(rows))


def directions_of(azimuth: Array, elevation: Array) -> Array:
    """(..., 3) unit vectors."""
    flat = np.cos(elevation)
    return np.stack(
        np.broadcast_arrays(flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)), axis=-1
    )


def _band(
    world: World, pieces: Pieces, scanner: Scanner, grid: Grid, rng: np.random.Generator, share: float
) -> Band:
    started = time.perf_counter()
    shape = (len(grid.elevation), len(grid.azimuth))
    sigma = math.radians(scanner.angle_sigma_arcsec / 3600.0)
    off = sigma * np.clip(rng.standard_normal((2, *shape)), -NOISE_REACH, NOISE_REACH)
    azimuth, elevation = grid.azimuth[None, :] + off[0], grid.elevation[:, None] + off[1]
    directions = directions_of(azimuth, elevation)
    beam, pad = scanner.divergence_mrad / 2000.0, NOISE_REACH * sigma
    canvas = cast(world, pieces, grid, directions, pad, beam)
    range_m, energy, mixed = canvas.range_m.copy(), np.ones(shape), np.zeros(shape, bool)
    if np.any(canvas.edge):
        beams = _beams(directions[canvas.edge], beam, scanner.sub_rays)
        ranges = cast_beams(world, pieces, grid, canvas.edge, beams, pad + beam)
        range_m[canvas.edge], energy[canvas.edge], mixed[canvas.edge] = _mix(ranges, scanner.max_range_m)
    kept = _kept(canvas, range_m, energy, mixed, scanner)
    noise_m = scanner.range_sigma_mm / 1000.0 * rng.standard_normal(shape)
    nominal = directions_of(grid.azimuth[None, :], grid.elevation[:, None])
    reflectance = np.append(world.reflectance, world.reflectance.mean())[canvas.owner]
    for relief in world.relief:
        mine = (canvas.owner == relief.owner) & np.isfinite(range_m)
        reflectance[mine] = relief.albedo(range_m[mine, None] * directions[mine])
    cosine = np.where(canvas.owner >= 0, canvas.cosine, 0.5)
    return Band(
        points=(range_m + noise_m)[kept][:, None] * nominal[kept],
        intensity=np.clip(energy * reflectance * (0.2 + 0.8 * cosine), 0.0, 1.0)[kept],
        owner=canvas.owner[kept],
        mixed=mixed[kept],
        rays=range_m.size,
        seconds=time.perf_counter() - started,
        share=share,
    )


def _beams(directions: Array, half_angle: float, count: int) -> Array:
    """(n, k, 3) unit directions spread evenly over each beam's cross-section (a sunflower's pattern)."""
    k = np.arange(count)
    radius = half_angle * np.sqrt((k + 0.5) / count)
    turn = k * math.pi * (3.0 - math.sqrt(5.0))
    helper = np.where(np.abs(directions[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    u = np.cross(directions, helper)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v = np.cross(directions, u)
    rays = (
        directions[:, None]
        + (radius * np.cos(turn))[None, :, None] * u[:, None]
        + (radius * np.sin(turn))[None, :, None] * v[:, None]
    )
    return np.asarray(rays / np.linalg.norm(rays, axis=2, keepdims=True))


def _mix(ranges: Array, reach_m: float) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Mean range of what came back, its share of the beam, and whether ranges differed by 5 mm or more."""
    back = ranges <= reach_m
    count = back.sum(axis=1)
    known = np.where(back, ranges, 0.0)
    mean = np.where(count > 0, known.sum(axis=1) / np.maximum(count, 1), np.inf)
    spread = np.where(back, ranges, -np.inf).max(axis=1) - np.where(back, ranges, np.inf).min(axis=1)
    return mean, count / ranges.shape[1], (count > 0) & (spread > 0.005)


def _kept(
    canvas: Canvas, range_m: Array, energy: Array, mixed: NDArray[np.bool_], scanner: Scanner
) -> NDArray[np.bool_]:
    """What is strong, near and steep enough to be measured; a mixed pixel has light from elsewhere too."""
    steep = canvas.cosine >= math.cos(math.radians(scanner.incidence_limit_deg))
    steep |= mixed | (canvas.owner < 0)
    near = (range_m >= scanner.min_range_m) & (range_m <= scanner.max_range_m)
    return np.asarray(near & steep & (energy >= WEAKEST))
