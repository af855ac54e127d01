"""Operators of the mosaic: fit the blocks by hand or automatically, close the ring, look at a seam, apply."""

import bpy

from pipeline.core.errors import StageError

from ..hand_pairs import add_pairs, gather_pairs
from ..jobs import Job
from ..opened import opened
from ..pieces import Pieces
from ..results.joined import look_at_seam, place_blocks, seam, show_blocks, show_only
from ..results.marks import show_marks
from ..segments import place_of
from .base import Operator
from .following import JobOperator
from .results import present_run
from .running import run_folder, start_reconstruction

_UNDOABLE = {"REGISTER", "UNDO"}


class _OnBlocks(Operator):
    """An operator that needs block meshes; not registered itself."""

    bl_options = _UNDOABLE

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """A run must be shown."""
        if not context.scene.cabletwin.results.blocks:
            cls.poll_message_set("Open a run folder first")
            return False
        return True


class CABLETWIN_OT_mosaic_fit(_OnBlocks):
    """Join the blocks as the panel says, and move them to where they belong."""

    bl_idname = "cabletwin.mosaic_fit"
    bl_label = "Fit"
    bl_description = "Bring the blocks as close as they go, the first pair of each two held together"

    def work(self, context: bpy.types.Context) -> None:
        """Join and show."""
        fit(context.scene)


class CABLETWIN_OT_mosaic_close(_OnBlocks):
    """Add a pair for every two neighbours that have none, and fit all at once."""

    bl_idname = "cabletwin.mosaic_close"
    bl_label = "Close the Ring"
    bl_description = (
        "Add an automatic pair for every two neighbours that have none, the last and the first included, "
        "and fit all blocks at once"
    )

    def work(self, context: bpy.types.Context) -> None:
        """Find what is missing, then fit."""
        from pipeline.joining import closing_pairs

        scene = context.scene
        mosaic, run = scene.cabletwin.mosaic, opened(scene)
        names = [b.name for b in run.blocks]
        add_pairs(mosaic, closing_pairs(run, gather_pairs(mosaic, names)), names, found=True)
        mosaic.way = "BY_HAND"
        fit(scene)


class CABLETWIN_OT_mosaic_look(_OnBlocks):
    """Show two blocks only, and look at where they meet."""

    bl_idname = "cabletwin.mosaic_look"
    bl_label = "Look at Seam"
    bl_description = "Hide all other blocks and look at where these two meet"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Two blocks must be chosen, or a pair."""
        if not all(chosen_blocks(context.scene)):
            cls.poll_message_set("Choose two blocks or a pair")
            return False
        return super().poll(context)

    def work(self, context: bpy.types.Context) -> None:
        """Hide, turn the view."""
        scene = context.scene
        first, second = chosen_blocks(scene)
        middle, out, length_m = seam(scene, first, second)
        show_blocks(scene)
        show_only(scene, context.view_layer, (first, second))
        if context.space_data is not None and context.space_data.type == "VIEW_3D":
            look_at_seam(context.space_data.region_3d, middle, out, length_m)


class CABLETWIN_OT_mosaic_show_all(_OnBlocks):
    """Show all blocks again."""

    bl_idname = "cabletwin.mosaic_show_all"
    bl_label = "Show All Blocks"
    bl_description = "Show the blocks that were hidden"

    def work(self, context: bpy.types.Context) -> None:
        """Unhide."""
        show_blocks(context.scene)
        show_only(context.scene, context.view_layer, None)


class CABLETWIN_OT_mosaic_apply(JobOperator):
    """Join the blocks so, and make all that rests on it again."""

    bl_idname = "cabletwin.mosaic_apply"
    bl_label = "Apply"
    bl_description = "Join the blocks as the panel says and make again what rests on it"
    bl_options = _UNDOABLE
    kind = "reconstruct"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be blocks, and no other job."""
        if not context.scene.cabletwin.survey.blocks:
            cls.poll_message_set("The survey has no blocks")
            return False
        return super().poll(context)

    def start(self, context: bpy.types.Context) -> tuple[Job, tuple[str, ...]]:
        """Write the pairs if they count, and start."""
        mosaic = context.scene.cabletwin.mosaic
        if mosaic.way == "BY_HAND" and not mosaic.pairs:
            raise StageError("mosaic", "there are no pairs", "pick one for each two neighbours")
        return start_reconstruction(context, "--from", "mosaic")

    def show(self, context: bpy.types.Context, scene: bpy.types.Scene) -> Pieces[None]:
        """Bring the new results in."""
        yield from present_run(context, scene, run_folder(scene.cabletwin.run))

    def finished(self, context: bpy.types.Context, scene: bpy.types.Scene) -> None:
        """Say so."""
        self.report({"INFO"}, "Joined")


def fit(scene: bpy.types.Scene) -> None:
    """Join the blocks of the shown run as the panel says; move them, and note how well they fit.

    Raises:
        StageError: what the pipeline refuses.
    """
    from pipeline.joining import join_run

    mosaic, run = scene.cabletwin.mosaic, opened(scene)
    names = [b.name for b in run.blocks]
    by_hand = mosaic.way == "BY_HAND"
    joined = join_run(run, gather_pairs(mosaic, names) if by_hand else None)
    place_blocks(scene, names, place_of(run.folder).whole_from_run @ joined.cable_from_block)
    show_blocks(scene)
    show_marks(scene)
    if by_hand:
        for pair, residual in zip(mosaic.pairs, joined.residuals_mm, strict=True):
            pair.residual_mm = float((residual @ residual) ** 0.5)
    else:
        for pair in mosaic.pairs:
            pair.residual_mm = gap_mm(scene, pair)
    mosaic.joins.clear()
    for found in joined.mosaic.joins:
        item = mosaic.joins.add()
        item.block_a, item.block_b = names[found.first], names[found.second]
        item.pairs, item.surface_mm = found.pairs, found.surface_mm
        item.points_mm = float((found.residual_mm @ found.residual_mm) ** 0.5)


def gap_mm(scene: bpy.types.Scene, pair: bpy.types.PropertyGroup) -> float:
    """How far the two points of a pair lie apart as the blocks stand; -1 where a block is not there."""
    from ..results.picking import block_objects

    meshes = block_objects(scene)
    if pair.block_a not in meshes or pair.block_b not in meshes:
        return -1.0
    ends = [
        meshes[name].matrix_world @ point.copy()
        for name, point in ((pair.block_a, pair.point_a), (pair.block_b, pair.point_b))
    ]
    return 1000 * (ends[0] - ends[1]).length


def chosen_blocks(scene: bpy.types.Scene) -> tuple[str, str]:
    """The two blocks that are chosen, or else those of the chosen pair; "" where there is none."""
    mosaic = scene.cabletwin.mosaic
    pair = mosaic.pair()
    if pair is not None and not (mosaic.block_a and mosaic.block_b):
        return pair.block_a, pair.block_b
    return mosaic.block_a, mosaic.block_b


classes = (
    CABLETWIN_OT_mosaic_fit,
    CABLETWIN_OT_mosaic_close,
    CABLETWIN_OT_mosaic_look,
    CABLETWIN_OT_mosaic_show_all,
    CABLETWIN_OT_mosaic_apply,
)
