"""A bent cable, and a robot that rides along it and turns about it, measured in segments without pictures.

Each segment is adjusted by the real joint adjustment, from exact projections with noise, in a frame of its
own that knows nothing of the others.  Shares no formula with the pipeline.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from pipeline.cable.closing import SharedMarks
from pipeline.cable.joint import JointBlock, JointOptions, adjust_ring
from pipeline.cable.pos import RobotPriors
from pipeline.core.vocabulary import Poses, TravelDirection
from pipeline.segments.bends import AxisPart
from pipeline.segments.plan import TraverseOptions, cut
from pipeline.segments.traverse import AdjustedSegment, close_traverse
from tests.cable import scene
from tests.cable.ring_scene import AZIMUTHS_DEG

LAMBDA = -0.05


@dataclass(frozen=True, kw_only=True)
class Cable:
    """The truth: the axis is (x(y), y, z(y)), an arc and a wave; the robot turns steadily about it.

    Attributes:
        radius_m: of the arc, towards x.
        wave_m: amplitude of the wave, towards z; it is ``LONG_M`` long.
        roll_per_m: of the robot, radians.
    """

    radius_m: float = 40.0
    wave_m: float = 1e-3
    roll_per_m: float = 0.5

    LONG_M = 0.5

    def axis(self, y_m):
        y_m = np.asarray(y_m, dtype=float)
        wave = self.wave_m * np.sin(2 * np.pi * y_m / self.LONG_M)
        return np.stack([y_m**2 / (2 * self.radius_m), y_m, wave], axis=-1)

    def lean(self, y_m):
        """Rotations that lay y on the axis there."""
        y_m = np.asarray(y_m, dtype=float)
        wave = 2 * np.pi / self.LONG_M * self.wave_m * np.cos(2 * np.pi * y_m / self.LONG_M)
        slope = y_m / self.radius_m
        return Rotation.from_rotvec(np.stack([np.arctan(wave), 0 * y_m, -np.arctan(slope)], axis=-1))

    def rolled(self, y_m):
        """Rotations from the robot's frame to the cable's, but for sway."""
        return self.lean(y_m) * Rotation.from_rotvec(
            np.multiply.outer(self.roll_per_m * np.asarray(y_m), [0, 1, 0])
        )

    def points(self, azimuth, y_m):
        """Surface points: azimuths count from where the robot's frame has them."""
        away = scene.RADIUS_M * scene.out_of_cable(azimuth)
        return self.axis(y_m) + self.rolled(y_m).apply(away)

    def into(self, segment, points):
        """Points in the segment's own frame, and that frame's rotation: it lies on the axis in its middle."""
        middle_m = scene.STEP_M * (segment.first + segment.last) / 2
        own = self.rolled(middle_m)
        back = np.array([0.0, middle_m - scene.STEP_M * segment.first, 0.0])
        return own.inv().apply(points - self.axis(middle_m)) + back, own

    def views(self, frames, seed, sway_deg=0.15, sway_mm=0.4):
        """One view a camera, all carried by the same body along the axis."""
        rng = np.random.default_rng(seed)
        y_m = scene.STEP_M * np.arange(frames)
        sway = Rotation.from_rotvec(np.radians(rng.normal(0, sway_deg, (frames, 3))))
        body = self.rolled(y_m) * sway
        across = rng.normal(0, sway_mm / 1000, (frames, 3)) * [1, 0, 1]
        centres = self.axis(y_m) + self.rolled(y_m).apply(across)
        found = []
        for azimuth in AZIMUTHS_DEG:
            arm = scene.STANDOFF_M * scene.out_of_cable(np.radians(azimuth))
            rotations = scene.nominal_rotation(azimuth) @ body.inv().as_matrix()
            found.append(
                scene.Scene(
                    poses=_poses(rotations, centres + body.apply(arm)), lens=scene.lens(LAMBDA), texture=None
                )
            )
        return tuple(found)


@dataclass(frozen=True, kw_only=True)
class Sights:
    """What one camera saw: frame, point and pixel of each sight, and where the points truly are."""

    frame: np.ndarray
    point: np.ndarray
    pixels: np.ndarray
    points: np.ndarray

    def within(self, frames):
        """Those of some frames, with frames and points numbered anew; a point has to be seen twice."""
        keep = (self.frame >= frames.start) & (self.frame < frames.stop)
        keep &= np.bincount(self.point[keep], minlength=len(self.points))[self.point] > 1
        seen, point = np.unique(self.point[keep], return_inverse=True)
        return Sights(
            frame=self.frame[keep] - frames.start,
            point=point,
            pixels=self.pixels[keep],
            points=self.points[seen],
        )


def measured_parts(cable, options, frames, seed, noise_px=0.1, count=260, marks=60):
    """The segments' axes as :func:`pipeline.segments.bends.whole_axis` takes them."""
    views = cable.views(frames, seed)
    rng = np.random.default_rng(seed + 1000)
    ties = [_sights(cable, v, a, 55, count, noise_px, rng) for v, a in zip(views, AZIMUTHS_DEG, strict=True)]
    shared = [_shared(cable, views, n, marks, noise_px, rng) for n in range(len(views))]
    segments = cut(frames, options)
    made = [_adjusted(cable, s, views, ties, shared, seed) for s in segments]
    travel_m = scene.STEP_M * (frames - 1)
    placed = close_traverse(segments, tuple(a for a, _ in made), travel_m, 1e-5, TraverseOptions())
    return [
        aligned_part(s, a, p, _seen_axis(cable, s, views, poses))
        for s, (a, poses), p in zip(segments, made, placed, strict=True)
    ]


