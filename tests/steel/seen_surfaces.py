"""Points on the visible side of single cylinders and spheres, with range noise and mixed edge pixels.

As a scanner samples them: evenly across the line of sight, the noise along the ray.
"""

import numpy as np

from pipeline.steel.records import StationPose
from pipeline.steel.tile_records import SitePoints


def station(place, sigma_m=0.0, name="S"):
    """A station whose place is known to ``sigma_m`` in each direction."""
    covariance = np.diag([0.0, 0.0, 0.0, *[sigma_m**2] * 3])
    return StationPose(
        name=name, rotation=np.eye(3), translation=np.array(place, dtype=float), covariance=covariance
    )


def seen_cylinder(start, end, radius, stations, seed, count=4000, noise=0.002, mixed=0.0, widest=1.0):
    """``count`` points from each station; ``mixed``: share of them that fell past the rim; ``widest``: rays
    pass the axis by at most this share of the radius."""
    rng, axis = np.random.default_rng(seed), unit(np.asarray(end, dtype=float) - start)
    parts = []
    for pose in stations:
        across = rng.uniform(-widest, widest, count)
        on_axis = start + rng.random(count)[:, None] * (np.asarray(end) - start)
        towards = pose.translation - on_axis
        towards = unit(towards - (towards @ axis)[:, None] * axis)
        aside = np.cross(axis, towards)
        places = on_axis + radius * (across[:, None] * aside + np.sqrt(1 - across**2)[:, None] * towards)
        parts.append(measured(places, pose.translation, rng, noise, mixed * (np.abs(across) > 0.9)))
    return together(parts)


def seen_sphere(centre, radius, stations, seed, count=1000, noise=0.002, mixed=0.0):
    """``count`` points from each station."""
    rng, parts = np.random.default_rng(seed), []
    for pose in stations:
        towards = unit(pose.translation - np.asarray(centre))
        aside = unit(np.cross(towards, [0.3, 0.2, 0.9]))
        turn, out = rng.uniform(0, 2 * np.pi, count), np.sqrt(rng.random(count))
        normal = np.sqrt(1 - out**2)[:, None] * towards
        normal = normal + out[:, None] * (
            np.cos(turn)[:, None] * aside + np.sin(turn)[:, None] * np.cross(towards, aside)
        )
        parts.append(measured(centre + radius * normal, pose.translation, rng, noise, mixed * (out > 0.9)))
    return together(parts)


def measured(places, scanner, rng, noise, past):
    """Points with noise along their rays; with probability ``past`` they lie somewhere behind the edge."""
    behind = np.where(rng.random(len(places)) < past, rng.uniform(0.0, 0.05, len(places)), 0.0)
    return places + (rng.normal(0, noise, len(places)) + behind)[:, None] * unit(places - scanner)


def together(parts):
    numbers = np.repeat(np.arange(len(parts)), [len(p) for p in parts])
    return SitePoints(places=np.concatenate(parts), stations=numbers)


def unit(vectors):
    vectors = np.asarray(vectors, dtype=float)
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
