"""A small space frame on columns and a scanner that sees it, for tests: truth by an independent hand.

Square pyramids with ball nodes (the bottom chord carried by columns), a floor, a box and a target sphere.
The scanner casts a grid of rays against the exact figures, the nearest wins; then range and angle noise, and
mixed pixels where the ray passes an edge.
"""

from dataclasses import dataclass, field

import numpy as np

from pipeline.steel.records import StationPose


@dataclass
class Frame:
    """Truth: all in metres, site frame."""

    nodes: dict = field(default_factory=dict)  # name -> (where the rods meet, ball centre, ball radius)
    rods: list = field(default_factory=list)  # (start, end, radius, (name, name))
    columns: list = field(default_factory=list)  # (bottom, top, radius)
    spheres: list = field(default_factory=list)  # further spheres: (centre, radius)
    boxes: list = field(default_factory=list)  # (low corner, high corner)
    floor: float | None = 0.0


def space_frame(
    cells=(2, 2),
    spacing=2.4,
    depth=1.7,
    height=3.5,
    rod_radius=0.030,
    ball_radius=0.10,
    column_radius=0.15,
    eccentricity=(),
    tilts=(),
    sag=0.0,
):
    """``eccentricity``: {node name: (3,) metres ball - rods}; ``tilts``: (east, north) metres a column."""
    eccentricity, frame = dict(eccentricity), Frame()
    nx, ny = cells

    def add(name, place):
        middle = (place[:2] - np.array([nx, ny]) * spacing / 2) / (np.array([nx, ny]) * spacing / 2)
        place = place - [0, 0, sag * max(1 - middle @ middle / 2, 0)]
        frame.nodes[name] = (place, place + np.array(eccentricity.get(name, (0, 0, 0))), ball_radius)

    for i in range(nx + 1):
        for j in range(ny + 1):
            add(f"B{i}{j}", np.array([i * spacing, j * spacing, height]))
    for i in range(nx):
        for j in range(ny):
            add(f"T{i}{j}", np.array([(i + 0.5) * spacing, (j + 0.5) * spacing, height + depth]))

    def join(a, b):
        start, end = frame.nodes[a][0], frame.nodes[b][0]
        along = (end - start) / np.linalg.norm(end - start)
        cut = ball_radius * 0.9
        frame.rods.append((start + cut * along, end - cut * along, rod_radius, (a, b)))

    for i in range(nx + 1):
        for j in range(ny + 1):
            if i < nx:
                join(f"B{i}{j}", f"B{i + 1}{j}")
            if j < ny:
                join(f"B{i}{j}", f"B{i}{j + 1}")
    for i in range(nx):
        for j in range(ny):
            for k, m in ((0, 0), (0, 1), (1, 0), (1, 1)):
                join(f"T{i}{j}", f"B{i + k}{j + m}")
            if i < nx - 1:
                join(f"T{i}{j}", f"T{i + 1}{j}")
            if j < ny - 1:
                join(f"T{i}{j}", f"T{i}{j + 1}")
    for number, (i, j) in enumerate(((0, 0), (nx, 0), (0, ny), (nx, ny))):
        top = frame.nodes[f"B{i}{j}"][1] - [0, 0, ball_radius * 0.9]
        east, north = tilts[number] if len(tilts) else (0.0, 0.0)
        frame.columns.append((np.array([top[0] - east, top[1] - north, 0.0]), top, column_radius))
    return frame


def pose(name, place, heading_deg=0.0, sigma_m=0.0, sigma_arcsec=0.0):
    turn = np.radians(heading_deg)
    rotation = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    sigmas = np.repeat([np.radians(sigma_arcsec / 3600), sigma_m], 3)
    return StationPose(
        name=name, rotation=rotation, translation=np.array(place, dtype=float), covariance=np.diag(sigmas**2)
    )