def _sights(cable, view, azimuth_deg, half_deg, count, noise_px, rng):
    travel_m = scene.STEP_M * (len(view.poses) - 1)
    many = round(count * (travel_m + 0.1) / 0.3)
    turn = np.radians(azimuth_deg + rng.uniform(-half_deg, half_deg, many))
    points = cable.points(turn, np.sort(rng.uniform(-0.05, travel_m + 0.05, many)))
    frame, point, pixels = scene.observe(view, points)
    return Sights(
        frame=frame, point=point, pixels=pixels + rng.normal(0, noise_px, pixels.shape), points=points
    )


def _shared(cable, views, first, count, noise_px, rng):
    """Marks on the line between a camera and its neighbour, as both saw them."""
    one = _sights(cable, views[first], AZIMUTHS_DEG[first] + 45, 7, count, noise_px, rng)
    frame, point, pixels = scene.observe(views[(first + 1) % len(views)], one.points)
    return one, replace(one, frame=frame, point=point, pixels=pixels + rng.normal(0, noise_px, pixels.shape))


def _adjusted(cable, segment, views, ties, shared, seed):
    """A segment by itself, in a frame that lies on the cable in its middle; with its cameras' poses."""
    rng = np.random.default_rng(seed + 7 * segment.number)

    def near(points):
        return cable.into(segment, points)[0] + rng.normal(0, 3e-4, points.shape)

    count = segment.last - segment.first + 1
    blocks = []
    for number, (view, azimuth) in enumerate(zip(views, AZIMUTHS_DEG, strict=True)):
        seen = ties[number].within(segment.frames)
        alone = replace(
            scene.true_orientation(scene.Scene(poses=scene.poses(azimuth), lens=view.lens, texture=None)),
            poses=scene.poses(azimuth, frames=count),
            points=near(seen.points),
            frame=seen.frame,
            point=seen.point,
            pixels=seen.pixels,
            residuals=np.zeros_like(seen.pixels),
        )
        blocks.append(
            JointBlock(
                name=f"Block{number + 1}",
                azimuth_deg=azimuth,
                travel_in_image=TravelDirection.RIGHT,
                orientation=alone,
            )
        )
    ring = adjust_ring(
        tuple(blocks), _marks(shared, segment, near), _robot(count), JointOptions(), scene.silent
    )
    rotations = np.stack([b.poses.rotations for b in ring.blocks])
    return AdjustedSegment(path=ring.path, rotations=rotations), [b.poses for b in ring.blocks]


def _marks(shared, segment, near):
    rows = {name: [] for name in ("block", "frame", "mark", "pixels")}
    points, pairs = [], []
    for first, two in enumerate(shared):
        both = _common(two, segment.frames)
        for camera, sights in zip((first, (first + 1) % len(shared)), two, strict=True):
            keep = (sights.frame >= segment.frames.start) & (sights.frame < segment.frames.stop)
            keep &= np.isin(sights.point, both)
            rows["block"].append(np.full(keep.sum(), camera))
            rows["frame"].append(sights.frame[keep] - segment.first)
            rows["mark"].append(np.searchsorted(both, sights.point[keep]) + sum(map(len, points)))
            rows["pixels"].append(sights.pixels[keep])
        points.append(near(two[0].points[both]))
        pairs.append(np.tile([first, (first + 1) % len(shared)], (len(both), 1)))
    return SharedMarks(
        **{name: np.concatenate(values) for name, values in rows.items()},
        points=np.concatenate(points),
        pairs=np.concatenate(pairs),
    )


def _common(two, frames):
    """Marks that both cameras saw twice in some frames."""
    found = []
    for sights in two:
        keep = (sights.frame >= frames.start) & (sights.frame < frames.stop)
        found.append(np.flatnonzero(np.bincount(sights.point[keep], minlength=len(sights.points)) > 1))
    return np.intersect1d(*found)


def _robot(frames):
    body = np.tile([np.radians(0.5)] * 3 + [1.5e-3] * 3, (frames, 1))
    body[[0, -1], 4] = 2e-6
    return RobotPriors(
        y_m=scene.STEP_M * np.arange(frames),
        body_sigmas=body,
        standoff_m=scene.STANDOFF_M,
        mount_sigmas=np.array([np.radians(0.2)] * 3 + [3e-4] * 3),
    )


def _seen_axis(cable, segment, views, poses):
    """(frames, 3) the axis as its cameras see it: where each truly has it, from where it is said to stand."""
    y_m = scene.STEP_M * np.arange(segment.first, segment.last + 1)
    seen = []
    for view, told in zip(views, poses, strict=True):
        true = view.poses.rotations[segment.frames], view.poses.translations[segment.frames]
        before = np.einsum("nij,nj->ni", true[0], cable.axis(y_m)) + true[1]
        seen.append(np.einsum("nji,nj->ni", told.rotations, before) + told.centres)
    return np.mean(seen, axis=0)


def aligned_part(segment, adjusted, placement, axis):
    """A segment with its axis through (n, 3) points of its own frame: the line that fits best is put on y."""
    lean = [np.polyfit(axis[:, 1], axis[:, across], 1)[0] for across in (0, 2)]
    rotation, _ = Rotation.align_vectors([[0.0, 1.0, 0.0]], [[lean[0], 1.0, lean[1]]])
    aligned = rotation.apply(axis - axis.mean(axis=0)) + axis.mean(axis=0) * [0, 1, 0]
    return AxisPart(
        segment=segment,
        adjusted=adjusted,
        placement=placement,
        rotation=rotation.as_matrix(),
        y_m=placement.start_m + placement.scale * aligned[:, 1],
        centre_mm=1000 * aligned[:, [0, 2]],
    )


def _poses(rotations, centres):
    return Poses(rotations=rotations, translations=-np.einsum("nij,nj->ni", rotations, centres))
