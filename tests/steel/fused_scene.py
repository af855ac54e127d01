"""A small steel scene sampled analytically, seen from above by photos and from below by scanners."""

import numpy as np

from pipeline.core.rotations import rotation_from_vector
from pipeline.steel.fuse_records import PhotoCloud, ScanCloud
from pipeline.steel.records import Feature, FeatureKind

SCALE, TURN, MOVE = 6.3, rotation_from_vector([0.4, -1.1, 2.0]), np.array([3.0, -8.0, 2.0])
BALLS = np.array(
    [
        [0, 0, 2, 0.1],
        [2.4, 0, 2, 0.1],
        [0, 2.4, 2, 0.1],
        [2.4, 2.4, 2, 0.1],
        [1.2, 1.2, 3.5, 0.1],
        [3.3, 0.7, 0.6, 0.07],
    ]
)
RODS = [(0, 1), (0, 2), (1, 3), (2, 3), (0, 4), (1, 4), (2, 4), (3, 4)]


def surface(rng, count, balls=BALLS, rods=RODS):
    """(n, 3) points and outward normals: a bumpy floor, balls and rods of 60 mm."""
    xy = rng.uniform([-1.2, -1.2], [3.9, 3.6], (count // 2, 2))
    slope = 0.05 * np.stack([np.cos(xy[:, 0]), np.cos(1.3 * xy[:, 1]) * 1.3], axis=1)
    points = [np.column_stack([xy, 0.05 * (np.sin(xy[:, 0]) + np.sin(1.3 * xy[:, 1]))])]
    normals = [np.column_stack([-slope, np.ones(len(xy))]) / np.sqrt(1 + np.sum(slope**2, axis=1))[:, None]]
    for *centre, radius in balls:
        way = rng.normal(size=(count // 40, 3))
        way /= np.linalg.norm(way, axis=1)[:, None]
        points.append(np.asarray(centre) + radius * way)
        normals.append(way)
    for a, b in rods:
        start, end = balls[a, :3], balls[b, :3]
        axis = (end - start) / np.linalg.norm(end - start)
        u = np.cross(axis, [0.3, 0.5, 0.8])
        u /= np.linalg.norm(u)
        turn = rng.uniform(0, 2 * np.pi, count // 25)
        way = np.cos(turn)[:, None] * u + np.sin(turn)[:, None] * np.cross(axis, u)
        along = rng.uniform(0.1, np.linalg.norm(end - start) - 0.1, len(turn))
        points.append(start + along[:, None] * axis + 0.03 * way)
        normals.append(way)
    return np.concatenate(points), np.concatenate(normals)


def bend(points, rng, size):
    """A smooth deformation of about ``size`` metres: what a photo model does."""
    waves = rng.normal(0, 1.2, (6, 3))
    phases, ways = rng.uniform(0, 6.3, 6), rng.normal(size=(6, 3))
    return size / np.sqrt(3) * np.sin(points @ waves.T + phases) @ ways


def photo_cloud(seed, count=60_000, noise=0.003, bent=0.0, spheres=0.005, balls=BALLS, rods=RODS):
    """What a flight above sees, in the photo frame."""
    rng = np.random.default_rng(seed)
    points, normals = surface(rng, count, balls, rods)
    seen = normals[:, 2] > -0.1
    points, normals = points[seen], normals[seen]
    points = points + noise * rng.normal(size=len(points))[:, None] * normals + bend(points, rng, bent)
    normals = normals + 0.05 * rng.normal(size=normals.shape)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    found = np.empty((0, 4))
    if spheres:
        centres = balls[:, :3] + rng.normal(0, spheres, (len(balls), 3))
        found = np.column_stack([into_photo(centres), balls[:, 3] / SCALE * rng.normal(1, 0.03, len(balls))])
        found = rng.permutation(found)
    return PhotoCloud(
        points=into_photo(points),
        normals=normals @ TURN,
        colours=np.full((len(points), 3), 120, dtype=np.uint8),
        sigmas=np.full(len(points), noise / SCALE),
        spheres=found,
    )


def into_photo(points):
    return (points - MOVE) @ TURN / SCALE


def scan_cloud(seed, count=200_000, noise=0.002, balls=BALLS, rods=RODS):
    """What two scanners below see, and the floor."""
    rng = np.random.default_rng(seed)
    points, normals = surface(rng, count, balls, rods)
    scanners = np.array([[-0.8, 1.0, 1.2], [3.2, 1.5, 1.2]])
    stations = rng.integers(0, 2, len(points))
    facing = np.sum(normals * (scanners[stations] - points), axis=1) > 0.1 * np.linalg.norm(
        scanners[stations] - points, axis=1
    )
    points, normals, stations = points[facing], normals[facing], stations[facing]
    points = points + noise * rng.normal(size=len(points))[:, None] * normals
    return ScanCloud(points=points, stations=stations, scanners=scanners, intensities=np.zeros(0))


def features(seed=0, balls=BALLS, sigma=0.0005):
    rng = np.random.default_rng(seed)
    return tuple(
        Feature(
            kind=FeatureKind.POINT,
            name="",
            place=ball[:3] + rng.normal(0, sigma, 3),
            direction=np.zeros(3),
            frame=np.eye(3),
            covariance=np.eye(3) * sigma**2,
            radius_m=float(ball[3]),
            points=200,
            rms_m=0.002,
        )
        for ball in rng.permutation(balls)
    )
