"""COLMAP's PatchMatch stereo in place of our sweep, where pycolmap was built with CUDA.

Takes frames, the adjusted block and the grid of cells; gives what the sweep gives.  The fused points are
dropped into the cells; the two half-results are the medians of every other point of a cell, so that noise
and consistency mean the same as in the sweep.
"""

import shutil
from pathlib import Path

import numpy as np

from pipeline.cable.adjust import Orientation
from pipeline.cable.colmap_model import write_sparse_model
from pipeline.cable.surface_view import SweepGrid
from pipeline.cable.sweep import SweepResult
from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event
from pipeline.core.vocabulary import Array, FrameSequence

STEPS = 3


def match_patches(
    frames: FrameSequence, orientation: Orientation, grid: SweepGrid, scratch: Path, emit: Emit
) -> SweepResult:
    """Match one block with PatchMatch stereo and fuse it onto the grid.

    Raises:
        StageError: this pycolmap has no CUDA.
    """
    # here and not above: whoever only reads products (Blender) must not load pycolmap
    import cv2  # noqa: F401 - before pycolmap: the other way round the two libraries' PNG writers collide
    import pycolmap

    if not pycolmap.has_cuda:
        raise StageError(
            "dense",
            "dense.method = patch-match needs a pycolmap built with CUDA, which this one is not",
            "leave dense.method at sweep, or install such a pycolmap",
        )
    try:
        emit(Event(stage="dense", block=frames.block, done=0, total=STEPS))
        write_sparse_model(scratch / "sparse", frames, orientation)
        pycolmap.undistort_images(scratch / "dense", scratch / "sparse", frames.files[0].parent)
        emit(Event(stage="dense", block=frames.block, done=1, total=STEPS))
        pycolmap.patch_match_stereo(scratch / "dense")
        emit(Event(stage="dense", block=frames.block, done=2, total=STEPS))
        fused = pycolmap.stereo_fusion(scratch / "fused", scratch / "dense")
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
    return grid_points(np.array([p.xyz for p in fused.points3D.values()]).reshape(-1, 3), grid)


def grid_points(points: Array, grid: SweepGrid) -> SweepResult:
    """Drop points (n, 3) into the cells: median radius; score 1 where at least two points agree on it."""
    shape = (len(grid.y_m), len(grid.azimuth))
    azimuth, y_m, radius = grid.axis.unroll(points)
    middle = grid.azimuth.mean()
    turned = middle + np.angle(np.exp(1j * (azimuth - middle)))
    column = np.rint((turned - grid.azimuth[0]) / (grid.azimuth[1] - grid.azimuth[0])).astype(int)
    row = np.rint((y_m - grid.y_m[0]) / (grid.y_m[1] - grid.y_m[0])).astype(int)
    inside = (column >= 0) & (column < shape[1]) & (row >= 0) & (row < shape[0])
    cell, radius = (row * shape[1] + column)[inside], radius[inside]
    halves = [_medians(cell[part::2], radius[part::2], shape) for part in (0, 1)]
    whole = _medians(cell, radius, shape)
    count = np.bincount(cell, minlength=shape[0] * shape[1]).reshape(shape)
    return SweepResult(
        radius_m=whole,
        score=np.where(count >= 2, 1.0, np.where(count == 1, 0.4, np.nan)).astype(np.float32),
        radius_ahead_m=halves[0],
        radius_behind_m=halves[1],
    )


def _medians(cell: np.ndarray, values: Array, shape: tuple[int, int]) -> np.ndarray:
    """Median of the values in each cell, float32; NaN where there is none."""
    order = np.lexsort((values, cell))
    cell, values = cell[order], values[order]
    first = np.flatnonzero(np.diff(cell, prepend=-1))
    count = np.diff(np.append(first, len(cell)))
    found = np.full(shape[0] * shape[1], np.nan, dtype=np.float32)
    low, high = first + (count - 1) // 2, first + count // 2
    found[cell[first]] = (values[low] + values[high]) / 2
    return found.reshape(shape)
