"""Stage *dense*: the radius of every cell of one block's surface (paper, section 2.4).

Takes the original frames and the adjusted block; gives a radius map about the block's own axis with a quality
measure and a consistency mask.  Sweeps twice: coarse cells over the whole search range, then fine cells
around the coarse surface.  Leaves out meshing (surface) and colour (texture).
"""

from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.cable.adjust import Orientation
from pipeline.cable.patch_match import match_patches
from pipeline.cable.sweep import FrameReader, Image, SweepGrid, SweepResult, sweep_strip
from pipeline.core.axis import AxisCurve, axis_of_cylinder
from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event
from pipeline.core.fits.cylinder import Cylinder, fit_cylinder
from pipeline.core.vocabulary import Array, FrameSequence


class DenseMethod(StrEnum):
    """Who matches densely."""

    SWEEP = "sweep"
    PATCH_MATCH = "patch-match"


@dataclass(frozen=True, kw_only=True)
class DenseOptions:
    """How the surface is swept.

    Attributes:
        method: "sweep", our own on the CPU; "patch-match", COLMAP's, where it was built with CUDA.
        cell_mm: side of a cell; 0 takes the ground sample distance.
        coarse: coarse cells are so many fine cells wide.
        limb_deg: cells further than this from the camera's azimuth are not swept: there the outline begins.
        margin_mm: swept length beyond the first and the last frame.
        search_mm: half of the coarse search range about the block's fitted radius.
        window: side of the comparison window in cells, odd.
        baselines_mm: distances to the frames compared with, on either side.
        least_score: cells whose agreement is lower are masked.
        consistency_mm: cells whose two half-results differ by more are masked.
    """

    method: DenseMethod = DenseMethod.SWEEP
    cell_mm: float = field(default=0.0, metadata={"minimum": 0.0})
    coarse: int = field(default=4, metadata={"minimum": 1})
    limb_deg: float = field(default=60.0, metadata={"above": 0.0, "maximum": 85.0})
    margin_mm: float = field(default=25.0, metadata={"minimum": 0.0})
    search_mm: float = field(default=5.0, metadata={"above": 0.0})
    window: int = field(default=9, metadata={"minimum": 3})
    baselines_mm: tuple[float, ...] = field(default=(40.0, 80.0, 120.0), metadata={"above": 0.0})
    least_score: float = field(default=0.5, metadata={"minimum": 0.0, "maximum": 1.0})
    consistency_mm: float = field(default=0.35, metadata={"above": 0.0})


@dataclass(frozen=True, kw_only=True)
class RadiusMap:
    """The dense surface of one block.

    Attributes:
        axis: the axis that radii are counted from, block's own.
        azimuth: (m,) radians, evenly spaced.
        y_m: (n,) metres, evenly spaced.
        radius_m: (n, m) float32, NaN where masked.
        score: (n, m) float32 agreement of the frames, NaN where not swept.
        noise_mm: standard deviation of a cell's radius, from the two half-results.
        ground_sample_mm: size of a pixel on the surface.
        coverage: share of the swept cells that stand.
    """

    axis: AxisCurve
    azimuth: Array
    y_m: Array
    radius_m: Image
    score: Image
    noise_mm: float
    ground_sample_mm: float
    coverage: float


def sweep_block(
    frames: FrameSequence,
    orientation: Orientation,
    azimuth_deg: float,
    options: DenseOptions,
    emit: Emit,
    scratch: Path,
) -> RadiusMap:
    """Match one block densely.

    Args:
        frames: original frames.
        orientation: the adjusted block.
        azimuth_deg: place of its camera around the axis.
        options: see there.
        emit: progress, one event a strip.
        scratch: folder for COLMAP's intermediate files; only patch matching uses it, and removes it.

    Raises:
        StageError: patch matching was asked for and cannot be had, or next to nothing of the surface could
        be matched.
    """
    cylinder = fit_cylinder(orientation.points, direction=(0.0, 1.0, 0.0))
    ground_mm = _ground_sample_mm(orientation, cylinder)
    cell_mm = options.cell_mm or ground_mm
    if options.method is DenseMethod.PATCH_MATCH:
        grid = _grid(orientation, cylinder, azimuth_deg, cell_mm, options)
        return _mask(
            match_patches(frames, orientation, grid, scratch, emit), grid, ground_mm, frames.block, options
        )
    coarse_grid = _grid(orientation, cylinder, azimuth_deg, cell_mm * options.coarse, options)
    step_mm = _step_mm(options, cell_mm * options.coarse)
    search_mm = np.arange(-options.search_mm, options.search_mm + 1e-9, step_mm)
    start = np.full((len(coarse_grid.y_m), len(coarse_grid.azimuth)), cylinder.radius, dtype=np.float32)
    work = _Strips(frames, orientation, options, emit)
    found = work.sweep(coarse_grid, start, search_mm / 1000, blur_px=options.coarse / 2, part=0)
    grid = _grid(orientation, cylinder, azimuth_deg, cell_mm, options)
    start = _smooth_start(found, coarse_grid, grid, cylinder.radius)
    search_mm = np.arange(-4, 5) * _step_mm(options, cell_mm)
    fine = work.sweep(grid, start, search_mm / 1000, blur_px=0.0, part=1)
    return _mask(fine, grid, ground_mm, frames.block, options)


def _ground_sample_mm(orientation: Orientation, cylinder: Cylinder) -> float:
    away = orientation.poses.centres - cylinder.axis_at(orientation.poses.centres[:, 1] - cylinder.point[1])
    distance = float(np.median(np.hypot(away[:, 0], away[:, 2]))) - cylinder.radius
    return 1000 * distance / orientation.lens.focal_px


