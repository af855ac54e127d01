"""The panel *POS*: constructed or from a file, which names match, and the paths in the viewport."""

import bpy
from bpy.app.translations import pgettext_iface as translated

from ..properties.block import CableTwinBlock
from ..results import collections
from .base import Panel, RowList, aligned, sentence

_ICONS = {"MATCHED": "CHECKMARK", "NO_FRAME": "ERROR", "TAKEN": "ERROR", "NO_ROW": "REMOVE"}


class CABLETWIN_UL_pos_rows(RowList):
    """Rows of a POS file with their frames."""

    def draw_row(self, row: bpy.types.UILayout, item: bpy.types.PropertyGroup) -> None:
        """Name, and its frame or what is wrong."""
        row.label(text=item.name, icon=_ICONS[item.state], translate=False)
        if item.frame >= 0:
            row.label(text=translated("frame {}").format(item.frame), translate=False)
        if item.state != "MATCHED":
            row.label(text=translated(item.bl_rna.properties["state"].enum_items[item.state].name))


class CABLETWIN_PT_pos(Panel):
    """POS."""

    bl_idname = "CABLETWIN_PT_pos"
    bl_label = "POS"
    bl_order = 2

    def draw(self, context: bpy.types.Context) -> None:
        """Which block, where its POS comes from, the paths."""
        scene = context.scene
        survey = scene.cabletwin.survey
        block = survey.block()
        if block is None:
            self.layout.label(text="Start with a new survey or open one", icon="INFO")
            return
        self.layout.template_list(
            "CABLETWIN_UL_blocks", "pos", survey, "blocks", survey, "block_index", rows=2
        )
        self.layout.row().prop(block, "pos_from", expand=True)
        if block.pos_from == "CSV":
            aligned(self.layout).prop(block, "pos", text="File")
            row = self.layout.row(align=True)
            row.operator("cabletwin.pos_import", icon="IMPORT")
            row.operator("cabletwin.pos_check", text="", icon="FILE_REFRESH")
            _matches(self.layout, scene.cabletwin.pos, block)
        else:
            self.layout.operator("cabletwin.pos_write", icon="EXPORT")
        row = self.layout.row(align=True)
        row.operator("cabletwin.pos_show", icon="CURVE_PATH")
        _eye(row, context)


def _matches(layout: bpy.types.UILayout, pos: bpy.types.PropertyGroup, block: CableTwinBlock) -> None:
    """What the file was found to hold when it was last looked at."""
    if pos.block != block.name or pos.filepath != bpy.path.abspath(block.pos):
        return
    if pos.problem:
        sentence(layout.box(), pos.problem, "ERROR")
    column = layout.column(align=True)
    column.label(text=translated("{} rows match a frame").format(pos.matched), translate=False)
    if pos.strangers:
        column.label(text=translated("{} rows match none").format(pos.strangers), translate=False)
    if pos.missing:
        column.label(
            text=translated("{} frames have no row").format(pos.missing),
            translate=False,
        )
    layout.template_list("CABLETWIN_UL_pos_rows", "", pos, "rows", pos, "row_index", rows=4)


def _eye(row: bpy.types.UILayout, context: bpy.types.Context) -> None:
    found = collections.existing(context.scene, collections.PATHS)
    layer = None if found is None else collections.view_layer_collection(context.view_layer, found)
    if layer is not None:
        row.prop(layer, "hide_viewport", text="")


classes = (CABLETWIN_UL_pos_rows, CABLETWIN_PT_pos)
