"""The sweeps of one block: which cells, which windows, in which order.

Coarse cells over the whole search range; then cells of middle size, in small windows and sharp pictures,
which tell relief but are noisy; then fine cells in large windows warped about that relief.  Where much of the
surface has too little texture for that, broad windows fill it (``broad.py``).
"""

import numpy as np
from numpy.typing import NDArray

from pipeline.cable import broad
from pipeline.cable.adjust import Orientation
from pipeline.cable.dense_records import DenseOptions, RadiusMap
from pipeline.cable.start_surface import edge_keeping_start, smooth_start
from pipeline.cable.strips import Strips
from pipeline.cable.surface_view import Image, SweepGrid
from pipeline.cable.sweep import SweepPass, SweepResult
from pipeline.core.axis import axis_of_cylinder
from pipeline.core.errors import StageError
from pipeline.core.events import Emit
from pipeline.core.fits.cylinder import Cylinder, fit_cylinder
from pipeline.core.vocabulary import FrameSequence

COARSE_WINDOW = 9
MEASURING_BASELINE_POWER = 2.0
"""Short baselines help to find the surface and blur it when it is measured: weights as in least squares."""
MIDDLE, MIDDLE_WINDOW = 2, 3
"""Cells of the second sweep, in fine cells, and its window: 2 mm at 0.34 mm a cell, narrower than a rib."""
SHARP_PX = 1.2
"""Cells up to so many pixels wide are looked up in the frames as they are."""
MIDDLE_STEPS, FINE_STEPS = 9, 4
"""Candidates on either side of the start: a rib of 2 mm that the coarse sweep smoothed away is in reach."""
LEAST_COVERAGE = 0.02
"""A block of which less stands is not worth going on with."""
NORMAL_PER_MAD = 1.4826


class BlockSweeps:
    """The sweeps of one block, each on cells and with windows of its own."""

    def __init__(
        self,
        frames: FrameSequence,
        orientation: Orientation,
        azimuth_deg: float,
        options: DenseOptions,
        emit: Emit,
    ) -> None:
        self._block, self._options = frames.block, options
        self._cylinder = fit_cylinder(orientation.points, direction=(0.0, 1.0, 0.0))
        self._ground_mm = ground_sample_mm(orientation, self._cylinder)
        self._cell_mm = options.cell_mm or self._ground_mm
        self._strips = Strips(frames, orientation, options.baselines_mm, 3, emit)
        self._grids = {
            size: block_grid(orientation, self._cylinder, azimuth_deg, self._cell_mm * size, options)
            for size in {options.coarse, MIDDLE, broad.CELLS, 1}
        }

    def run(self) -> RadiusMap:
        """Coarse, middle and fine cells, and broad windows where much is left open."""
        options, grids = self._options, self._grids
        radius_m = self._cylinder.radius
        coarse, middle, fine = grids[options.coarse], grids[MIDDLE], grids[1]
        steps = self._steps(options.search_mm / 1000, options.coarse)
        found = self._sweep(options.coarse, self._level(coarse), steps, COARSE_WINDOW)
        start_m = smooth_start(found, coarse, middle, radius_m)
        found = self._sweep(MIDDLE, start_m, MIDDLE_STEPS, MIDDLE_WINDOW, sharp=True)
        start_m = edge_keeping_start(found, middle, fine, radius_m)
        found = self._sweep(1, start_m, FINE_STEPS, options.window, measures=True)
        stands = broad.trusted(found, options.least_score, options.consistency_mm)
        window_mm = options.window * self._cell_mm
        if stands.mean() < options.broad_below:
            found, stands, window_mm = self._broadened(found, broad.vouched(stands))
        return radius_map(found, stands, fine, self._ground_mm, window_mm, self._block)

    def _broadened(
        self, fine: SweepResult, stands: NDArray[np.bool_]
    ) -> tuple[SweepResult, NDArray[np.bool_], float]:
        """The open cells filled, which cells stand now, and their mean window in mm."""
        grid, options = self._grids[broad.CELLS], self._options
        steps = self._steps(broad.SEARCH_M, broad.CELLS)
        wide = self._sweep(
            broad.CELLS,
            self._level(grid),
            steps,
            broad.WINDOW,
            measures=True,
            detail_cells=broad.DETAIL_CELLS,
        )
        found = broad.filled(fine, self._grids[1], stands, wide, grid)
        now = broad.trusted(found, broad.LEAST_SCORE, options.consistency_mm)
        cells = np.where(stands, options.window, broad.CELLS * broad.WINDOW)[stands | now]
        return found, stands | now, float(self._cell_mm * cells.mean()) if cells.size else 0.0

    def _sweep(
        self,
        size: int,
        start_m: Image,
        steps: int,
        window: int,
        *,
        sharp: bool = False,
        measures: bool = False,
        detail_cells: float | None = None,
    ) -> SweepResult:
        """One sweep, ``steps`` candidates on either side of the start; ``sharp`` as if cells were fine.

        A sweep that only searches leaves relief in its place; one that ``measures`` keeps what windows hold.
        """
        look = 1 if sharp else size
        cell_px = self._cell_mm * look / self._ground_mm
        detail = self._options.detail_cells if detail_cells is None else detail_cells
        return self._strips.sweep(
            SweepPass(
                grid=self._grids[size],
                start_m=start_m,
                offsets_m=np.arange(-steps, steps + 1) * _step_mm(self._options, self._cell_mm * look) / 1000,
                window=window,
                blur_px=cell_px / 2 if cell_px > SHARP_PX else 0.0,
                detail_px=detail * cell_px,
                baseline_power=MEASURING_BASELINE_POWER if measures else 0.0,
                along_sight=measures,
            )
        )

    def _level(self, grid: SweepGrid) -> Image:
        return np.full((len(grid.y_m), len(grid.azimuth)), self._cylinder.radius, dtype=np.float32)

    def _steps(self, search_m: float, size: int) -> int:
        return max(round(1000 * search_m / _step_mm(self._options, self._cell_mm * size)), 1)


