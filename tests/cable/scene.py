"""A cable painted in code: exact pictures of a known surface, from known places, through a known lens.

Takes nothing from the pipeline but its records; every formula (attitude, lens, ray against surface) is
written here a second time and in another way, so that truth comes by an independent hand.  The texture is a
spline through smoothed noise: smooth and band-limited, it can be evaluated exactly at any azimuth and place.
"""

from dataclasses import dataclass, field

import cv2
import numpy as np
from scipy.ndimage import gaussian_filter, map_coordinates, spline_filter
from scipy.spatial.transform import Rotation

from pipeline.cable.adjust import Orientation
from pipeline.core.vocabulary import FrameSequence, Lens, Poses, PosPriors

RADIUS_M, STANDOFF_M, STEP_M, FRAMES = 0.055, 0.3, 0.02, 10
TRAVEL_M = STEP_M * (FRAMES - 1)
WIDTH_PX, HEIGHT_PX, FOCAL_PX = 320, 200, 400.0
HALF_DIAGONAL_PX = np.hypot(WIDTH_PX, HEIGHT_PX) / 2
MIDDLE_PX = np.array([WIDTH_PX / 2, HEIGHT_PX / 2])
BARREL = -0.06
BACKGROUND = 25.0
TINT = np.array([0.75, 0.9, 1.0])  # blue, green, red: so that a swap of channels shows


def lens(division_lambda=0.0):
    return Lens(
        width_px=WIDTH_PX,
        height_px=HEIGHT_PX,
        focal_px=FOCAL_PX,
        principal_point_px=(WIDTH_PX / 2, HEIGHT_PX / 2),
        division_lambda=division_lambda,
    )


def out_of_cable(azimuth):
    """Unit vectors (..., 3) from the axis outwards."""
    azimuth = np.asarray(azimuth, dtype=float)
    return np.stack([np.cos(azimuth), np.zeros_like(azimuth), -np.sin(azimuth)], axis=-1)


class Texture:
    """Brightness 0 to 255 of the cable's surface, periodic around it; marks of about 2 and 7 mm."""

    def __init__(self, seed=0, cell_mm=0.5, first_m=-0.25, last_m=0.45):
        self._first_m, self._cell_m = first_m, cell_mm / 1000
        self._columns = round(2 * np.pi * RADIUS_M / self._cell_m)
        shape = (round((last_m - first_m) / self._cell_m), self._columns)
        noise = np.random.default_rng(seed).normal(size=shape)
        mix = np.zeros(shape)
        for size_mm in (2.0, 7.0):
            part = gaussian_filter(noise, size_mm / 2 / cell_mm, mode=("reflect", "wrap"))
            mix += part / part.std()
        values = 128 + 28 * mix / mix.std()
        self._spline = spline_filter(values, order=3, mode="grid-wrap")

    def __call__(self, azimuth, y_m):
        row = (np.asarray(y_m) - self._first_m) / self._cell_m
        column = np.asarray(azimuth) % (2 * np.pi) / (2 * np.pi) * self._columns
        shape = np.broadcast_shapes(row.shape, column.shape)
        where = [np.broadcast_to(row, shape), np.broadcast_to(column, shape)]
        found = map_coordinates(self._spline, where, order=3, mode="grid-wrap", prefilter=False)
        return np.clip(found, 0, 255)


class Specks(Texture):
    """A clean sheath: dark specks of about a millimetre, one in 8 x 8 mm, on even grey."""

    def __init__(self, seed=3, first_m=-0.2, last_m=0.3):
        rng = np.random.default_rng(seed)
        count = round(2 * np.pi * RADIUS_M * (last_m - first_m) / 0.008**2)
        self._azimuth, self._y_m = rng.uniform(-np.pi, np.pi, count), rng.uniform(first_m, last_m, count)
        self._size_m, self._depth = rng.uniform(4e-4, 8e-4, count), rng.uniform(30, 80, count)

    def __call__(self, azimuth, y_m):
        grey = np.full(np.shape(azimuth), 170.0)
        for speck_azimuth, speck_y_m, size_m, depth in zip(
            self._azimuth, self._y_m, self._size_m, self._depth, strict=True
        ):
            near = np.flatnonzero(np.abs(y_m - speck_y_m) < 5 * size_m)
            turned = np.angle(np.exp(1j * (azimuth[near] - speck_azimuth)))
            square = (RADIUS_M * turned) ** 2 + (y_m[near] - speck_y_m) ** 2
            grey[near] -= depth * np.exp(-square / (2 * size_m**2))
        return np.clip(grey, 0, 255)


