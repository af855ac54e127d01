"""Stage *dense*: the radius of every cell of one block's surface (paper, section 2.4).

Takes the original frames and the adjusted block; gives a radius map about the block's own axis with a quality
measure and a consistency mask.  Sweeps three times: coarse cells over the whole search range; then cells of
middle size, in small windows and sharp pictures, which tell relief but are noisy; then fine cells in large
windows warped about that relief.  Leaves out meshing (surface) and colour (texture).
"""

from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path

import numpy as np

from pipeline.cable.adjust import Orientation
from pipeline.cable.patch_match import match_patches
from pipeline.cable.start_surface import edge_keeping_start, smooth_start
from pipeline.cable.strips import Strips, SweepPass
from pipeline.cable.sweep import Image, SweepGrid, SweepResult
from pipeline.core.axis import AxisCurve, axis_of_cylinder
from pipeline.core.errors import StageError
from pipeline.core.events import Emit
from pipeline.core.fits.cylinder import Cylinder, fit_cylinder
from pipeline.core.vocabulary import Array, FrameSequence

COARSE_WINDOW = 9
FINE_BASELINE_POWER = 2.0
"""Short baselines help to find the surface and blur it when it is measured: weights as in least squares."""
MIDDLE, MIDDLE_WINDOW = 2, 3
"""Cells of the second sweep, in fine cells, and its window: 2 mm at 0.34 mm a cell, narrower than a rib."""
SHARP_PX = 1.2
"""Cells up to so many pixels wide are looked up in the frames as they are."""
MIDDLE_STEPS, FINE_STEPS = 9, 4
"""Candidates on either side of the start: a rib of 2 mm that the coarse sweep smoothed away is in reach."""


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
        window: side of the last comparison window in fine cells, odd.
        detail_cells: brightness is counted from that of surroundings so wide (sigma of a Gaussian), so that
            the shading by lamps that move along is not matched; 0 matches it.
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
    detail_cells: float = field(default=1.5, metadata={"minimum": 0.0})
    baselines_mm: tuple[float, ...] = field(default=(40.0, 80.0, 100.0, 120.0), metadata={"above": 0.0})
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
    found = _sweep_thrice(frames, orientation, cylinder, azimuth_deg, ground_mm, options, emit)
    return _mask(*found, ground_mm, frames.block, options)


def _sweep_thrice(
    frames: FrameSequence,
    orientation: Orientation,
    cylinder: Cylinder,
    azimuth_deg: float,
    ground_mm: float,
    options: DenseOptions,
    emit: Emit,
) -> tuple[SweepResult, SweepGrid]:
    cell_mm = options.cell_mm or ground_mm
    coarse, middle, fine = (
        _grid(orientation, cylinder, azimuth_deg, cell_mm * size, options)
        for size in (options.coarse, MIDDLE, 1)
    )
    strips = Strips(frames, orientation, options.baselines_mm, 3, emit)

    def sweep(
        grid: SweepGrid, start_m: Image, steps: int, window: int, size: int, power: float = 0.0
    ) -> SweepResult:
        offsets_m = np.arange(-steps, steps + 1) * _step_mm(options, cell_mm * size) / 1000
        cell_px = cell_mm * size / ground_mm
        return strips.sweep(
            SweepPass(
                grid=grid,
                start_m=start_m,
                offsets_m=offsets_m,
                window=window,
                blur_px=cell_px / 2 if cell_px > SHARP_PX else 0.0,
                detail_px=options.detail_cells * cell_px,
                baseline_power=power,
            )
        )

    steps = max(round(options.search_mm / _step_mm(options, cell_mm * options.coarse)), 1)
    start_m = np.full((len(coarse.y_m), len(coarse.azimuth)), cylinder.radius, dtype=np.float32)
    found = sweep(coarse, start_m, steps, COARSE_WINDOW, options.coarse)
    start_m = smooth_start(found, coarse, middle, cylinder.radius)
    found = sweep(middle, start_m, MIDDLE_STEPS, MIDDLE_WINDOW, 1)
    start_m = edge_keeping_start(found, middle, fine, cylinder.radius)
    return sweep(fine, start_m, FINE_STEPS, options.window, 1, FINE_BASELINE_POWER), fine


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
