"""What a crop keeps and what it cuts: the uncropped blocks, drawn apart, with the cut faces in red.

The decision is the pipeline's own, made anew whenever an option changes.  Everything that must survive saving
and undo is in the meshes: which faces are cut, and the cell that each vertex came from.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import bpy
import numpy as np
from bpy.app.translations import pgettext_n as n_
from mathutils import Matrix, Vector

from pipeline.core.errors import StageError
from pipeline.opened import OpenedBlock, OpenedRun

from ..gather import crop_options, gather_survey
from ..opened import opened
from ..segments import number_of, place_of
from ..wording import framed
from . import collections
from .materials import plain_material
from .meshes import mesh_object, prepared
from .picking import block_objects

if TYPE_CHECKING:
    from pipeline.cable.crop import CropOptions

KIND = n_("Crop preview")
RED = (0.7, 0.04, 0.02, 1.0)
APART = 0.35
"""So far each block stands off the cable, by its radius: where blocks overlap, both are to be seen."""
CELL, SLOT = "cabletwin_cell", "material_index"
COVERED = (collections.BLOCKS, collections.MOSAIC, collections.DENSE, collections.SPARSE)


def begin_preview(scene: bpy.types.Scene) -> None:
    """Show the uncropped blocks with what would be cut, and hide what lies over them.

    Raises:
        StageError: no run is shown, its surfaces are not finished, or the survey is not its survey.
    """
    run = opened(scene)
    list(_crops(scene, run))
    target = collections.emptied(scene, KIND)
    for block in run.blocks:
        target.objects.link(_uncropped(scene, block, run))
    crop = scene.cabletwin.crop
    if not crop.previewing:
        crop.hidden = "\n".join(_hide(scene))
    crop.previewing = True
    refresh_preview(scene)


def refresh_preview(scene: bpy.types.Scene) -> None:
    """Decide again what stays.  What is wrong stands in ``crop.message``: a slider cannot raise."""
    state = scene.cabletwin.crop
    state.message = ""
    state.shares.clear()
    try:
        run = opened(scene)
        for name, keep, error in _crops(scene, run):
            if error is not None:
                state.message = framed(str(error))
            for item in _objects(scene, name):
                _mark(item, keep)
            share = state.shares.add()
            share.name, share.share = name, float(keep.mean())
    except StageError as error:
        state.message = framed(str(error))


def end_preview(scene: bpy.types.Scene) -> None:
    """Take the preview away and show again what it hid."""
    state = scene.cabletwin.crop
    if collections.existing(scene, KIND):
        collections.emptied(scene, KIND)
    for kind in filter(None, state.hidden.split("\n")):
        collections.set_hidden(scene, kind, False)
    for key in ("previewing", "message", "hidden", "shares"):
        state.property_unset(key)


def check_crop(scene: bpy.types.Scene) -> None:
    """Refuse options of which nothing would be left, in the pipeline's words, as far as a run is shown.

    Raises:
        StageError: the pipeline would refuse them.
    """
    if scene.cabletwin.results.folder:
        for _, _, error in _crops(scene, opened(scene)):
            if error is not None:
                raise error


def _crops(scene: bpy.types.Scene, run: OpenedRun) -> Iterator[tuple[str, np.ndarray, StageError | None]]:
    """Name, kept cells (n, m) and what is wrong, of every block."""
    from pipeline.cable.crop import crop_block

    survey, options = gather_survey(scene), _options_here(crop_options(scene), run)
    known = {b.name: b for b in survey.blocks}
    for block in run.blocks:
        if block.surface is None or block.picture is None:
            raise StageError("crop", f"{block.name} has no surface yet", "run the reconstruction first")
        if block.name not in known:
            raise StageError("crop", f"the survey has no {block.name}", "open the survey of this run")
        angle_deg, standoff_m = known[block.name].angle_deg, survey.robot.standoff_m
        try:
            yield block.name, crop_block(block.name, block.surface, angle_deg, standoff_m, options).keep, None
        except StageError as error:
            yield block.name, np.zeros(block.surface.radius_m.shape, dtype=bool), error


def _options_here(options: "CropOptions", run: OpenedRun) -> "CropOptions":
    """Ends of the crop in the run's own places, as a segment of a long survey has them.

    Raises:
        StageError: nothing of the shown segment lies between them.
    """
    start_m = place_of(run.folder).start_m
    ends = {
        key: end_m - start_m
        for key, end_m in (("from_m", options.from_m), ("to_m", options.to_m))
        if end_m is not None
    }
    surface = run.blocks[0].surface
    if number_of(run.folder) and surface is not None:
        first_m, last_m = float(surface.y_m[0]), float(surface.y_m[-1])
        if ends.get("from_m", first_m) > last_m or ends.get("to_m", last_m) < first_m:
            raise StageError(
                "crop",
                f"nothing stays of segment {number_of(run.folder)}, which lies from "
                f"{first_m + start_m:.2f} to {last_m + start_m:.2f} m",
                "show a segment that start and end leave something of",
            )
    return replace(options, **ends)


def _uncropped(scene: bpy.types.Scene, block: OpenedBlock, run: OpenedRun) -> bpy.types.Object:
    from pipeline.cable.surface import mesh_cells, mesh_surface
    from pipeline.report.block_model import textured

    surface, picture, options = block.surface, block.picture, run.options.surface
    if surface is None or picture is None:
        raise StageError("crop", f"{block.name} has no surface yet", "run the reconstruction first")
    tin = mesh_surface(surface, np.isfinite(surface.radius_m), options)
    twin = block_objects(scene).get(block.name)
    material = twin.data.materials[0] if twin is not None and twin.data.materials else None
    made = mesh_object(
        f"{block.name} crop",
        prepared(textured(tin, surface, picture, options), picture=material is None),
        material,
    )
    data = made.data
    data.materials.append(plain_material(RED))
    # flat index into the whole map, so that a preview needs no more than the crop itself
    rows, columns = mesh_cells(surface, options)
    count = surface.radius_m.shape[1]
    cells = (np.arange(surface.radius_m.shape[0])[rows, None] * count + np.arange(count)[columns]).ravel()
    data.attributes.new(CELL, "INT", "POINT").data.foreach_set("value", cells[tin.cells].astype(np.int32))
    data.attributes.new(SLOT, "INT", "FACE")
    made["cabletwin_block"] = block.name
    middle = tin.vertices.mean(axis=0)
    aside = Matrix.Translation(APART * Vector((middle[0], 0.0, middle[2])))
    made.matrix_world = Matrix(block.cable_from_block.tolist()) @ aside
    return made


def _mark(item: bpy.types.Object, keep: np.ndarray) -> None:
    """A face stays if all its corners do, as in the pipeline's mesh."""
    data = item.data
    cells = np.empty(len(data.vertices), dtype=np.int32)
    data.attributes[CELL].data.foreach_get("value", cells)
    corners = np.empty(len(data.loops), dtype=np.int32)
    data.attributes[".corner_vert"].data.foreach_get("value", corners)  # the loops themselves are slow
    stays = keep.ravel()[cells][corners].reshape(-1, 3).all(axis=1)
    data.attributes[SLOT].data.foreach_set("value", (~stays).astype(np.int32))
    data.update()


def _objects(scene: bpy.types.Scene, block: str) -> list[bpy.types.Object]:
    found = collections.existing(scene, KIND)
    return [o for o in found.objects if o.get("cabletwin_block") == block] if found else []


def _hide(scene: bpy.types.Scene) -> list[str]:
    """Hide what lies over the preview; gives what was seen before."""
    return [kind for kind in COVERED if collections.set_hidden(scene, kind, True)]
