"""Operators of the list of pairs: remove, hold another one, read a file; they are picked in mosaic_pick."""

from pathlib import Path

import bpy
from bpy_extras.io_utils import ImportHelper

from ..hand_pairs import add_pairs
from ..opened import opened
from ..results.marks import show_marks
from .base import Operator, take_out
from .mosaic import gap_mm

_UNDOABLE = {"REGISTER", "UNDO"}
_HIDDEN = {"HIDDEN", "SKIP_SAVE"}


class CABLETWIN_OT_mosaic_remove(Operator):
    """Take a pair out of the list."""

    bl_idname = "cabletwin.mosaic_remove"
    bl_label = "Remove Pair"
    bl_description = "Take the chosen pair out of the list"
    bl_options = _UNDOABLE

    index: bpy.props.IntProperty(
        name="Pair", description="Its place in the list; -1 is the chosen one", default=-1, options=_HIDDEN
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be one."""
        return len(context.scene.cabletwin.mosaic.pairs) > 0

    def work(self, context: bpy.types.Context) -> None:
        """Remove it with its marks."""
        mosaic = context.scene.cabletwin.mosaic
        mosaic.pair_index = take_out(mosaic.pairs, mosaic.pair_index if self.index < 0 else self.index)
        mosaic.joins.clear()
        show_marks(context.scene)


class CABLETWIN_OT_mosaic_clear(Operator):
    """Take all pairs out of the list."""

    bl_idname = "cabletwin.mosaic_clear"
    bl_label = "Remove All Pairs"
    bl_description = "Take all pairs out of the list"
    bl_options = _UNDOABLE

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be some."""
        return len(context.scene.cabletwin.mosaic.pairs) > 0

    def work(self, context: bpy.types.Context) -> None:
        """Clear list and marks."""
        mosaic = context.scene.cabletwin.mosaic
        mosaic.pairs.clear()
        mosaic.joins.clear()
        mosaic.pair_index = 0
        show_marks(context.scene)


class CABLETWIN_OT_mosaic_hold(Operator):
    """Hold the chosen pair together instead of another one of the same two blocks."""

    bl_idname = "cabletwin.mosaic_hold"
    bl_label = "Hold Together"
    bl_description = "Hold this pair together when fitting, instead of the first one of its two blocks"
    bl_options = _UNDOABLE

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """A pair that is not held yet must be chosen."""
        mosaic = context.scene.cabletwin.mosaic
        return mosaic.pair() is not None and not mosaic.held()[mosaic.pair_index]

    def work(self, context: bpy.types.Context) -> None:
        """Move it before the others of its two blocks."""
        mosaic = context.scene.cabletwin.mosaic
        pair = mosaic.pair()
        blocks = {pair.block_a, pair.block_b}
        first = next(n for n, p in enumerate(mosaic.pairs) if {p.block_a, p.block_b} == blocks)
        mosaic.pairs.move(mosaic.pair_index, first)
        mosaic.pair_index = first
        mosaic.joins.clear()
        show_marks(context.scene)


class CABLETWIN_OT_mosaic_read(Operator, ImportHelper):
    """Read pairs from a file, in place of those in the list."""

    bl_idname = "cabletwin.mosaic_read"
    bl_label = "Read Pairs"
    bl_description = "Read pairs from a CSV file, such as the run folder's pairs.csv, in place of these"
    bl_options = _UNDOABLE

    filename_ext = ".csv"
    filter_glob: bpy.props.StringProperty(default="*.csv", options={"HIDDEN"})

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """A run must be shown."""
        if not context.scene.cabletwin.results.blocks:
            cls.poll_message_set("Open a run folder first")
            return False
        return True

    def work(self, context: bpy.types.Context) -> None:
        """Read, fill the list, draw the marks."""
        from pipeline.cable.pairs import read_pairs

        scene = context.scene
        mosaic, names = scene.cabletwin.mosaic, [b.name for b in opened(scene).blocks]
        pairs = read_pairs(Path(bpy.path.abspath(self.filepath)), tuple(names))
        mosaic.pairs.clear()
        mosaic.joins.clear()
        add_pairs(mosaic, pairs, names, found=False)
        for pair in mosaic.pairs:
            pair.residual_mm = gap_mm(scene, pair)
        mosaic.pair_index, mosaic.way = 0, "BY_HAND"
        show_marks(scene)


classes = (
    CABLETWIN_OT_mosaic_remove,
    CABLETWIN_OT_mosaic_clear,
    CABLETWIN_OT_mosaic_hold,
    CABLETWIN_OT_mosaic_read,
)
