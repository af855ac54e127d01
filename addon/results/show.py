"""A run folder, finished or not, into the scene: each kind of thing in a collection of its own."""

from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

from pipeline.opened import OpenedBlock, OpenedRun

from ..segments import read_run
from . import collections
from .cameras import camera_objects
from .clouds import cloud_object
from .crop_preview import end_preview
from .deviation import attach_deviation
from .marks import show_marks
from .meshes import mesh_object
from .stations import show_stations

SPARSE_M, DENSE_M = 0.0006, 0.00025
CAMERA_M = 0.02


def show_run(scene: bpy.types.Scene, folder: Path, most_points: int) -> OpenedRun:
    """Put everything that is finished into the scene, in place of what another run left there.

    Args:
        scene: that holds the survey.
        folder: the run folder.
        most_points: of each cloud.

    Raises:
        StageError: there is nothing to show.
    """
    run = read_run(folder)
    end_preview(scene)
    _show_blocks(scene, run, most_points)
    _show_mosaic(scene, run, most_points)
    show_measurement(scene, run)
    done = run.ring is not None
    for kind in (collections.SETUP, collections.PATHS, collections.PAIRS):
        collections.set_hidden(scene, kind, True)
    for kind in (collections.CAMERAS, collections.BLOCKS, collections.SPARSE, collections.DENSE):
        collections.set_hidden(scene, kind, done)
    for kind in (collections.MOSAIC, collections.STATIONS):
        collections.set_hidden(scene, kind, False)
    return run


def show_measurement(scene: bpy.types.Scene, run: OpenedRun) -> None:
    """What was measured on a surface that is there already: stations, deviation, the panels' figures."""
    scene.cabletwin.results.take(run)
    show_stations(scene, run)
    show_marks(scene)
    attach_deviation(scene, run)


def _show_blocks(scene: bpy.types.Scene, run: OpenedRun, most_points: int) -> None:
    sparse, cameras, meshes = (
        collections.emptied(scene, kind)
        for kind in (collections.SPARSE, collections.CAMERAS, collections.BLOCKS)
    )
    for block in run.blocks:
        placed = Matrix(block.cable_from_block.tolist())
        for target, made in (
            (sparse, _sparse(block, most_points)),
            (cameras, _cameras(block)),
            (meshes, _mesh(block, run)),
        ):
            for item in made:
                item["cabletwin_block"] = block.name
                item.matrix_world = placed @ item.matrix_world
                target.objects.link(item)


def _sparse(block: OpenedBlock, most_points: int) -> list[bpy.types.Object]:
    if block.orientation is None:
        return []
    return [cloud_object(f"{block.name} tie points", block.orientation.points, None, SPARSE_M, most_points)]


def _cameras(block: OpenedBlock) -> list[bpy.types.Object]:
    if block.orientation is None or block.flat is None:
        return []
    flat = block.flat
    return camera_objects(block.name, block.orientation.poses, flat.pinhole, flat.frames.files, CAMERA_M)


def _mesh(block: OpenedBlock, run: OpenedRun) -> list[bpy.types.Object]:
    """The block's mesh as far as it is: cropped where it was cropped."""
    if block.surface is None or block.picture is None:
        return []
    from pipeline.report.block_model import block_mesh

    stands = np.isfinite(block.surface.radius_m) if block.crop is None else block.crop.keep
    return [mesh_object(block.name, block_mesh(block.surface, block.picture, stands, run.options.surface))]


def _show_mosaic(scene: bpy.types.Scene, run: OpenedRun, most_points: int) -> None:
    dense, mosaic = (collections.emptied(scene, k) for k in (collections.DENSE, collections.MOSAIC))
    if run.ring is None:
        return
    from pipeline.report.model import ring_cloud, ring_mesh

    cloud = ring_cloud(run.ring)
    dense.objects.link(cloud_object("Dense cloud", cloud.points, cloud.colours, DENSE_M, most_points))
    mosaic.objects.link(mesh_object("Cable", ring_mesh(run.ring)))