def nominal_rotation(azimuth_deg):
    """Attitude cam_from_world of a camera looking square at the axis, +y of the cable to the right."""
    forward, right = -out_of_cable(np.radians(azimuth_deg)), np.array([0.0, 1.0, 0.0])
    return np.array([right, np.cross(forward, right), forward])


def poses(azimuth_deg=0.0, frames=FRAMES, sway_deg=0.0, sway_mm=0.0, seed=5):
    """The camera's way along the cable, the robot swaying about it (ends of the travel kept)."""
    rng = np.random.default_rng(seed)
    turn_deg, shift_mm = rng.normal(0, sway_deg, (frames, 3)), rng.normal(0, sway_mm, (frames, 3))
    shift_mm[[0, -1], 1] = 0
    centres = STANDOFF_M * out_of_cable(np.radians(azimuth_deg)) + shift_mm / 1000
    centres = centres + np.outer(STEP_M * np.arange(frames), [0, 1, 0])
    rotations = Rotation.from_rotvec(np.radians(turn_deg)).as_matrix() @ nominal_rotation(azimuth_deg)
    return Poses(rotations=rotations, translations=-np.einsum("nij,nj->ni", rotations, centres))


def pos_priors(of, deg=0.5, mm=1.0, along_mm=1.0, ends_mm=0.02):
    """The poses taken for a POS: loose inside, tight along the cable at both ends."""
    sigmas = np.tile([np.radians(deg)] * 3 + [mm / 1000, along_mm / 1000, mm / 1000], (len(of), 1))
    sigmas[[0, -1], 4] = ends_mm / 1000
    return PosPriors(poses=of, sigmas=sigmas)


