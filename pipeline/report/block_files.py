"""Each block's own files: COLMAP model, cloud, meshes before and after cropping, and its place in the model.

They stand in the block's own adjusted frame, as the block was before mosaicking; ``placement.json`` holds the
similarity that brings them into the cable frame of the joined model.
"""

from pathlib import Path

import numpy as np

from pipeline.cable.colmap_model import write_sparse_model
from pipeline.cable.mosaic import Mosaic
from pipeline.cable.records import BlockRun, CableRun
from pipeline.cable.ring import Alignment
from pipeline.cable.surface import mesh_surface
from pipeline.core.files import write_json
from pipeline.core.vocabulary import Array
from pipeline.report.exports import write_cloud_ply, write_model_ply
from pipeline.report.types import Cloud, Mesh


def write_block_files(run: CableRun, folder: Path) -> None:
    """Write ``folder/NAME/`` for every block.

    Raises:
        StageError: the folder cannot be written.
    """
    for number, block in enumerate(run.blocks):
        own = folder / block.block.name
        write_sparse_model(own / "sparse", block.frames, block.orientation)
        _write_meshes(own, block, run)
        _write_cloud(own / "cloud.ply", block)
        _write_placement(own / "placement.json", number, run.mosaic, run.ring.alignment)


def _write_meshes(folder: Path, block: BlockRun, run: CableRun) -> None:
    everything = np.isfinite(block.surface.radius_m)
    for name, stands in (("mesh_uncropped.ply", everything), ("mesh.ply", block.crop.keep)):
        tin = mesh_surface(block.surface, stands, run.options.surface)
        row, column = np.divmod(tin.cells, _columns(block, run))
        mesh = Mesh(
            vertices=tin.vertices,
            normals=tin.normals,
            faces=tin.faces,
            uv=_picture_places(block, run, row, column),
            texture=np.ascontiguousarray(block.picture.colour[..., ::-1]),
        )
        write_model_ply(folder / name, mesh)


def _steps(block: BlockRun, run: CableRun) -> tuple[int, int]:
    along_m, around_m = block.surface.cell_m
    edge_m = run.options.surface.mesh_mm / 1000
    return max(round(edge_m / along_m), 1), max(round(edge_m / around_m), 1)


def _columns(block: BlockRun, run: CableRun) -> int:
    return len(block.surface.azimuth[:: _steps(block, run)[1]])


def _picture_places(block: BlockRun, run: CableRun, row: Array, column: Array) -> Array:
    """Texture coordinates (n, 2) of thinned cells in the block's unrolled picture."""
    along, around = _steps(block, run)
    picture, surface = block.picture, block.surface
    azimuth, y_m = surface.azimuth[::around][column], surface.y_m[::along][row]
    u = (np.interp(azimuth, picture.azimuth, np.arange(len(picture.azimuth))) + 0.5) / len(picture.azimuth)
    v = (np.interp(y_m, picture.y_m, np.arange(len(picture.y_m))) + 0.5) / len(picture.y_m)
    return np.stack([u, v], axis=1)


def _write_cloud(path: Path, block: BlockRun) -> None:
    """Every measured cell, with the colour of its place in the unrolled picture."""
    surface, picture = block.surface, block.picture
    row, column = np.nonzero(surface.measured & np.isfinite(surface.radius_m))
    points = surface.points()[row, column]
    out = np.broadcast_to(surface.outward(), (*surface.radius_m.shape, 3))[row, column]
    x = np.interp(surface.azimuth[column], picture.azimuth, np.arange(len(picture.azimuth)))
    y = np.interp(surface.y_m[row], picture.y_m, np.arange(len(picture.y_m)))
    colours = np.ascontiguousarray(picture.colour[np.rint(y).astype(int), np.rint(x).astype(int), ::-1])
    write_cloud_ply(path, Cloud(points=points, normals=out, colours=colours))


def _write_placement(path: Path, number: int, mosaic: Mosaic, alignment: Alignment) -> None:
    """``cable_from_block``: a 4 x 4 matrix, metres to metres."""
    place = mosaic.placement
    scaled = place.scales[number] * place.rotations[number]
    shift = place.origins[number] + place.shifts[number] - scaled @ place.origins[number]
    matrix = np.eye(4)
    matrix[:3, :3] = alignment.rotation @ scaled
    matrix[:3, 3] = alignment.rotation @ shift + alignment.translation
    write_json(
        path, {"format": 1, "cable_from_block": matrix, "scale": float(place.scales[number])}, "report"
    )
