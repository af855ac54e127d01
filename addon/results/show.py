"""A run folder, finished or not, into the scene: each kind of thing in a collection of its own.

In pieces: what is read and reckoned is done beside Blender, what is made of it stays unlinked until all is
there.  Until then the scene shows no run at all, so nothing speaks of what is not there.
"""

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

from pipeline.opened import OpenedBlock, OpenedRun
from pipeline.report.types import Cloud

from ..pieces import Pieces, beside
from ..segments import read_run
from . import collections
from .cameras import camera_objects
from .clouds import cloud_object
from .crop_preview import end_preview
from .deviation import attach_deviation, colour_surface, mosaic_meshes
from .marks import show_marks
from .meshes import Prepared, mesh_object, prepared
from .stations import Sections, sections_of, show_stations

SPARSE_M, DENSE_M = 0.0006, 0.00025
CAMERA_M = 0.02
FILLED = (
    collections.SPARSE,
    collections.CAMERAS,
    collections.BLOCKS,
    collections.DENSE,
    collections.MOSAIC,
    collections.STATIONS,
)

_WAITING = "cabletwin_waiting"
"""On an object that is not linked yet: the kind of collection that it belongs to."""


def show_run(scene: bpy.types.Scene, folder: Path, most_points: int) -> Pieces[OpenedRun]:
    """Put everything that is finished into the scene, in place of what another run left there.

    Args:
        scene: that holds the survey.
        folder: the run folder.
        most_points: of each cloud.

    Raises:
        StageError: there is nothing to show.
    """
    run = yield from beside(partial(read_run, folder))
    end_preview(scene)
    scene.cabletwin.results.forget()
    for kind in FILLED:
        collections.emptied(scene, kind)
    _discard_waiting()  # of another time, brought back by an undo
    try:
        for block in run.blocks:
            yield from _block(block, run, most_points)
        yield from _mosaic(run, most_points)
        sections = yield from beside(partial(sections_of, run))
    except GeneratorExit:  # nobody waits for it any more
        _discard_waiting()
        raise
    for item in _waiting():
        collections.collection(scene, item[_WAITING]).objects.link(item)
        del item[_WAITING]
    _tell(scene, run, sections)
    colour_surface(scene)
    _uncover(scene, done=run.ring is not None)
    return run


def show_measurement(scene: bpy.types.Scene, run: OpenedRun) -> Pieces[None]:
    """What was measured on a surface that is there already: stations, deviation, the panels' figures."""
    sections = yield from beside(partial(sections_of, run))
    for mesh in mosaic_meshes(scene):
        yield from attach_deviation(mesh, run)
    _tell(scene, run, sections)
    colour_surface(scene)


def _tell(scene: bpy.types.Scene, run: OpenedRun, sections: Sections) -> None:
    scene.cabletwin.results.take(run)
    show_stations(scene, run, sections)
    show_marks(scene)


def _uncover(scene: bpy.types.Scene, *, done: bool) -> None:
    """Let be seen what the run came to: the cable, or else its parts."""
    for kind in (collections.SETUP, collections.PATHS, collections.PAIRS):
        collections.set_hidden(scene, kind, True)
    for kind in (collections.CAMERAS, collections.BLOCKS, collections.SPARSE, collections.DENSE):
        collections.set_hidden(scene, kind, done)
    for kind in (collections.MOSAIC, collections.STATIONS):
        collections.set_hidden(scene, kind, False)


def _waiting() -> list[bpy.types.Object]:
    return [item for item in bpy.data.objects if _WAITING in item]


def _discard_waiting() -> None:
    for item in _waiting():
        collections.remove(item)


def _block(block: OpenedBlock, run: OpenedRun, most_points: int) -> Pieces[None]:
    """Tie points, cameras and mesh of a block, each where it belongs."""
    placed = Matrix(block.cable_from_block.tolist())
    meshes = yield from beside(partial(_block_meshes, block, run))
    for kind, items in (
        (collections.SPARSE, _sparse(block, most_points)),
        (collections.CAMERAS, _cameras(block)),
        (collections.BLOCKS, (mesh_object(block.name, m) for m in meshes)),
    ):
        for item in items:
            item["cabletwin_block"] = block.name
            item.matrix_world = placed @ item.matrix_world
            item[_WAITING] = kind
        yield None


def _sparse(block: OpenedBlock, most_points: int) -> Iterator[bpy.types.Object]:
    if block.orientation is not None:
        yield cloud_object(f"{block.name} tie points", block.orientation.points, None, SPARSE_M, most_points)


def _cameras(block: OpenedBlock) -> Iterator[bpy.types.Object]:
    if block.orientation is not None and block.flat is not None:
        flat, poses = block.flat, block.orientation.poses
        yield from camera_objects(block.name, poses, flat.pinhole, flat.frames.files, CAMERA_M)


def _block_meshes(block: OpenedBlock, run: OpenedRun) -> list[Prepared]:
    """The block's mesh as far as it is: cropped where it was cropped."""
    if block.surface is None or block.picture is None:
        return []
    from pipeline.report.block_model import block_mesh

    stands = np.isfinite(block.surface.radius_m) if block.crop is None else block.crop.keep
    return [prepared(block_mesh(block.surface, block.picture, stands, run.options.surface))]


def _mosaic(run: OpenedRun, most_points: int) -> Pieces[None]:
    ring = run.ring
    if ring is None:
        return

    def cloud_of() -> Cloud:
        from pipeline.report.model import ring_cloud

        return ring_cloud(ring)

    def mesh_of() -> Prepared:
        from pipeline.report.model import ring_mesh

        return prepared(ring_mesh(ring))

    cloud = yield from beside(cloud_of)
    item = cloud_object("Dense cloud", cloud.points, cloud.colours, DENSE_M, most_points)
    item[_WAITING] = collections.DENSE
    yield None
    cable = mesh_object("Cable", (yield from beside(mesh_of)))
    cable[_WAITING] = collections.MOSAIC
    yield None
    yield from attach_deviation(cable.data, run)
