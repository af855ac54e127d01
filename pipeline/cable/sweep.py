"""The multi-view sweep: for every cell of the unrolled surface, the radius at which the frames agree.

Takes frames, lens, orientations and a first guess of the radius; gives the radius of every cell with a
quality and two half-results, from the frames ahead and from those behind, that share no neighbour.  Cells
are warped from each frame for each candidate radius, compared by box-filtered normalised cross-correlation
with the frame that stands nearest, and the peak is refined by a parabola (after Collins, "A space-sweep
approach to true multi-image matching", CVPR 1996, with cylinders for planes).

To search, cells stay in their place on the surface.  To measure, they go along the reference frame's lines of
sight, and its windows hold the same at every candidate (paper, section 2.4): what a window holds must not
depend on the radius that is asked for (``docs/accuracy.md``, "The window of a sweep").
"""

from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.cable.surface_view import Image, SurfaceView, SweepGrid, outward_of, sample
from pipeline.core.vocabulary import Array, Lens, Poses

LEAST_RISE = 0.1
"""Cosine of the flattest line of sight that is followed as it is: flatter ones see the outline."""


@dataclass(frozen=True, kw_only=True)
class SweepResult:
    """Per cell, all (n, m), float32; NaN where nothing can be said.

    Attributes:
        radius_m: where the agreement peaks.
        score: agreement at the peak, mean correlation, -1 to 1.
        radius_ahead_m, radius_behind_m: from the frames ahead and behind alone.
    """

    radius_m: Image
    score: Image
    radius_ahead_m: Image
    radius_behind_m: Image


class FrameReader:
    """Grey frames as float32, ready to be compared; only the latest ``keep`` stay in memory.

    Args:
        read: gives a frame.
        blur_px: they are blurred so much, to the size of a cell.
        detail_px: their brightness is counted from that of the surroundings so wide (the picture blurred with
            this sigma is taken off).  Lamps that move with the robot shade relief anew in every frame; what
            is painted on the surface stays, and it is finer.  0 leaves the pictures as they are.
        keep: so many frames are held.
    """

    def __init__(
        self,
        read: Callable[[int], NDArray[np.uint8]],
        blur_px: float,
        detail_px: float = 0.0,
        keep: int = 40,
    ) -> None:
        self._read, self._blur_px, self._detail_px, self._keep = read, blur_px, detail_px, keep
        self._held: OrderedDict[int, Image] = OrderedDict()

    def __getitem__(self, frame: int) -> Image:
        if frame not in self._held:
            image = self._read(frame).astype(np.float32)
            if self._blur_px > 0:
                image = np.asarray(cv2.GaussianBlur(image, (0, 0), self._blur_px), dtype=np.float32)
            if self._detail_px > 0:
                image = image - np.asarray(cv2.GaussianBlur(image, (0, 0), self._detail_px), dtype=np.float32)
            self._held[frame] = image
            if len(self._held) > self._keep:
                self._held.popitem(last=False)
        self._held.move_to_end(frame)
        return self._held[frame]


def sweep_strip(
    frames: FrameReader,
    lens: Lens,
    poses: Poses,
    reference: int,
    ahead: tuple[int, ...],
    behind: tuple[int, ...],
    grid: SweepGrid,
    start_m: Image,
    offsets_m: Array,
    window: int,
    baseline_power: float = 0.0,
    *,
    along_sight: bool = False,
) -> SweepResult:
    """Sweep one strip of cells.

    Args:
        frames: grey frames.
        lens: of the frames, distortion included.
        poses: cam_from_world.
        reference: the frame that sees the strip best.
        ahead, behind: frames to compare it with.
        grid: the strip's cells.
        start_m: (n, m) radius around which to search.
        offsets_m: (k,) evenly spaced candidates to add.
        window: side of the comparison window in cells, odd.
        baseline_power: agreements are averaged with the baselines to this power as weights.
        along_sight: a cell's candidates lie on the reference's line of sight through it, not above it; the
            radius is then that of a place as far aside as the start is wrong, times the sight's tangent.
    """
    reach_m = float(np.abs(offsets_m).max())
    aside = _aside(poses.centres[reference], grid, start_m) if along_sight else None

    def path(frame: int) -> _Path:
        return _Path(SurfaceView(lens, poses, frame, grid), start_m, reach_m, aside)

    centre, paths = path(reference), [[path(f) for f in side] for side in (ahead, behind)]
    baselines_m = np.linalg.norm(poses.centres - poses.centres[reference], axis=1)
    weights = (baselines_m / max(baselines_m.max(), 1e-9)) ** baseline_power
    visible = [[p.visible(window) * np.float32(weights[p.frame]) for p in side] for side in paths]
    seen = centre.visible(window)
    volumes = np.zeros((2, len(offsets_m), *start_m.shape), dtype=np.float32)
    template = _Template(centre.sample(frames[reference], 0.0), window)
    for index, offset in enumerate(offsets_m):
        if not along_sight:
            template = _Template(centre.sample(frames[reference], offset), window)
        for side in (0, 1):
            for other, weight in zip(paths[side], visible[side], strict=True):
                sampled = other.sample(frames[other.frame], offset)
                volumes[side, index] += weight * template.correlate(sampled)
    counts = np.array([np.sum(side, axis=0) if side else np.zeros_like(start_m) for side in visible]) * seen
    found = _peaks(volumes, counts, start_m, offsets_m)
    return found if aside is None else _outward(found, grid, start_m, aside)


