"""Each block's own files: COLMAP model, cloud, meshes before and after cropping, and its place in the model.

They stand in the block's own adjusted frame, as the block was before mosaicking; ``placement.json`` holds the
similarity that brings them into the cable frame of the joined model.
"""

from pathlib import Path

import numpy as np

from pipeline.cable.colmap_model import write_sparse_model
from pipeline.cable.records import BlockRun, CableRun
from pipeline.core.files import write_json
from pipeline.report.block_model import block_cloud, block_mesh, cable_from_block
from pipeline.report.exports import write_cloud_ply, write_model_ply


def write_block_files(run: CableRun, number: int, folder: Path) -> None:
    """Write ``folder/NAME/`` for one of the run's blocks.

    Raises:
        StageError: the folder cannot be written.
    """
    block = run.blocks[number]
    own = folder / block.block.name
    write_sparse_model(own / "sparse", block.frames, block.orientation)
    _write_meshes(own, block, run)
    write_cloud_ply(own / "cloud.ply", block_cloud(block.surface, block.picture))
    place = {
        "format": 1,
        "cable_from_block": cable_from_block(number, run.mosaic, run.ring.alignment),
        "scale": float(run.mosaic.placement.scales[number]),
    }
    write_json(own / "placement.json", place, "report")


def _write_meshes(folder: Path, block: BlockRun, run: CableRun) -> None:
    everything = np.isfinite(block.surface.radius_m)
    for name, stands in (("mesh_uncropped.ply", everything), ("mesh.ply", block.crop.keep)):
        write_model_ply(folder / name, block_mesh(block.surface, block.picture, stands, run.options.surface))