@dataclass(frozen=True, kw_only=True)
class Scene:
    """What is photographed: ``height_m`` adds to the radius, a function of azimuth and y."""

    poses: Poses
    lens: Lens = field(default_factory=lens)
    texture: Texture = field(default_factory=Texture)
    radius_m: float = RADIUS_M
    height_m: object = None
    block: str = "Block1"

    def radius(self, azimuth, y_m):
        azimuth = np.asarray(azimuth)
        bump = 0 if self.height_m is None else self.height_m(azimuth, np.asarray(y_m))
        return self.radius_m + bump + 0 * azimuth

    def points(self, azimuth, y_m):
        """Surface points (..., 3) at azimuths and places along the cable."""
        points = self.radius(azimuth, y_m)[..., None] * out_of_cable(azimuth)
        points[..., 1] = y_m
        return points

    def project(self, frame, points):
        """Pixels (n, 2) of surface points (n, 3)."""
        x, y, z = self.poses.rotations[frame] @ np.asarray(points).T + self.poses.translations[frame][:, None]
        ideal = FOCAL_PX * np.array([x / z, y / z]) / HALF_DIAGONAL_PX
        radius, bend = np.maximum(np.hypot(*ideal), 1e-12), self.lens.division_lambda
        # lambda u d^2 - d + u = 0 for the distorted radius d
        distorted = radius if bend == 0 else (1 - np.sqrt(1 - 4 * bend * radius**2)) / (2 * bend * radius)
        return (ideal * distorted / radius * HALF_DIAGONAL_PX).T + MIDDLE_PX

    def meet(self, frame, pixels):
        """Surface points (n, 3) under pixels (n, 2), NaN beside the cable."""
        offset = (np.asarray(pixels, dtype=float) - MIDDLE_PX) / HALF_DIAGONAL_PX
        bend = 1 + self.lens.division_lambda * np.sum(offset**2, axis=1, keepdims=True)
        ray = np.hstack([offset / bend * HALF_DIAGONAL_PX / FOCAL_PX, np.ones((len(offset), 1))])
        ray = ray @ self.poses.rotations[frame]
        centre = self.poses.centres[frame]
        speed = np.hypot(ray[:, 0], ray[:, 2])
        nearest = -(centre[0] * ray[:, 0] + centre[2] * ray[:, 2]) / speed**2
        miss = (centre[0] * ray[:, 2] - centre[2] * ray[:, 0]) / speed
        radius = np.full(len(ray), self.radius_m)
        for _ in range(1 if self.height_m is None else 12):
            with np.errstate(invalid="ignore"):
                points = centre + (nearest - np.sqrt(radius**2 - miss**2) / speed)[:, None] * ray
            radius = self.radius(np.arctan2(-points[:, 2], points[:, 0]), points[:, 1])
        return points

    def picture(self, frame, light=None):
        """The frame (h, w, 3) uint8; ``light`` (h, w) is multiplied in: lamp and vignetting."""
        column, row = np.meshgrid(np.arange(WIDTH_PX) + 0.5, np.arange(HEIGHT_PX) + 0.5)
        points = self.meet(frame, np.stack([column.ravel(), row.ravel()], axis=1))
        seen = np.isfinite(points[:, 0])
        gray = np.full(len(points), BACKGROUND)
        gray[seen] = self.texture(np.arctan2(-points[seen, 2], points[seen, 0]), points[seen, 1])
        gray = gray.reshape(HEIGHT_PX, WIDTH_PX) * (1 if light is None else light)
        return np.clip(np.rint(gray[..., None] * TINT), 0, 255).astype(np.uint8)

    def write(self, folder, light=None):
        """All frames as PNG files."""
        folder.mkdir(parents=True, exist_ok=True)
        files = tuple(folder / f"{k:06d}.png" for k in range(len(self.poses)))
        for frame, file in enumerate(files):
            cv2.imwrite(str(file), self.picture(frame, light))
        return sequence(files, self.block)


def sequence(files, block="Block1"):
    return FrameSequence(
        block=block,
        files=tuple(files),
        source_indices=np.arange(len(files)),
        source_count=len(files),
        width_px=WIDTH_PX,
        height_px=HEIGHT_PX,
    )


def cable_points(view, count=1500, seed=4, limb_deg=55.0):
    """Random surface points (count, 3) along the whole way, numbered along the cable."""
    rng = np.random.default_rng(seed)
    azimuth = np.radians(rng.uniform(-limb_deg, limb_deg, count))
    return view.points(azimuth, np.sort(rng.uniform(-0.06, TRAVEL_M + 0.06, count)))


def observe(view, points, border_px=12.0):
    """Frame, point and exact pixel of every sight of the points (all within reach of the limb)."""
    pixels = np.stack([view.project(k, points) for k in range(len(view.poses))])
    inside = (pixels > border_px) & (pixels < np.array([WIDTH_PX, HEIGHT_PX]) - border_px)
    frame, point = np.nonzero(inside.all(axis=2))
    return frame, point, pixels[frame, point]


def true_orientation(view):
    """The block as a perfect adjustment would give it."""
    points = cable_points(view)
    frame, point, pixels = observe(view, points)
    return Orientation(
        lens=view.lens,
        poses=view.poses,
        points=points,
        frame=frame,
        point=point,
        pixels=pixels,
        residuals=np.zeros_like(pixels),
        keypoints=np.bincount(frame, minlength=len(view.poses)),
        calibrated=np.ones(len(view.poses), dtype=bool),
        reprojection_px=0.0,
        datum_origin=np.array([0.0, TRAVEL_M / 2, 0.0]),
        datum_information=np.diag([1e6] * 3 + [4e6] * 3 + [1e6]),
        lens_effect=None,
    )


def silent(event):
    """For stages whose progress a test does not look at."""