def _step_mm(options: DenseOptions, cell_mm: float) -> float:
    """Radius step that shifts the widest pair by about a third of a cell."""
    return cell_mm / 3 * 250.0 / max(options.baselines_mm)


def _grid(
    orientation: Orientation, cylinder: Cylinder, azimuth_deg: float, cell_mm: float, options: DenseOptions
) -> SweepGrid:
    along = orientation.poses.centres[:, 1]
    margin, cell = options.margin_mm / 1000, cell_mm / 1000
    limb = np.deg2rad(options.limb_deg)
    columns = max(int(2 * limb * cylinder.radius / cell), 2)
    rows = max(int((np.ptp(along) + 2 * margin) / cell), 2)
    return SweepGrid(
        axis=axis_of_cylinder(cylinder),
        azimuth=np.deg2rad(azimuth_deg) + np.linspace(-limb, limb, columns),
        y_m=along.min() - margin + cell * np.arange(rows),
    )


class _Strips:
    """Sweeps a grid strip by strip, each against the frame that stands nearest."""

    def __init__(
        self, frames: FrameSequence, orientation: Orientation, options: DenseOptions, emit: Emit
    ) -> None:
        self._frames, self._orientation = frames, orientation
        self._options, self._emit = options, emit
        self._along = orientation.poses.centres[:, 1]

    def sweep(
        self, grid: SweepGrid, start_m: Image, offsets_m: Array, blur_px: float, part: int
    ) -> SweepResult:
        shape = start_m.shape
        fields = ("radius_m", "score", "radius_ahead_m", "radius_behind_m")
        whole = {f: np.full(shape, np.nan, dtype=np.float32) for f in fields}
        reader = FrameReader(self._read, blur_px)
        nearest = np.abs(grid.y_m[:, None] - self._along).argmin(axis=1)
        halo = self._options.window // 2
        for reference in range(len(self._along)):
            total = 2 * len(self._along)
            done = part * len(self._along) + reference
            self._emit(Event(stage="dense", block=self._frames.block, done=done, total=total))
            rows = np.flatnonzero(nearest == reference)
            if not len(rows):
                continue
            first, last = max(rows[0] - halo, 0), min(rows[-1] + halo + 1, shape[0])
            strip = SweepGrid(axis=grid.axis, azimuth=grid.azimuth, y_m=grid.y_m[first:last])
            ahead, behind = self._neighbours(reference, 1), self._neighbours(reference, -1)
            found = sweep_strip(
                reader,
                self._orientation.lens,
                self._orientation.poses,
                reference,
                ahead,
                behind,
                strip,
                start_m[first:last],
                offsets_m,
                self._options.window,
            )
            for name, values in whole.items():
                values[rows] = getattr(found, name)[rows - first]
        return SweepResult(**whole)

    def _neighbours(self, reference: int, side: int) -> tuple[int, ...]:
        """Frames about the wanted baselines away, on one side; much closer ones cannot tell the radius."""
        here = self._along[reference]
        least_m = 0.75 * min(self._options.baselines_mm) / 1000
        chosen = []
        for baseline_mm in self._options.baselines_mm:
            frame = int(np.abs(self._along - (here + side * baseline_mm / 1000)).argmin())
            if (self._along[frame] - here) * side > least_m and frame not in chosen:
                chosen.append(frame)
        return tuple(chosen)

    def _read(self, frame: int) -> NDArray[np.uint8]:
        file = self._frames.files[frame]
        return np.asarray(cv2.imread(str(file), cv2.IMREAD_GRAYSCALE), dtype=np.uint8)


def _smooth_start(found: SweepResult, coarse: SweepGrid, fine: SweepGrid, radius_m: float) -> Image:
    """The coarse surface without its outliers, at the fine cells: where the fine search begins."""
    known = np.isfinite(found.radius_m) & (np.nan_to_num(found.score, nan=-1) > 0.3)
    middle = float(np.median(found.radius_m[known])) if known.any() else radius_m
    filled = np.where(known, found.radius_m, middle).astype(np.float32)
    steady = cv2.medianBlur(filled, 5)
    smooth = cv2.GaussianBlur(steady, (0, 0), 1.5)
    column = np.interp(fine.azimuth, coarse.azimuth, np.arange(len(coarse.azimuth))).astype(np.float32)
    row = np.interp(fine.y_m, coarse.y_m, np.arange(len(coarse.y_m))).astype(np.float32)
    grid = np.meshgrid(column, row)
    return np.asarray(cv2.remap(smooth, grid[0], grid[1], cv2.INTER_LINEAR), dtype=np.float32)


def _mask(
    found: SweepResult, grid: SweepGrid, ground_mm: float, block: str, options: DenseOptions
) -> RadiusMap:
    """Keep cells that agree well and whose half-results tell the same."""
    with np.errstate(invalid="ignore"):
        differs_mm = 1000 * (found.radius_ahead_m - found.radius_behind_m)
        one_sided = ~np.isfinite(differs_mm)
        good = found.score > np.where(one_sided, (1 + options.least_score) / 2, options.least_score)
        good &= one_sided | (np.abs(differs_mm) < options.consistency_mm)
    if good.mean() < 0.02:
        raise StageError(
            "dense",
            f"{block}: only {100 * good.mean():.1f} % of the surface could be matched",
            "check the focus, the lens and the stand-off of this block",
        )
    both = good & ~one_sided
    noise_mm = float(1.4826 * np.median(np.abs(differs_mm[both])) / 2) if both.any() else float("nan")
    return RadiusMap(
        axis=grid.axis,
        azimuth=grid.azimuth,
        y_m=grid.y_m,
        radius_m=np.where(good, found.radius_m, np.nan).astype(np.float32),
        score=found.score,
        noise_mm=noise_mm,
        ground_sample_mm=ground_mm,
        coverage=float(good.mean()),
    )
