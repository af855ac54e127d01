"""The panel *Mosaic*: pairs of corresponding points, the fit, and how well the blocks meet."""

import bpy
from bpy.app.translations import pgettext_iface as translated
from bpy.app.translations import pgettext_n as n_

from ..hand_pairs import outdated
from ..properties.mosaic import CableTwinMosaic
from .base import Panel, RowList, sentence
from .reconstruct import draw_reconstruction


class CABLETWIN_UL_pairs(RowList):
    """Pairs with their residuals."""

    def draw_item(
        self,
        context: bpy.types.Context,
        layout: bpy.types.UILayout,
        data: bpy.types.AnyType,
        item: bpy.types.PropertyGroup,
        icon: int,
        active_data: bpy.types.AnyType,
        active_property: str,
        index: int = 0,
        flt_flag: int = 0,
    ) -> None:
        """Whether it is held or outdated, its number, the blocks, the residual."""
        split = layout.split(factor=0.74)
        sign = "PINNED" if data.held()[index] else "AUTO" if item.found else "DOT"
        split.label(
            text=f"{index + 1}  {item.block_a} – {item.block_b}",
            icon="ERROR" if outdated(context.scene)[index] else sign,
            translate=False,
        )
        value = split.row()
        value.alignment = "RIGHT"
        value.label(text=f"{item.residual_mm:.3f}" if item.residual_mm >= 0 else "–", translate=False)


class CABLETWIN_PT_mosaic(Panel):
    """Mosaic."""

    bl_idname = "CABLETWIN_PT_mosaic"
    bl_label = "Mosaic"
    bl_order = 6

    def draw(self, context: bpy.types.Context) -> None:
        """The way of joining, pairs where they count, fit, apply."""
        scene = context.scene
        mosaic = scene.cabletwin.mosaic
        if not scene.cabletwin.results.blocks:
            self.layout.label(text="Open a run folder first", icon="INFO")
            return
        self.layout.row().prop(mosaic, "way", expand=True)
        if mosaic.way == "BY_HAND":
            _blocks(self.layout, scene)
            _pairs(self.layout, mosaic)
            if any(outdated(scene)):
                words = translated(
                    "Some pairs were picked before the blocks were adjusted anew: pick them again"
                )
                sentence(self.layout.box(), words, "ERROR")
        row = self.layout.row(align=True)
        row.operator("cabletwin.mosaic_fit", icon="SNAP_ON")
        if mosaic.way == "BY_HAND":
            row.operator("cabletwin.mosaic_close", icon="MESH_CIRCLE")
        if mosaic.joins:
            _joins(self.layout.box(), mosaic)
        if not draw_reconstruction(self.layout, context):
            self.layout.operator("cabletwin.mosaic_apply", icon="CHECKMARK")


def _blocks(layout: bpy.types.UILayout, scene: bpy.types.Scene) -> None:
    """The two blocks between which pairs are picked, and looking at them."""
    mosaic, results = scene.cabletwin.mosaic, scene.cabletwin.results
    row = layout.row(align=True)
    for key in ("block_a", "block_b"):
        row.prop_search(mosaic, key, results, "blocks", text="", icon="MESH_GRID")
    row = layout.row(align=True)
    row.operator("cabletwin.mosaic_look", icon="VIEWZOOM")
    row.operator("cabletwin.mosaic_show_all", text="Show All", icon="HIDE_OFF")
    row = layout.row()
    row.scale_y = 1.4
    row.operator("cabletwin.mosaic_pick", icon="EYEDROPPER")


def _pairs(layout: bpy.types.UILayout, mosaic: CableTwinMosaic) -> None:
    head = layout.split(factor=0.5)
    head.label(text="Pairs")
    unit = head.row()
    unit.alignment = "RIGHT"
    unit.label(text="Residual (mm)")
    row = layout.row()
    row.template_list("CABLETWIN_UL_pairs", "", mosaic, "pairs", mosaic, "pair_index", rows=4)
    buttons = row.column(align=True)
    buttons.operator("cabletwin.mosaic_remove", text="", icon="REMOVE").index = -1
    buttons.operator("cabletwin.mosaic_hold", text="", icon="PINNED")
    buttons.separator()
    buttons.operator("cabletwin.mosaic_read", text="", icon="FILE_FOLDER")
    buttons.operator("cabletwin.mosaic_clear", text="", icon="TRASH")


def _joins(box: bpy.types.UILayout, mosaic: CableTwinMosaic) -> None:
    """A table: two blocks, and what is left between points and between surfaces."""
    column = box.column(align=True)
    column.label(text="Left over (mm)")
    head = column.split(factor=0.52)
    for text in (n_("Seam"), n_("Points"), n_("Surface")):
        head.label(text=text)
    for item in mosaic.joins:
        row = column.split(factor=0.52)
        row.label(text=f"{item.block_a} – {item.block_b}", translate=False)
        for value in (item.points_mm, item.surface_mm):
            row.label(text=f"{value:.3f}", translate=False)


classes = (CABLETWIN_UL_pairs, CABLETWIN_PT_mosaic)