def _aside(centre: Array, grid: SweepGrid, start_m: Image) -> Array:
    """How far a line of sight goes sideways on a metre outwards, (n, m, 3), in the cable frame."""
    outward = outward_of(grid)
    sight = centre - grid.axis.at(grid.y_m)[:, None] - start_m[..., None] * outward
    rise = np.sum(sight * outward, axis=-1, keepdims=True)
    least = LEAST_RISE * np.linalg.norm(sight, axis=-1, keepdims=True)
    return np.asarray(sight / np.maximum(rise, least) - outward)


def _outward(found: SweepResult, grid: SweepGrid, start_m: Image, aside: Array) -> SweepResult:
    """The radius where the lines of sight have got to: they leave the cell's own direction as they rise."""
    tangent = np.stack([-np.sin(grid.azimuth), np.zeros_like(grid.azimuth), -np.cos(grid.azimuth)], axis=1)
    around = np.sum(aside * tangent, axis=-1)

    def radius(found_m: Image) -> Image:
        return np.hypot(found_m, (found_m - start_m) * around).astype(np.float32)

    return SweepResult(
        radius_m=radius(found.radius_m),
        score=found.score,
        radius_ahead_m=radius(found.radius_ahead_m),
        radius_behind_m=radius(found.radius_behind_m),
    )


def _peaks(volumes: Image, counts: Image, start_m: Image, offsets_m: Array) -> SweepResult:
    with np.errstate(invalid="ignore", divide="ignore"):
        halves = [
            _peak(volume / np.where(count > 0, count, np.nan), start_m, offsets_m)[0]
            for volume, count in zip(volumes, counts, strict=True)
        ]
        total = counts.sum(axis=0)
        mean = volumes.sum(axis=0) / np.where(total > 0, total, np.nan)
        radius, score = _peak(mean, start_m, offsets_m)
    return SweepResult(radius_m=radius, score=score, radius_ahead_m=halves[0], radius_behind_m=halves[1])


def _peak(scores: Image, start_m: Image, offsets_m: Array) -> tuple[Image, Image]:
    """Sub-step maximum over the first axis; NaN where it lies at the end of the range."""
    best = np.argmax(np.nan_to_num(scores, nan=-2), axis=0)
    inner = np.clip(best, 1, len(offsets_m) - 2)
    left, middle, right = (np.take_along_axis(scores, (inner + d)[None], axis=0)[0] for d in (-1, 0, 1))
    curvature = left - 2 * middle + right
    shift = np.where(curvature < 0, (left - right) / (2 * np.where(curvature < 0, curvature, -1)), np.nan)
    step = offsets_m[1] - offsets_m[0]
    found = start_m + offsets_m[inner] + shift * step
    good = (best == inner) & (np.abs(shift) <= 1)
    height = middle - curvature * shift**2 / 2
    return (
        np.where(good, found, np.nan).astype(np.float32),
        np.where(good, height, np.nan).astype(np.float32),
    )


class _Path:
    """The way of every cell through one frame as its radius changes: a parabola through three places.

    Exact projections cost more than all the rest of the sweep; over 5 mm at 245 mm the parabola is off by
    less than 0.01 px, over 1 mm by less than 0.0001 px.  ``aside`` takes the cells sideways as they rise.
    """

    def __init__(self, view: SurfaceView, start_m: Image, reach_m: float, aside: Array | None) -> None:
        self.frame = view.frame
        self._view, reach = view, np.float32(reach_m)
        self._start = view.pixels(start_m)
        beside = None if aside is None else reach * view.turned(aside)
        below = view.pixels(start_m - reach, None if beside is None else -beside)
        above = view.pixels(start_m + reach, beside)
        self._terms = [
            (here, (after - before) / (2 * reach), (after + before - 2 * here) / (2 * reach**2))
            for before, here, after in zip(below, self._start, above, strict=True)
        ]

    def visible(self, window: int) -> Image:
        """1 where the whole comparison window about the start lies in the frame, else 0."""
        return self._view.visible(self._start, window)

    def sample(self, image: Image, offset_m: float) -> Image:
        """The frame's values at the cells whose radius is ``offset_m`` larger than at the start."""
        offset = np.float32(offset_m)
        column, row = (here + offset * (slope + offset * bend) for here, slope, bend in self._terms)
        return sample(image, (column, row))


class _Template:
    """The reference warped for one radius, ready to be correlated."""

    def __init__(self, image: Image, window: int) -> None:
        self._image, self._window = image, window
        self._mean = self._box(image)
        self._variance = self._box(image * image) - self._mean**2

    def correlate(self, other: Image) -> Image:
        """Normalised cross-correlation of every window."""
        mean = self._box(other)
        variance = self._box(other * other) - mean**2
        product = self._box(self._image * other) - self._mean * mean
        return product / np.sqrt(np.maximum(self._variance * variance, 1e-3) + 1.0)

    def _box(self, image: Image) -> Image:
        size = (self._window, self._window)
        return np.asarray(cv2.boxFilter(image, cv2.CV_32F, size, borderType=cv2.BORDER_REFLECT))
