"""The panel *Results*: what a run folder holds, collection by collection."""

import bpy
from bpy.app.translations import pgettext_iface as translated

from ..results import collections
from .base import Panel, aligned, eyes, sentence


class CABLETWIN_PT_results(Panel):
    """Results."""

    bl_idname = "CABLETWIN_PT_results"
    bl_label = "Results"
    bl_order = 4

    def draw(self, context: bpy.types.Context) -> None:
        """Open, show and hide, figures of the blocks."""
        scene = context.scene
        results = scene.cabletwin.results
        row = self.layout.row(align=True)
        row.operator("cabletwin.results_choose", text="Open Folder", icon="FILE_FOLDER")
        again = row.row(align=True)
        again.enabled = bool(scene.cabletwin.run.folder)
        again.operator("cabletwin.results_open", text="Reload", icon="FILE_REFRESH")
        if results.segments > 1:
            row = aligned(self.layout).row()
            row.prop(scene.cabletwin.run, "segment")
            row.label(text=f"/ {results.segments}", translate=False)
        if not results.blocks:
            self.layout.label(text="Nothing is shown yet", icon="INFO")
            return
        eyes(self.layout, context, collections)
        _blocks(self.layout, results)
        for warning in filter(None, results.warnings.split("\n")):
            sentence(self.layout.box(), warning, "ERROR")


def _blocks(layout: bpy.types.UILayout, results: bpy.types.PropertyGroup) -> None:
    """A table: block, frames calibrated, reprojection error."""
    box = layout.box()
    head = box.row()
    head.label(text="Block")
    head.label(text="Calibrated")
    head.label(text="Error (px)")
    for block in results.blocks:
        row = box.row()
        row.label(text=block.name, translate=False)
        row.label(text=translated("{} of {}").format(block.calibrated, block.images), translate=False)
        row.label(text=f"{block.reprojection_px:.3f}" if block.reprojection_px >= 0 else "–", translate=False)


classes = (CABLETWIN_PT_results,)
