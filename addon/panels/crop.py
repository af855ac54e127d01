"""The panel *Crop*: options of the stage, its preview, apply."""

import bpy
from bpy.app.translations import pgettext_n as n_

from .base import Panel, aligned, sentence
from .reconstruct import draw_reconstruction


class CABLETWIN_PT_crop(Panel):
    """Crop."""

    bl_idname = "CABLETWIN_PT_crop"
    bl_label = "Crop"
    bl_order = 5

    def draw(self, context: bpy.types.Context) -> None:
        """Options, preview, apply and reset, or the progress of what apply started."""
        scene = context.scene
        crop = scene.cabletwin.crop
        column = aligned(self.layout)
        column.enabled = not context.window_manager.cabletwin_job.running
        column.prop(crop, "incidence", slider=True)
        column.prop(crop, "least_score", slider=True)
        column.prop(crop, "fringe")
        for use, value, text in (("use_start", "start", n_("Start at")), ("use_end", "end", n_("End at"))):
            row = column.row(heading=text)
            row.prop(crop, use, text="")
            inside = row.row()
            inside.enabled = getattr(crop, use)
            inside.prop(crop, value, text="")
        self.layout.operator(
            "cabletwin.crop_preview",
            text="End Preview" if crop.previewing else "Preview",
            icon="HIDE_OFF" if crop.previewing else "HIDE_ON",
            depress=crop.previewing,
        )
        if crop.message:
            sentence(self.layout.box(), crop.message, "ERROR")
        if crop.previewing:
            _shares(self.layout.box(), crop)
        if draw_reconstruction(self.layout, context):
            return
        row = self.layout.row(align=True)
        row.operator("cabletwin.crop_apply", icon="CHECKMARK")
        row.operator("cabletwin.crop_reset", icon="LOOP_BACK")


def _shares(box: bpy.types.UILayout, crop: bpy.types.PropertyGroup) -> None:
    """How much of each block stays."""
    head = box.row()
    for text in (n_("Block"), n_("Stays")):
        head.label(text=text)
    for item in crop.shares:
        row = box.row()
        row.label(text=item.name, translate=False)
        row.label(text=f"{100 * item.share:.1f} %", translate=False)


classes = (CABLETWIN_PT_crop,)
