"""Stage *dense*: the radius of every cell of one block's surface (paper, section 2.4).

Takes the original frames and the adjusted block; gives a radius map about the block's own axis with a quality
measure and a consistency mask: by our own sweeps (``block_sweeps.py``) or by COLMAP's patch matching.  Leaves
out meshing (surface) and colour (texture).
"""

from pathlib import Path

from pipeline.cable import broad
from pipeline.cable.adjust import Orientation
from pipeline.cable.block_sweeps import BlockSweeps, block_grid, ground_sample_mm, radius_map
from pipeline.cable.dense_records import DenseMethod, DenseOptions, RadiusMap
from pipeline.cable.patch_match import match_patches
from pipeline.core.events import Emit
from pipeline.core.fits.cylinder import fit_cylinder
from pipeline.core.vocabulary import FrameSequence

__all__ = ["DenseMethod", "DenseOptions", "RadiusMap", "sweep_block"]


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
    if options.method is DenseMethod.PATCH_MATCH:
        cylinder = fit_cylinder(orientation.points, direction=(0.0, 1.0, 0.0))
        ground_mm = ground_sample_mm(orientation, cylinder)
        cell_mm = options.cell_mm or ground_mm
        grid = block_grid(orientation, cylinder, azimuth_deg, cell_mm, options)
        found = match_patches(frames, orientation, grid, scratch, emit)
        stands = broad.trusted(found, options.least_score, options.consistency_mm)
        return radius_map(found, stands, grid, ground_mm, options.window * cell_mm, frames.block)
    return BlockSweeps(frames, orientation, azimuth_deg, options, emit).run()