def ground_sample_mm(orientation: Orientation, cylinder: Cylinder) -> float:
    """Size of a pixel on the surface."""
    away = orientation.poses.centres - cylinder.axis_at(orientation.poses.centres[:, 1] - cylinder.point[1])
    distance = float(np.median(np.hypot(away[:, 0], away[:, 2]))) - cylinder.radius
    return 1000 * distance / orientation.lens.focal_px


def _step_mm(options: DenseOptions, cell_mm: float) -> float:
    """Radius step that shifts the widest pair by about a third of a cell."""
    return cell_mm / 3 * 250.0 / max(options.baselines_mm)


def block_grid(
    orientation: Orientation, cylinder: Cylinder, azimuth_deg: float, cell_mm: float, options: DenseOptions
) -> SweepGrid:
    """Cells of this size about the block's axis, as far as it looks."""
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


def radius_map(
    found: SweepResult,
    stands: NDArray[np.bool_],
    grid: SweepGrid,
    ground_mm: float,
    window_mm: float,
    block: str,
) -> RadiusMap:
    """Keep the cells that stand."""
    if stands.mean() < LEAST_COVERAGE:
        raise StageError(
            "dense",
            f"{block}: only {100 * stands.mean():.1f} % of the surface could be matched",
            "check the focus, the lens and the stand-off of this block",
        )
    differs_mm = 1000 * np.abs(found.radius_ahead_m - found.radius_behind_m)[stands]
    both = np.isfinite(differs_mm)
    return RadiusMap(
        axis=grid.axis,
        azimuth=grid.azimuth,
        y_m=grid.y_m,
        radius_m=np.where(stands, found.radius_m, np.nan).astype(np.float32),
        score=found.score,
        noise_mm=float(NORMAL_PER_MAD * np.median(differs_mm[both]) / 2) if both.any() else float("nan"),
        window_mm=window_mm,
        ground_sample_mm=ground_mm,
        coverage=float(stands.mean()),
    )