def scan(frame, station, seed, step_deg=0.05, range_sigma=0.002, angle_sigma_arcsec=8.0, mixed=True):
    """Cloud (n, 3) float32 of a station in its own frame."""
    rng = np.random.default_rng(seed)
    step = np.radians(step_deg)
    rows, columns = int(np.radians(150) / step), int(2 * np.pi / step)
    buffer = np.full((rows, columns), np.inf, dtype=np.float32)
    low = np.radians(-60)

    def local(place):
        return (np.asarray(place) - station.translation) @ station.rotation

    def rays(row, column):
        elevation, azimuth = low + row[:, None] * step, column[None, :] * step
        flat = np.cos(elevation)
        x, y = flat * np.cos(azimuth), flat * np.sin(azimuth)
        return np.stack([x, y, np.broadcast_to(np.sin(elevation), x.shape)], axis=-1)

    def see(corners, hit):
        azimuth = np.arctan2(corners[:, 1], corners[:, 0])
        middle = np.arctan2(np.sin(azimuth).sum(), np.cos(azimuth).sum())
        around = (azimuth - middle + np.pi) % (2 * np.pi) - np.pi
        elevation = np.arcsin(corners[:, 2] / np.linalg.norm(corners, axis=1))
        first, last = np.floor((elevation.min() - low) / step), np.ceil((elevation.max() - low) / step)
        row = np.arange(max(int(first), 0), min(int(last) + 1, rows))
        column = np.arange(
            int(np.floor((middle + around.min()) / step)), int(np.ceil((middle + around.max()) / step)) + 1
        )
        if len(row) and len(column) < columns:
            ray = rays(row, column)
            place = np.ix_(row, column % columns)
            with np.errstate(invalid="ignore", divide="ignore"):
                buffer[place] = np.fmin(buffer[place], hit(ray))

    for centre, radius in [(n[1], n[2]) for n in frame.nodes.values()] + frame.spheres:
        see(*_sphere(local(centre), radius))
    for start, end, radius in [r[:3] for r in frame.rods] + frame.columns:
        see(*_cylinder(local(start), local(end), radius))
    for corner, other in frame.boxes:
        if abs(np.linalg.det(station.rotation) - 1) < 1e-9:
            see(*_box(np.asarray(corner), np.asarray(other), station))
    every = rays(np.arange(rows), np.arange(columns))
    if frame.floor is not None:
        with np.errstate(divide="ignore"):
            down = (frame.floor - station.translation[2]) / every[..., 2]
        buffer = np.fmin(buffer, np.where((down > 0) & (down < 25), down, np.inf))
    if mixed:
        buffer = np.where(np.isfinite(buffer), buffer, 1e9)
        beside = np.roll(buffer, 1, axis=1)
        edge = (buffer < 1e8) & (beside < 1e8) & (np.abs(buffer - beside) > 0.03)
        edge &= rng.random(buffer.shape) < 0.5
        share = rng.random(buffer.shape)
        buffer = np.where(edge, share * buffer + (1 - share) * np.where(edge, beside, 0), buffer)
    seen = buffer < 1e8
    depth = buffer[seen] + rng.normal(0, range_sigma, seen.sum())
    ray = every[seen] + rng.normal(0, np.radians(angle_sigma_arcsec / 3600), (seen.sum(), 3))
    return (depth[:, None] * ray / np.linalg.norm(ray, axis=1)[:, None]).astype(np.float32)


def _sphere(centre, radius):
    span = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]) * radius

    def hit(ray):
        along = ray @ centre
        inside = radius**2 - (centre @ centre - along**2)
        return np.where(inside > 0, along - np.sqrt(inside), np.inf)

    return centre + span, hit


def _cylinder(start, end, radius):
    length = np.linalg.norm(end - start)
    axis = (end - start) / length
    span = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]) * radius
    corners = np.concatenate([start + t * length * axis + span for t in np.linspace(0, 1, 30)])

    def hit(ray):
        slope = ray @ axis
        across, away = ray - slope[..., None] * axis, -(start - (start @ axis) * axis)
        a, b, c = np.sum(across**2, axis=-1), across @ away, away @ away - radius**2
        depth = (-b - np.sqrt(b * b - a * c)) / a
        place = depth * slope - start @ axis
        return np.where((depth > 0) & (place > 0) & (place < length), depth, np.inf)

    return corners, hit


def _box(low, high, station):
    corners = np.array(
        [[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
    )

    def hit(ray):
        site = ray @ station.rotation.T
        near, far = (low - station.translation) / site, (high - station.translation) / site
        first, last = np.minimum(near, far).max(axis=-1), np.maximum(near, far).min(axis=-1)
        return np.where((first < last) & (first > 0), first, np.inf)

    return (corners - station.translation) @ station.rotation, hit
