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

from pipeline.cable.cell_paths import CellPath, Template
from pipeline.cable.surface_view import Image, SurfaceView, SweepGrid, outward_of
from pipeline.core.vocabulary import Array, Lens, Poses

LEAST_RISE = 0.1
"""Cosine of the flattest line of sight that is followed as it is: flatter ones see the outline."""
CELLS_AT_ONCE = 65536
"""So many cells are looked up in one go, several candidates of a strip: few calls, and all in the cache."""


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
                image -= np.asarray(cv2.GaussianBlur(image, (0, 0), self._detail_px))
            self._held[frame] = image
            if len(self._held) > self._keep:
                self._held.popitem(last=False)
        self._held.move_to_end(frame)
        return self._held[frame]


@dataclass(frozen=True, kw_only=True)
class SweepPass:
    """What is swept: the cells of a whole block or of one strip.

    Attributes:
        grid: the cells, (n, m).
        start_m: (n, m) radius around which to search.
        offsets_m: (k,) evenly spaced candidates to add.
        window: side of the comparison window in cells, odd.
        blur_px: frames are blurred so much.
        detail_px: and their brightness is counted from surroundings so wide.
        baseline_power: agreements are averaged with the baselines to this power as weights.
        along_sight: a cell's candidates lie on the reference's line of sight through it, not above it; the
            radius is then that of a place as far aside as the start is wrong, times the sight's tangent.
    """

    grid: SweepGrid
    start_m: Image
    offsets_m: Array
    window: int
    blur_px: float = 0.0
    detail_px: float = 0.0
    baseline_power: float = 0.0
    along_sight: bool = False


@dataclass(frozen=True, kw_only=True)
class StripFrames:
    """The frames that a strip is swept in.

    Attributes:
        read: grey frames, prepared as the pass wants them.
        lens: of the frames, distortion included.
        poses: cam_from_world.
        reference: the frame that sees the strip best.
        ahead, behind: frames to compare it with.
    """

    read: FrameReader
    lens: Lens
    poses: Poses
    reference: int
    ahead: tuple[int, ...]
    behind: tuple[int, ...]


def sweep_strip(frames: StripFrames, wanted: SweepPass) -> SweepResult:
    """Sweep one strip of cells.

    Rows nearer to the strip's ends than half a window say nothing: windows there reach into other candidates.
    """
    start_m, poses, centre = wanted.start_m, frames.poses, frames.poses.centres[frames.reference]
    aside = _aside(centre, wanted.grid, start_m) if wanted.along_sight else None
    reach_m = float(np.abs(wanted.offsets_m).max())

    def path(frame: int) -> CellPath:
        return CellPath(SurfaceView(frames.lens, poses, frame, wanted.grid), start_m, reach_m, aside)

    reference, paths = (
        path(frames.reference),
        [[path(f) for f in side] for side in (frames.ahead, frames.behind)],
    )
    baselines_m = np.linalg.norm(poses.centres - centre, axis=1)
    weights = (baselines_m / max(baselines_m.max(), 1e-9)) ** wanted.baseline_power
    visible = [[p.visible(wanted.window) * np.float32(weights[p.frame]) for p in side] for side in paths]
    counts = np.array([np.sum(side, axis=0) if side else np.zeros_like(start_m) for side in visible])
    volumes = _agreements(frames.read, reference, paths, visible, wanted)
    found = _peaks(volumes, counts * reference.visible(wanted.window), start_m, wanted.offsets_m)
    return found if aside is None else _outward(found, wanted.grid, start_m, aside)


def _agreements(
    read: FrameReader,
    reference: CellPath,
    paths: list[list[CellPath]],
    visible: list[list[Image]],
    wanted: SweepPass,
) -> Image:
    """Correlations with the reference summed over the frames of each side, (2, k, n, m)."""
    offsets_m = wanted.offsets_m
    volumes = np.zeros((2, len(offsets_m), *wanted.start_m.shape), dtype=np.float32)
    template = Template(reference.sample(read[reference.frame], np.zeros(1)), wanted.window)
    at_once = max(CELLS_AT_ONCE // wanted.start_m.size, 1)
    for first in range(0, len(offsets_m), at_once):
        some = slice(first, first + at_once)
        if not wanted.along_sight:
            template = Template(reference.sample(read[reference.frame], offsets_m[some]), wanted.window)
        for side in (0, 1):
            for other, weight in zip(paths[side], visible[side], strict=True):
                agreement = template.correlate(other.sample(read[other.frame], offsets_m[some]))
                agreement *= weight
                volumes[side, some] += agreement
    return volumes


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
            _peak(volume, count, start_m, offsets_m)[0] for volume, count in zip(volumes, counts, strict=True)
        ]
        radius, score = _peak(volumes[0] + volumes[1], counts[0] + counts[1], start_m, offsets_m)
    return SweepResult(radius_m=radius, score=score, radius_ahead_m=halves[0], radius_behind_m=halves[1])


def _peak(sums: Image, counts: Image, start_m: Image, offsets_m: Array) -> tuple[Image, Image]:
    """Sub-step maximum of sums / counts over the first axis; NaN at the range's ends, and without a count."""
    best = np.argmax(sums, axis=0)
    inner = np.clip(best, 1, len(offsets_m) - 2)
    share = 1 / np.where(counts > 0, counts, np.nan)
    left, middle, right = (np.take_along_axis(sums, (inner + d)[None], axis=0)[0] * share for d in (-1, 0, 1))
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
